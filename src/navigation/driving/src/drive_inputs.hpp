// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "moving_obstacles.hpp"
#include "pipescout/driving/local_planner.hpp"

namespace pipescout::navigation {

/// Localisation and scans, and whether they can be driven by.
class DriveInputs {
 public:
  DriveInputs(const DrivingParameters& parameters, const LocalCostmapParameters& costmap);

  DriveInput add(const Localisation& localisation);
  DriveInput add(const ScanView& scan, const Pose2d& T_robot_lidar);
  void set_obstacles(std::span<const Point2d> cells, double time);
  /// The clock was set back: what was before cannot be compared with what comes, and is forgotten.
  void forget();
  /// Cells that were told and are not forgotten.
  [[nodiscard]] std::span<const Point2d> told_cells(double now) const;
  /// False when more were told than can be kept.
  [[nodiscard]] bool has_room() const { return !too_many_told_; }
  /// Why the robot must stand; kNone if it may drive.
  [[nodiscard]] DriveReason fault(double now) const;
  /// The pose at a time, from the last one and its rates.
  [[nodiscard]] Pose2d pose_at(double time) const;
  /// The last one with its pose at a time; nothing before the first.
  [[nodiscard]] std::optional<Localisation> localisation(double time) const;
  [[nodiscard]] double speed() const { return localisation_ ? localisation_->speed : 0; }
  /// m/s to the left: how fast it slips sideways while it drives, downhill for example; as far as
  /// that is sure.
  [[nodiscard]] double drift() const;
  [[nodiscard]] const LocalCostmap& costmap() const { return costmap_; }
  [[nodiscard]] const MovingObstacles& obstacles() const { return obstacles_; }

 private:
  void observe_drift(const Localisation& next);

  DrivingParameters parameters_;
  std::optional<Localisation> localisation_;
  double drift_ = 0;           ///< m/s, filtered
  double drift_variance_ = 0;  ///< m^2/s^2, of the filtered value
  std::optional<double> scan_time_;
  std::uint64_t last_scan_ = 0;  ///< hash of its ranges
  int equal_scans_ = 0;
  std::vector<Point2d> told_;
  double told_at_ = 0;  ///< s
  bool too_many_told_ = false;
  LocalCostmap costmap_;
  MovingObstacles obstacles_;
};

}  // namespace pipescout::navigation
