// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipescout/rack_vision/offset_filter.hpp"

/// The pipes' distances estimated in flight: Lippiello and Cacace, Figure 8, and pipes that move.
namespace pipescout::rack_study {

enum class OffsetScenario : std::uint8_t {
  /// Figure 8: the model has the summed distances at 15, 35 and 50 cm, they are 10, 20 and 30.
  kWrongModel,
  /// The model is right; in the fifth second pipe 3 is pushed by 3 cm at once, and from then on
  /// pipe 4 creeps by 0.2 mm/s.
  kMovingPipes,
};

struct OffsetRunSettings {
  OffsetScenario scenario = OffsetScenario::kWrongModel;
  bool noise = false;  ///< quantised pixels and 2 px
  std::size_t frames = 250;
};

/// Of the three pipes that may move, per frame.
struct OffsetFrame {
  double largest_error = 0;  ///< m
  double step_error = 0;     ///< m, of the pipe that is pushed
  double consistency = 0;    ///< error^T covariance^-1 error of the three
};

/// Frame by frame through the flight of `paper_flight`, four pipes, 25 texture points on each:
/// solver and filter together, beginning 20 cm uncertain (kWrongModel) or 2 mm (kMovingPipes).
[[nodiscard]] std::vector<OffsetFrame> run_offsets(const OffsetRunSettings& settings,
                                                   std::uint64_t seed);

inline constexpr std::size_t kPushedAtFrame = 125;

/// Frames until the largest error stays at or below `limit`; `from`: counted from this frame on.
/// The number of all frames when it does not.
[[nodiscard]] std::size_t frames_until(const std::vector<OffsetFrame>& run,
                                       double OffsetFrame::*error, double limit,
                                       std::size_t from = 0);

}  // namespace pipescout::rack_study
