// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "pipescout/rack_vision/way_points.hpp"

/// The flight along a path of way-points, as it goes: the path is a function of its own time, and
/// this decides how that time runs while the vehicle flies, is blown off, or does not know where it
/// is.
namespace pipescout::rack_vision {

struct WayPointMissionParameters {
  ReachedTolerance tolerance{};
  double reached_for = 0.5;  ///< s, [0, 60]: within the tolerance without a break
  /// [0, 10]: so many standard deviations of the pose must be within the tolerance too: a vehicle
  /// that does not know its place so well cannot know that it is there.
  double deviations_within = 2;
  /// m, [0, 2]; 0: none. Radius of the round that a vehicle flies which is at its way-point, as far
  /// as it knows, but does not know it so well: a camera that hovers sees no more than it has seen.
  /// The round lies across the rack (x and z), begins and ends at the way-point and is nowhere
  /// lower; the next one goes the other way about.
  double look_around = 0;
  double look_around_speed = 0.4;  ///< m/s, (0, 20]: largest on the round
  /// s, [0, 3600]: how long it waits at a way-point, after its hold, to reach it; then it is missed
  /// and the flight goes on.
  double patience = 30;
  /// m, (0, 100]: the path waits while the vehicle is farther from it, so that it never runs away:
  /// at the start, and after a loss.
  double largest_lag = 0.3;
  double largest_yaw_lag = 0.5;  ///< rad, (0, pi]: as above

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

enum class WayPointOutcome : unsigned char { kPending, kReached, kMissed };

/// Where a vehicle was; only what the mission looks at.
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

  /// Brings the mission to the time `now`, s of any clock. `pose`: the last one that is known, or
  /// nothing while it is not: then the path waits. A time before that of the last call counts as
  /// that one; NaN is ignored, as is a pose that holds NaN.
  void advance(double now, const std::optional<LevelPose>& pose);

  /// What the path asked for at `time`, s of the clock of `advance`, at most a second before the
  /// last `advance`: for the error of a pose that was measured then. While the path waits, the
  /// velocity and acceleration of the point are 0.
  [[nodiscard]] PathPoint target(double time) const noexcept;

  [[nodiscard]] bool waiting() const noexcept { return waiting_; }  ///< the path's time stands
  [[nodiscard]] bool complete() const noexcept { return complete_; }
  [[nodiscard]] double path_time() const noexcept { return path_time_; }  ///< s
  /// Index of the way-point that it stays at, or flies to.
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
  /// Adds where the round has got to.
  void add_round(double round_time, PathPoint& point) const noexcept;

  WayPointPath path_;
  WayPointMissionParameters parameters_;
  std::vector<WayPointOutcome> outcomes_;
  std::optional<double> now_;
  std::optional<double> within_since_;  ///< of the clock: within the tolerance without a break
  double running_since_ = 0;            ///< of the clock: before this, the path stood
  double path_time_ = 0;
  double waited_ = 0;                 ///< s at this way-point beyond its hold
  std::optional<double> round_time_;  ///< s on the round that it flies
  bool round_runs_ = false;           ///< else it waits, as the path does
  bool to_the_right_ = true;          ///< of the next round: first towards +x
  std::size_t current_ = 0;
  bool waiting_ = true;
  bool complete_ = false;
};

}  // namespace pipescout::rack_vision
