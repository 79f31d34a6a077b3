// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "moving_obstacles.hpp"
#include "pipescout/driving/local_planner.hpp"

namespace pipescout::navigation {

/// Localisation and scans, and whether they can be driven by.
class DriveInputs {
 public:
  DriveInputs(const DrivingParameters& parameters, const LocalCostmapParameters& costmap);

  DriveInput add(const Localisation& localisation);
  DriveInput add(const ScanView& scan, const Pose2d& T_robot_lidar);
  /// Why the robot must stand; kNone if it may drive.
  [[nodiscard]] DriveReason fault(double now) const;
  /// The pose at a time, from the last one and its rates.
  [[nodiscard]] Pose2d pose_at(double time) const;
  [[nodiscard]] double speed() const { return localisation_ ? localisation_->speed : 0; }
  [[nodiscard]] const LocalCostmap& costmap() const { return costmap_; }
  [[nodiscard]] const MovingObstacles& obstacles() const { return obstacles_; }

 private:
  DrivingParameters parameters_;
  std::optional<Localisation> localisation_;
  std::optional<double> scan_time_;
  std::uint64_t last_scan_ = 0;  ///< hash of its ranges
  int equal_scans_ = 0;
  LocalCostmap costmap_;
  MovingObstacles obstacles_;
};

}  // namespace pipescout::navigation
