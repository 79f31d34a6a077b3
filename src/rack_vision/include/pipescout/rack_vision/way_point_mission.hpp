// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "pipescout/rack_vision/way_points.hpp"

/// Progress of a flight along a path of way-points: the path is a function of path time, and this
/// class advances or stops path time depending on the deviation and the pose of the vehicle.
namespace pipescout::rack_vision {

struct WayPointMissionParameters {
  ReachedTolerance tolerance{};
  double reached_for = 0.5;  ///< s, [0, 60]: within the tolerance without a break
  /// [0, 10]: this many standard deviations of the pose must be within the tolerance too, because
  /// an uncertain pose cannot confirm that the way-point is reached.
  double deviations_within = 2;
  /// m, [0, 2]; 0: none. Radius of the circle that the vehicle flies at its way-point while its
  /// pose is too uncertain: hovering adds no new views. The circle is in the plane across the rack
  /// (x and z), begins and ends at the way-point and is never below it; successive circles
  /// alternate in direction.
  double look_around = 0;
  double look_around_speed = 0.4;  ///< m/s, (0, 20]: largest on the circle
  /// s, [0, 3600]: longest wait at a way-point, after its hold, until it is reached; then it is
  /// missed and the flight continues.
  double patience = 30;
  /// m, (0, 100]: the path waits while the vehicle is farther from it, for example at the start and
  /// after a loss.
  double largest_lag = 0.3;
  double largest_yaw_lag = 0.5;  ///< rad, (0, pi]: as above

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

enum class WayPointOutcome : unsigned char { kPending, kReached, kMissed };

/// Pose of the vehicle, as far as the mission uses it.
struct LevelPose {
  double time = 0;                                     ///< s
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< rack frame, m
  double yaw = 0;                                      ///< rad
  double position_deviation = 0;  ///< m, standard deviation along the direction known least
  double yaw_deviation = 0;       ///< rad
};

/// Allocates nothing after construction. Not for use by several threads at once.
class WayPointMission {
 public:
  /// Throws as WayPointMissionParameters::validate.
  WayPointMission(WayPointPath path, const WayPointMissionParameters& parameters);

  /// Advances the mission to the time `now`, s of any clock. `pose`: the last known one, or
  /// nothing: then the path waits. A time before that of the last call is treated as equal to it;
  /// NaN is ignored, as is a pose with NaN.
  void advance(double now, const std::optional<LevelPose>& pose);

  /// Target of the path at `time`, s of the clock of `advance`, at most a second before the last
  /// `advance`: for the error of a pose measured then. While the path waits, the velocity and
  /// acceleration of the point are 0.
  [[nodiscard]] PathPoint target(double time) const noexcept;

  [[nodiscard]] bool waiting() const noexcept { return waiting_; }  ///< path time is stopped
  [[nodiscard]] bool complete() const noexcept { return complete_; }
  [[nodiscard]] double path_time() const noexcept { return path_time_; }  ///< s
  /// Index of the current way-point, where it stays or to which it flies.
  [[nodiscard]] std::size_t current() const noexcept { return current_; }
  [[nodiscard]] const std::vector<WayPointOutcome>& outcomes() const noexcept { return outcomes_; }
  [[nodiscard]] std::size_t count(WayPointOutcome outcome) const noexcept;
  [[nodiscard]] const WayPointPath& path() const noexcept { return path_; }

 private:
  [[nodiscard]] bool keeps_up(const LevelPose& pose) const noexcept;
  [[nodiscard]] bool knows_well_enough(const LevelPose& pose) const noexcept;
  [[nodiscard]] bool is_there(const LevelPose& pose) const noexcept;
  void judge(double interval, const LevelPose& pose);
  [[nodiscard]] double round_duration() const noexcept;  ///< s
  /// Adds the position on the circle.
  void add_round(double round_time, PathPoint& point) const noexcept;

  WayPointPath path_;
  WayPointMissionParameters parameters_;
  std::vector<WayPointOutcome> outcomes_;
  std::optional<double> now_;
  std::optional<double> within_since_;  ///< of the clock: within the tolerance without a break
  double running_since_ = 0;            ///< of the clock: before this, path time was stopped
  double path_time_ = 0;
  double waited_ = 0;                 ///< s at this way-point beyond its hold
  std::optional<double> round_time_;  ///< s on the current circle
  bool round_runs_ = false;           ///< else it waits, as the path does
  bool to_the_right_ = true;          ///< of the next circle: first towards +x
  std::size_t current_ = 0;
  bool waiting_ = true;
  bool complete_ = false;
};

}  // namespace pipescout::rack_vision
