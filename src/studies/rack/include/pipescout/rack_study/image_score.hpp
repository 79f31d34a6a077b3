// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "pipescout/rack_study/image_flight.hpp"

/// Scores of flights over rendered racks.
namespace pipescout::rack_study {

/// A pose farther off than this is wrong: it would steer a vehicle into what it inspects.
inline constexpr double kWrongPosition = 0.03;                  ///< m
inline constexpr double kWrongRotation = 0.017453292519943295;  ///< rad

[[nodiscard]] bool is_wrong(const FrameScore& frame) noexcept;

/// Images outside outages.
struct ImageFlightScore {
  std::size_t images = 0;
  std::size_t with_pose = 0;  ///< tracked
  std::size_t wrong = 0;      ///< of them: `is_wrong`
  /// Of them: the truth lies in the ellipsoid of the place, and of the whole pose, that should hold
  /// it in 95 of 100 cases.
  std::size_t position_covered = 0;
  std::size_t pose_covered = 0;
  std::size_t pose_covered_99 = 0;      ///< of the whole pose, in that of 99 of 100
  std::size_t silent_wrong = 0;         ///< `is_wrong`, and not in that of 99 of 100
  std::vector<double> position_errors;  ///< m, of those with a pose, in time order
  std::vector<double> rotation_errors;  ///< rad, the same

  ImageFlightScore& operator+=(const ImageFlightScore& other);
  [[nodiscard]] double with_pose_percent() const noexcept;  ///< 100 of no images
};

[[nodiscard]] ImageFlightScore score_flight(std::span<const FrameScore> frames);

/// How much the error along the pipes changed from the first image with a pose to the last, as a
/// share of the way along them between the two, percent. Each end is the mean over 10 images, so
/// that noise is not taken for drift. Infinite when there are fewer than 20 images with a pose, or
/// the last of the flight has none.
[[nodiscard]] double along_drift_percent(std::span<const FrameScore> frames);

/// What came of a forced loss.
struct Recovery {
  bool declared = false;  ///< some image of the outage, or the first one after it, had no pose
  bool wrong = false;     ///< a pose was wrong, from the begin of the outage on
  /// s from the first image after the outage to the first with a pose that is not wrong; nothing
  /// when there is none in the flight.
  std::optional<double> time{};
};

[[nodiscard]] Recovery score_recovery(std::span<const FrameScore> frames);

/// Of images taken between two places along the pipes.
struct StretchScore {
  std::size_t images = 0;
  std::size_t with_pose = 0;
  std::size_t covered = 0;     ///< as ImageFlightScore::position_covered
  double largest_error = 0;    ///< m, along the pipes
  double first_deviation = 0;  ///< m, stated, along the pipes, when it came in
  double last_deviation = 0;   ///< m, when it left
};

[[nodiscard]] StretchScore score_stretch(std::span<const FrameScore> frames, double from,
                                         double to);

}  // namespace pipescout::rack_study
