// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <span>

#include "pipescout/driving/driving_parameters.hpp"
#include "pipescout/driving/local_costmap.hpp"
#include "pipescout/navigation_maps/footprint.hpp"
#include "pipescout/navigation_maps/path.hpp"
#include "pipescout/navigation_maps/pose2d.hpp"

namespace pipescout::navigation {

/// What the robot does.
enum class DriveState {
  kIdle,       ///< it has no path
  kDriving,    ///< along the path
  kSteering,   ///< it stands and turns its wheels for what comes
  kWaiting,    ///< it stands, and goes on by itself when the reason is gone
  kBackingUp,  ///< back along the path
  kReached,    ///< the goal, position and heading
  kFailed,     ///< it stands until it gets another path
};

/// Why it is slower than the path allows, stands or gives up. Closed: nothing else stops it.
enum class DriveReason {
  kNone,
  kPaused,
  kSpeedLimit,           ///< somebody asked for it, for example the inspection
  kObstacleNear,         ///< in the slow zone
  kPathBlocked,          ///< by what stands on the path
  kMovingObstacle,       ///< something will cross the path
  kLocalisationMissing,  ///< none has come
  kLocalisationStale,
  kLocalisationUncertain,
  kScanMissing,
  kScanStale,
  kScanFrozen,        ///< the lidar repeats the same scan
  kTooManyObstacles,  ///< more occupied cells near it than it can look at
  kOffPath,           ///< it stands farther off the path than largest_error
  kGoalMissed,        ///< after goal_attempts
};
[[nodiscard]] const char* to_string(DriveState state);
[[nodiscard]] const char* to_string(DriveReason reason);

/// What became of an input.
enum class DriveInput { kTaken, kNotFinite, kOutOfOrder, kBadGeometry };
[[nodiscard]] const char* to_string(DriveInput input);

struct Localisation {
  double time = 0;           ///< s
  Pose2d pose;               ///< T_map_robot
  double speed = 0;          ///< m/s, forwards
  double yaw_rate = 0;       ///< rad/s
  double sigma = 0;          ///< m, of the position, the largest direction
  double heading_sigma = 0;  ///< rad
};

struct DriveCommand {
  double speed = 0;      ///< m/s, negative in reverse
  double curvature = 0;  ///< 1/m, positive to the left of a robot that looks forwards
  DriveState state = DriveState::kIdle;
  DriveReason reason = DriveReason::kNone;
  bool replan = false;       ///< waiting and backing up did not help: another path is needed
  double travelled = 0;      ///< m, arc length on the path
  double remaining = 0;      ///< m, along the path
  double lateral_error = 0;  ///< m, to the left of the path
  double heading_error = 0;  ///< rad
  double offset = 0;         ///< m, to the left, at which it passes an obstacle
  double free_distance = 0;  ///< m, predicted without an obstacle
};

/// Drives an Ackermann robot along a path: feedback of lateral and heading error in the arc length
/// (the chained form of Samson, "Control of chained systems", IEEE TAC 40, 1995, linearised), the
/// same for both directions of travel, from the pose predicted over the vehicle's delay. Each cycle
/// predicts the whole motion over the horizon among static and moving obstacles; the speed is never
/// larger than that from which the robot stops, delay included, before the first contact. An
/// obstacle beside or on the path is passed at a lateral offset if there is room; otherwise it
/// waits, backs up once, and then asks for another path.
///
/// The footprint counts as its bounding rectangle in the robot's frame. What the lidar cannot see
/// and what moves faster than predicted are not covered.
class LocalPlanner {
 public:
  /// Throws std::invalid_argument.
  LocalPlanner(const DrivingParameters& parameters, const LocalCostmapParameters& costmap,
               const Footprint& footprint);
  ~LocalPlanner();
  LocalPlanner(LocalPlanner&&) noexcept;
  LocalPlanner& operator=(LocalPlanner&&) noexcept;

  /// Drives it from the start. Throws std::invalid_argument for an empty path, for curvatures
  /// beyond the steering's, and for steps longer than 1 m. Allocates.
  void set_path(const Path& path);
  /// Stops, and is idle.
  void clear_path();
  void pause(bool paused);
  /// m/s, [0, inf): no faster from now on; infinite for none. NaN counts as 0.
  void limit_speed(double speed);
  /// m to the left of the path, within largest_offset: where it drives if it has the choice.
  void prefer_offset(double offset);
  /// Drives back to an arc length of the path, but not beyond the last cusp, and from there on
  /// again. Returns where to; nothing, and nothing happens, where this is ahead or NaN, or there is
  /// no path that is being driven.
  std::optional<double> go_back_to(double arc_length);

  DriveInput add(const Localisation& localisation);
  /// `T_robot_lidar`: where the lidar is mounted.
  DriveInput add(const ScanView& scan, const Pose2d& T_robot_lidar);
  /// Centres of occupied cells, of about the resolution of the costmap, that other sensors see; m
  /// in the map. In place of those before, until forget_after of the costmap. Of more than
  /// most_obstacle_cells the robot stops. Allocates nothing.
  void set_obstacles(std::span<const Point2d> cells, double time);

  /// The command for the next period. `now` in s, the clock of the stamps. Allocates nothing.
  [[nodiscard]] DriveCommand cycle(double now);

  /// Why the robot must stand whatever its path; kNone if it may drive.
  [[nodiscard]] DriveReason fault(double now) const;
  /// The last one moved on to `now` by its rates; nothing before the first.
  [[nodiscard]] std::optional<Localisation> localisation(double now) const;
  [[nodiscard]] const LocalCostmap& costmap() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::navigation
