// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/visual_servo.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/validation/check.hpp"

namespace pipescout::rack_vision {
namespace {

using geometry::SE3;
using geometry::SO3;

constexpr double kLongestStep = 0.2;       // s
constexpr double kNewBeginning = 1;        // s: the clock went back by more
constexpr double kQuaternionNorm = 1e-3;   // how far it may be off 1: as printed to 4 digits
constexpr double kLeastHorizontal = 1e-6;  // of the unit x axis of a vehicle that has a heading

Eigen::Vector3d saturated(const Eigen::Vector3d& v, double largest) {
  const double norm = v.norm();
  return norm > largest ? Eigen::Vector3d(v * (largest / norm)) : v;
}

Eigen::Vector3d approached(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                           double largest_change) {
  return from + saturated(to - from, largest_change);
}

}  // namespace

SE3 downward_camera(const Eigen::Vector3d& position_in_base) {
  Eigen::Matrix3d R_base_camera;
  R_base_camera << 0, -1, 0,  //
      -1, 0, 0,               //
      0, 0, -1;
  return {SO3::from_matrix(R_base_camera), position_in_base};
}

void VisualServoParameters::validate() const {
  using validation::check_above;
  using validation::check_within;
  check_above("position_gain", position_gain, 0, 20);
  check_above("rotation_gain", rotation_gain, 0, 20);
  check_within("response_time", response_time, 0, 5);
  check_above("largest_speed", largest_speed, 0, 20);
  check_above("largest_rotation_rate", largest_rotation_rate, 0, 6);
  check_above("largest_acceleration", largest_acceleration, 0, 50);
  check_above("largest_rotation_acceleration", largest_rotation_acceleration, 0, 50);
  check_above("stale_after", stale_after, 0, 10);
  check_within("future_tolerance", future_tolerance, 0, 1);
  check_within("smallest_quality", smallest_quality, 0, 1);
  check_within("hold_time", hold_time, 0, 3600);
  check_within("climb_speed", climb_speed, 0, largest_speed);
  check_within("climb_height", climb_height, 0, 1000);
}

geometry::Vector6d pose_error(const SE3& T_rack_base, const SE3& T_rack_target) noexcept {
  return (T_rack_base.inverse() * T_rack_target).log();
}

std::optional<SE3> level(const SE3& T_rack_base) {
  const Eigen::Vector3d forward = T_rack_base.rotation() * Eigen::Vector3d::UnitX();
  if (forward.head<2>().norm() < kLeastHorizontal) {
    return std::nullopt;
  }
  return SE3(SO3::about_z(std::atan2(forward.y(), forward.x())), T_rack_base.translation());
}

VisualServo::VisualServo(const VisualServoParameters& parameters) : parameters_(parameters) {
  parameters_.validate();
}

PoseVerdict VisualServo::observe(const CameraPose& pose, double now) {
  const double norm = pose.orientation.norm();
  const auto judge = [&] {
    if (!std::isfinite(now) || !std::isfinite(pose.time) || !pose.position.allFinite() ||
        !std::isfinite(norm) || !std::isfinite(pose.quality)) {
      return PoseVerdict::kNotANumber;
    }
    if (std::abs(norm - 1) > kQuaternionNorm) {
      return PoseVerdict::kNoRotation;
    }
    if (pose.time > now + parameters_.future_tolerance) {
      return PoseVerdict::kFromTheFuture;
    }
    if (now - pose.time > parameters_.stale_after) {
      return PoseVerdict::kStale;
    }
    if (known_ && pose.time <= known_->time) {
      return PoseVerdict::kOutOfOrder;
    }
    return pose.quality < parameters_.smallest_quality ? PoseVerdict::kLowQuality
                                                       : PoseVerdict::kTaken;
  };
  const PoseVerdict verdict = judge();
  ++counts_[static_cast<std::size_t>(verdict)];
  if (verdict == PoseVerdict::kTaken) {
    const SE3 T_rack_camera(SO3::from_quaternion(pose.orientation.normalized()), pose.position);
    known_ = Known{.time = pose.time,
                   .T_rack_base = T_rack_camera * parameters_.T_base_camera.inverse()};
  }
  return verdict;
}

ServoCommand VisualServo::step(double now, const std::optional<PathPoint>& target) {
  if (!std::isfinite(now)) {
    return command_;
  }
  if (last_step_ && now < *last_step_) {
    if (*last_step_ - now <= kNewBeginning) {
      return command_;
    }
    reset();
  }
  const double interval = last_step_ ? std::min(now - *last_step_, kLongestStep) : 0;
  last_step_ = now;

  ServoCommand wanted;
  if (!target) {
    without_pose_since_.reset();
    climbed_ = 0;
  } else if (known_ && now - known_->time <= parameters_.stale_after) {
    without_pose_since_.reset();
    climbed_ = 0;
    wanted = follow(*known_, *target, now);
  } else {
    wanted = do_without_pose(now, interval);
  }
  wanted.linear = approached(command_.linear, saturated(wanted.linear, parameters_.largest_speed),
                             parameters_.largest_acceleration * interval);
  wanted.angular =
      approached(command_.angular, saturated(wanted.angular, parameters_.largest_rotation_rate),
                 parameters_.largest_rotation_acceleration * interval);
  command_ = wanted;
  return command_;
}

ServoCommand VisualServo::follow(const Known& known, const PathPoint& target, double now) const {
  const bool yaw_only = parameters_.rotation == RotationControl::kYawOnly;
  const std::optional<SE3> levelled = yaw_only ? level(known.T_rack_base) : known.T_rack_base;
  if (!levelled) {
    return {.state = ServoState::kHolding};
  }
  const SE3 T_rack_target(SO3::about_z(target.yaw), target.position);
  const geometry::Vector6d error = pose_error(*levelled, T_rack_target);
  const SO3 R_control_rack = levelled->rotation().inverse();
  // The target is that of the pose's time; the vehicle will take up what is commanded now later.
  const double ahead = std::max(0.0, now - known.time) + parameters_.response_time;
  const Eigen::Vector3d velocity = target.velocity + ahead * target.acceleration;
  const double yaw_rate = target.yaw_rate + ahead * target.yaw_acceleration;
  return {.linear = parameters_.position_gain * error.head<3>() + R_control_rack * velocity,
          .angular = parameters_.rotation_gain * error.tail<3>() +
                     R_control_rack * Eigen::Vector3d(0, 0, yaw_rate),
          .state = ServoState::kServoing,
          .position_error = (target.position - known.T_rack_base.translation()).norm(),
          .rotation_error = error.tail<3>().norm()};
}

ServoCommand VisualServo::do_without_pose(double now, double interval) {
  without_pose_since_ = without_pose_since_.value_or(now);
  // Before its first pose it has not lost anything: where it hovers is where it was said to be.
  if (!known_ || now - *without_pose_since_ < parameters_.hold_time ||
      parameters_.climb_speed == 0 || climbed_ >= parameters_.climb_height) {
    return {.state = ServoState::kHolding};
  }
  // In base_link of a vehicle that turns freely, "up" is as it was when last seen.
  const Eigen::Vector3d up =
      parameters_.rotation == RotationControl::kFull
          ? known_->T_rack_base.rotation().inverse() * Eigen::Vector3d::UnitZ()
          : Eigen::Vector3d::UnitZ();
  climbed_ += std::max(0.0, command_.linear.dot(up)) * interval;
  return {.linear = parameters_.climb_speed * up, .state = ServoState::kClimbing};
}

void VisualServo::reset() noexcept {
  known_.reset();
  last_step_.reset();
  without_pose_since_.reset();
  climbed_ = 0;
  command_ = {};
}

std::optional<SE3> VisualServo::T_rack_base(double now) const noexcept {
  if (!known_ || !(now - known_->time <= parameters_.stale_after)) {
    return std::nullopt;
  }
  return known_->T_rack_base;
}

std::optional<double> VisualServo::pose_time() const noexcept {
  return known_ ? std::optional(known_->time) : std::nullopt;
}

const char* to_string(PoseVerdict verdict) noexcept {
  switch (verdict) {
    case PoseVerdict::kTaken:
      return "taken";
    case PoseVerdict::kNotANumber:
      return "not a number";
    case PoseVerdict::kNoRotation:
      return "no rotation";
    case PoseVerdict::kFromTheFuture:
      return "from the future";
    case PoseVerdict::kStale:
      return "stale";
    case PoseVerdict::kOutOfOrder:
      return "out of order";
    case PoseVerdict::kLowQuality:
      return "low quality";
  }
  return "unknown";
}

const char* to_string(ServoState state) noexcept {
  switch (state) {
    case ServoState::kIdle:
      return "idle";
    case ServoState::kServoing:
      return "servoing";
    case ServoState::kHolding:
      return "holding";
    case ServoState::kClimbing:
      return "climbing";
  }
  return "unknown";
}

}  // namespace pipescout::rack_vision
