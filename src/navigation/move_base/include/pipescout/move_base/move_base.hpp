// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pipescout/driving/coverage_map.hpp"
#include "pipescout/driving/inspection_speed.hpp"
#include "pipescout/driving/local_planner.hpp"
#include "pipescout/move_base/navigation_goal.hpp"

namespace pipescout::navigation {

struct MoveBaseParameters {
  DrivingParameters driving;
  LocalCostmapParameters costmap;
  InspectionParameters inspection;
  double view_angle = 0.44;      ///< rad, (0, 3]: how much of a pipe the camera sees, along it
  double track_stale_after = 1;  ///< s, (0, 60]
  double coverage_cell = 0.1;    ///< m, [0.01, 10]
  double lost_after = 60;        ///< s, [0, 3600]: standing for an input, until the goal fails
  double replan_after = 3;       ///< s, [0, 600]: between plans around what blocks the path
  int replans = 6;               ///< [0, 1000]: in a row, without progress
  double progress = 5;           ///< m, (0, 1000]: after which plans are counted from 0 again
  double obstacle_radius = 12;   ///< m, (0, 100]: seen obstacles nearer than that are planned with

  /// Throws std::invalid_argument that names the field.
  void validate() const;
};

/// What the tracker of a pipe says of one image.
struct PipeObservation {
  double time = 0;        ///< s
  bool tracked = false;   ///< seen in this image
  double confidence = 0;  ///< [0, 1]
  double range = 0;       ///< m to the pipe; not positive or not finite: unknown
  double temperature = std::numeric_limits<double>::quiet_NaN();  ///< degrees Celsius
};

enum class MoveState {
  kIdle,
  kPlanning,  ///< it stands, and waits for a path, or for inputs to plan from
  kDriving,   ///< or waiting with a path; the command says which
  kSucceeded,
  kFailed,
};
[[nodiscard]] const char* to_string(MoveState state);

struct MoveStatus {
  DriveCommand command;
  MoveState state = MoveState::kIdle;
  NavigationFailure failure = NavigationFailure::kNone;
  std::string text;         ///< more of the failure
  DriveReason waits_for{};  ///< input without which no path is planned
  InspectionReason inspection = InspectionReason::kNone;
  int replans = 0;                   ///< for this goal
  double remaining = 0;              ///< m of the path
  std::size_t passed = 0;            ///< marks of the plan: rows, nodes
  std::optional<std::int64_t> mark;  ///< id of the row that is driven along
};

/// Links the global and the local planner ("move base" of Ibarguren and others, 2013, section 4.2):
/// takes goals, asks for plans, drives them, asks for others around what blocks the path, and ends
/// each goal with success or a reason. It calls no planner itself: whoever owns it takes the
/// request, plans wherever there is time, and gives the plan; commands go on meanwhile.
class MoveBase {
 public:
  /// Throws std::invalid_argument.
  MoveBase(const MoveBaseParameters& parameters, const Footprint& footprint);
  ~MoveBase();
  MoveBase(MoveBase&&) noexcept;
  MoveBase& operator=(MoveBase&&) noexcept;

  /// Stops the goal before, if there is one, and goes for this one.
  void start(const NavigationGoal& goal);
  /// Comes to a stop; kFailed with `why`, unless there is no goal.
  void stop(NavigationFailure why);
  void pause(bool paused);

  DriveInput add(const Localisation& localisation);
  DriveInput add(const ScanView& scan, const Pose2d& T_robot_lidar);
  /// False for a time that is not finite or not later than the last one.
  bool add(const PipeObservation& observation);
  /// Centres of occupied cells that other sensors see, m in the map, in place of those before.
  void set_obstacles(std::span<const Point2d> cells, double time);
  /// The map, or what is closed in it, has changed: the robot stops and goes on by another plan.
  void plan_again();
  /// The finding that the inspector is not sure of, where the robot is: passed again from nearer.
  void doubtful_finding();

  /// What is to be planned; each request once.
  [[nodiscard]] std::optional<PlanRequest> take_request();
  /// The answer; of another number than the last request's it is ignored.
  void give(const NavigationPlan& plan);

  /// In each period. `now` in s, the clock of the stamps.
  [[nodiscard]] MoveStatus cycle(double now);

  /// Of the last plan.
  [[nodiscard]] const NavigationPlan& plan() const;
  [[nodiscard]] const LocalPlanner& local_planner() const;
  /// What was seen of the rows, by the ids of their edges, m along them.
  [[nodiscard]] const CoverageMap& coverage() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::navigation
