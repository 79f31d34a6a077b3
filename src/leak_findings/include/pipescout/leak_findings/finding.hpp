// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "pipescout/thermal/leak_detector.hpp"

/// What is known of a leak: a value that can be stored, and given back on another day. Times in
/// seconds of one clock for all days; lengths in m, in the frame `map`; temperatures in degC, their
/// differences in K.
namespace pipescout::leak_findings {

enum class FindingState : std::uint8_t {
  kCandidate,  ///< there is evidence, but not enough
  kRaised,     ///< it is believed to be a leak
  kCleared,    ///< it was raised, and then looked at without being seen
};
/// "candidate", "raised", "cleared"; "unknown" for a value that is no enumerator.
[[nodiscard]] std::string_view to_string(FindingState state) noexcept;

/// With a probability of 0.95 the value lies in it.
struct Interval {
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
};

/// Where the middle of a leak is.
struct MapPosition {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m^2
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< of the pipe there, unit
};

/// What one drive past has shown.
struct PassSummary {
  double time = 0;             ///< of its first frame
  std::size_t frames = 0;      ///< with the leak in view and detected
  double delta = 0;            ///< K
  double delta_deviation = 0;  ///< K, that it may be off, standard
  double peak_delta = 0;       ///< K, the largest of a frame
  double length = 0;           ///< NaN: not known
  double length_deviation = 0;
  std::optional<MapPosition> position{};
};

/// The frame that shows a leak best: whole, large and near the middle of the picture.
struct BestView {
  double time = 0;
  std::uint64_t frame = 0;                          ///< as `Frame::number`
  Eigen::Vector2d start = Eigen::Vector2d::Zero();  ///< pixels, of the leak on the axis
  Eigen::Vector2d end = Eigen::Vector2d::Zero();    ///< pixels
  double half_width = 0;                            ///< pixels, of the pipe
  double score = 0;                                 ///< larger is better
};

struct Finding {
  std::uint64_t id = 0;  ///< the same on every day, from 1 on
  FindingState state = FindingState::kCandidate;
  double probability = 0;  ///< that it is a leak
  thermal::Severity severity = thermal::Severity::kMinor;
  double first_time = 0;
  double last_time = 0;
  std::size_t frames = 0;  ///< in which it was detected
  double mean_delta = 0;   ///< K above the sound pipe, mean over the leak, of the latest pass
  Interval mean_delta_interval{};
  double peak_delta = 0;  ///< K, the warmest place, of the latest pass
  Interval peak_delta_interval{};
  double length = std::numeric_limits<double>::quiet_NaN();  ///< along the pipe; NaN: not known
  double length_deviation = std::numeric_limits<double>::quiet_NaN();
  /// Of all passes; nothing when no frame came with a pose, or the range is not known.
  std::optional<MapPosition> position{};
  /// K/h of `mean_delta` and m/h of `length` over the passes, by least squares; NaN with one.
  double delta_growth = std::numeric_limits<double>::quiet_NaN();
  double length_growth = std::numeric_limits<double>::quiet_NaN();
  BestView best{};
  /// The latest `LeakFindingsParameters::max_passes`, oldest first, the one that goes on included.
  std::vector<PassSummary> passes{};
  std::size_t pass_count = 0;  ///< of all
};

enum class EventKind : std::uint8_t { kRaised, kUpdated, kCleared };
/// "raised", "updated", "cleared"; "unknown" for a value that is no enumerator.
[[nodiscard]] std::string_view to_string(EventKind kind) noexcept;

}  // namespace pipescout::leak_findings
