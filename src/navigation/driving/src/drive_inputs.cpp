// SPDX-License-Identifier: Apache-2.0
#include "drive_inputs.hpp"

#include <bit>
#include <cmath>

namespace pipescout::navigation {
namespace {

/// m, [0, inf): a localisation that jumps farther has lost the map that was drawn by it.
constexpr double kJump = 1;
constexpr double kDriftTime = 2;      ///< s, over which the drift is filtered
constexpr double kDriftSpeed = 0.1;   ///< m/s, below which it does not show
constexpr double kLongestStep = 0.3;  ///< s, between two localisations that show it

/// FNV-1a over the bits.
std::uint64_t hash(std::span<const float> ranges) {
  std::uint64_t result = 14695981039346656037U;
  for (const float range : ranges) {
    result = (result ^ std::bit_cast<std::uint32_t>(range)) * 1099511628211U;
  }
  return result;
}

}  // namespace

DriveInputs::DriveInputs(const DrivingParameters& parameters, const LocalCostmapParameters& costmap)
    : parameters_(parameters), costmap_(costmap) {
  told_.reserve(parameters_.most_obstacle_cells);
}

void DriveInputs::set_obstacles(std::span<const Point2d> cells, double time) {
  told_.clear();
  told_at_ = time;
  too_many_told_ = false;
  const double radius = 0.5 * costmap_.parameters().resolution * costmap_.parameters().size;
  for (const Point2d& cell : cells) {
    // NaN is not near, and nor is what is beyond the costmap.
    if (localisation_ && !(distance(cell, localisation_->pose.position()) < radius)) {
      continue;
    }
    if (told_.size() == told_.capacity()) {
      too_many_told_ = true;
      return;
    }
    told_.push_back(cell);
  }
}

std::span<const Point2d> DriveInputs::told_cells(double now) const {
  const bool fresh = now - told_at_ <= costmap_.parameters().forget_after;
  return fresh ? std::span<const Point2d>(told_) : std::span<const Point2d>();
}

void DriveInputs::forget() {
  localisation_.reset();
  scan_time_.reset();
  told_.clear();
  told_at_ = 0;
  costmap_.clear();
  obstacles_.clear();
}

DriveInput DriveInputs::add(const Localisation& localisation) {
  const auto& l = localisation;
  if (!is_finite(l.pose) ||
      !std::isfinite(l.time + l.speed + l.yaw_rate + l.sigma + l.heading_sigma)) {
    return DriveInput::kNotFinite;
  }
  if (l.sigma < 0 || l.heading_sigma < 0) {
    return DriveInput::kBadGeometry;
  }
  if (localisation_ && l.time <= localisation_->time) {
    return DriveInput::kOutOfOrder;
  }
  if (localisation_ && distance(pose_at(l.time), l.pose) > kJump) {
    costmap_.clear();
    obstacles_.clear();
  } else if (localisation_) {
    observe_drift(l);
  }
  localisation_ = l;
  return DriveInput::kTaken;
}

/// A first-order filter of the sideways velocity, and of its square about the filtered value.
void DriveInputs::observe_drift(const Localisation& next) {
  const Localisation& last = *localisation_;
  const double dt = next.time - last.time;
  if (dt > kLongestStep || std::min(std::abs(last.speed), std::abs(next.speed)) < kDriftSpeed) {
    return;
  }
  const double turn = wrap_angle(next.pose.heading - last.pose.heading);
  const double middle = last.pose.heading + 0.5 * turn;
  const double sideways = (-std::sin(middle) * (next.pose.x - last.pose.x) +
                           std::cos(middle) * (next.pose.y - last.pose.y)) /
                          dt;
  const double gain = dt / (kDriftTime + dt);
  const double innovation = sideways - drift_;
  drift_ += gain * innovation;
  // The filtered value of white noise has gain / (2 - gain) of its variance.
  drift_variance_ += gain * (gain / (2 - gain) * innovation * innovation - drift_variance_);
}

double DriveInputs::drift() const {
  const double square = drift_ * drift_;
  return square > 0 ? drift_ * square / (square + drift_variance_) : 0;
}

DriveInput DriveInputs::add(const ScanView& scan, const Pose2d& T_robot_lidar) {
  if (!std::isfinite(scan.time + scan.angle_min + scan.angle_increment + scan.range_min +
                     scan.range_max) ||
      !is_finite(T_robot_lidar)) {
    return DriveInput::kNotFinite;
  }
  if (scan.ranges.empty() || scan.angle_increment == 0 || !(scan.range_min >= 0) ||
      !(scan.range_max > scan.range_min)) {
    return DriveInput::kBadGeometry;
  }
  if (scan_time_ && scan.time <= *scan_time_) {
    return DriveInput::kOutOfOrder;
  }
  const std::uint64_t content = hash(scan.ranges);
  equal_scans_ = scan_time_ && content == last_scan_ ? equal_scans_ + 1 : 1;
  last_scan_ = content;
  scan_time_ = scan.time;
  if (localisation_ && fault(scan.time) == DriveReason::kNone) {
    const Pose2d T_map_lidar = compose(pose_at(scan.time), T_robot_lidar);
    costmap_.add(scan, T_map_lidar);
    obstacles_.add(scan, T_map_lidar);
  }
  return DriveInput::kTaken;
}

DriveReason DriveInputs::fault(double now) const {
  const auto& p = parameters_;
  if (!localisation_) {
    return DriveReason::kLocalisationMissing;
  }
  // Not a number, and stamps of the future, are stale too.
  if (!(std::abs(now - localisation_->time) <= p.localisation_stale_after)) {
    return DriveReason::kLocalisationStale;
  }
  if (localisation_->sigma > p.largest_sigma ||
      localisation_->heading_sigma > p.largest_heading_sigma) {
    return DriveReason::kLocalisationUncertain;
  }
  if (!scan_time_) {
    return DriveReason::kScanMissing;
  }
  if (!(std::abs(now - *scan_time_) <= p.scan_stale_after)) {
    return DriveReason::kScanStale;
  }
  return equal_scans_ >= p.frozen_scans ? DriveReason::kScanFrozen : DriveReason::kNone;
}

std::optional<Localisation> DriveInputs::localisation(double time) const {
  std::optional<Localisation> result = localisation_;
  if (result) {
    result->pose = pose_at(time);
  }
  return result;
}

Pose2d DriveInputs::pose_at(double time) const {
  const double dt = time - localisation_->time;
  const double length = localisation_->speed * dt;
  const double turn = localisation_->yaw_rate * dt;
  const Pose2d& pose = localisation_->pose;
  const double middle = pose.heading + 0.5 * turn;
  return {pose.x + length * std::cos(middle), pose.y + length * std::sin(middle),
          wrap_angle(pose.heading + turn)};
}

}  // namespace pipescout::navigation
