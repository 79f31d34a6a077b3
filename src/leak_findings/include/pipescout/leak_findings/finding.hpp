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

/// A finding: the estimates of one leak, as a value that can be stored and loaded again on another
/// day. Times in seconds of one clock for all days; lengths in m, in the frame `map`; temperatures
/// in degC, their differences in K.
namespace pipescout::leak_findings {

enum class FindingState : std::uint8_t {
  kCandidate,  ///< insufficient evidence so far
  kRaised,     ///< accepted as a leak
  kCleared,    ///< it was raised, and then not detected while in view
};
/// "candidate", "raised", "cleared"; "unknown" for any other value.
[[nodiscard]] std::string_view to_string(FindingState state) noexcept;

/// 95 % interval of a value.
struct Interval {
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
};

/// Position of the middle of a leak.
struct MapPosition {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m^2
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< of the pipe there, unit
};

/// Observations of one pass.
struct PassSummary {
  double time = 0;             ///< of its first frame
  std::size_t frames = 0;      ///< with the leak in view and detected
  double delta = 0;            ///< K
  double delta_deviation = 0;  ///< K, its standard deviation
  double peak_delta = 0;       ///< K, the largest of a frame
  double length = 0;           ///< NaN: unknown
  double length_deviation = 0;
  std::optional<MapPosition> position{};
};

/// The best frame of a leak: whole, large and near the middle of the image.
struct BestView {
  double time = 0;
  std::uint64_t frame = 0;                          ///< as `Frame::number`
  Eigen::Vector2d start = Eigen::Vector2d::Zero();  ///< pixels, of the leak on the axis
  Eigen::Vector2d end = Eigen::Vector2d::Zero();    ///< pixels
  double half_width = 0;                            ///< pixels, of the pipe
  double score = 0;                                 ///< larger is better
};

struct Finding {
  std::uint64_t id = 0;  ///< permanent, from 1 on
  FindingState state = FindingState::kCandidate;
  double probability = 0;  ///< that it is a leak
  thermal::Severity severity = thermal::Severity::kMinor;
  double first_time = 0;
  double last_time = 0;
  std::size_t frames = 0;  ///< in which it was detected
  double mean_delta = 0;   ///< K above the sound pipe, mean over the leak, of the latest pass
  Interval mean_delta_interval{};
  double peak_delta = 0;  ///< K, at the warmest point, of the latest pass
  Interval peak_delta_interval{};
  double length = std::numeric_limits<double>::quiet_NaN();  ///< along the pipe; NaN: unknown
  double length_deviation = std::numeric_limits<double>::quiet_NaN();
  /// From all passes; nothing when no frame had a pose, or the range is unknown.
  std::optional<MapPosition> position{};
  /// K/h of `mean_delta` and m/h of `length` over the passes, by least squares; NaN with one.
  double delta_growth = std::numeric_limits<double>::quiet_NaN();
  double length_growth = std::numeric_limits<double>::quiet_NaN();
  BestView best{};
  /// The latest `LeakFindingsParameters::max_passes`, oldest first, including the current one.
  std::vector<PassSummary> passes{};
  std::size_t pass_count = 0;  ///< of all
};

enum class EventKind : std::uint8_t { kRaised, kUpdated, kCleared };
/// "raised", "updated", "cleared"; "unknown" for any other value.
[[nodiscard]] std::string_view to_string(EventKind kind) noexcept;

}  // namespace pipescout::leak_findings
