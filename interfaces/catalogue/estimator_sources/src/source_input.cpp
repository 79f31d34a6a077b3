// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimator_sources/source_input.hpp"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "pipescout/estimator_sources/fix.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/motion.hpp"
#include "source_messages.hpp"

namespace pipescout {

namespace {

using estimation::AnyFactor;
using geometry_msgs::msg::PoseWithCovarianceStamped;
using geometry_msgs::msg::TwistStamped;
using geometry_msgs::msg::TwistWithCovariance;
using geometry_msgs::msg::TwistWithCovarianceStamped;
using sensor_msgs::msg::FluidPressure;
using sensor_msgs::msg::JointState;
using sensor_msgs::msg::MagneticField;
using sensor_msgs::msg::NavSatFix;
using sensor_msgs::msg::Range;

/// A message of another type than the kind's is not read as something else.
void require_kind(const NamedSource& source, std::initializer_list<NamedSourceKind> kinds) {
  for (const NamedSourceKind kind : kinds) {
    if (source.kind == kind) {
      return;
    }
  }
  throw std::invalid_argument("a source of kind " + std::string(to_string(source.kind)) +
                              " is measured by messages of type " +
                              std::string(message_type_of(source.kind)));
}

}  // namespace

SourceInput::SourceInput(const NamedSource& source, std::size_t place, double largest_speed)
    : source_(source), kind_(estimation::own_kind(place)), largest_speed_(largest_speed) {
  if (source.kind == NamedSourceKind::kWheelEncoders) {
    wheels_.emplace(source.wheels);
  }
}

SourceNews SourceInput::body_velocity(const TwistWithCovariance& twist, double time,
                                      const SourceContext& context) const {
  const geometry::SE3& T_body_sensor = context.T_body_sensor;
  const Eigen::Vector3d rate = T_body_sensor.rotation() * from_message(twist.twist.angular);
  const Eigen::Vector3d velocity = T_body_sensor.rotation() * from_message(twist.twist.linear) -
                                   rate.cross(T_body_sensor.translation());
  return {.factor = AnyFactor(
              body_velocity_measurement(twist, time, source_, T_body_sensor, context.angular_rate),
              kind_),
          .motion = estimation::WheelMotion{time, velocity.x(), rate.z()}};
}

SourceNews SourceInput::relative_pose(const nav_msgs::msg::Odometry& message, double time,
                                      const SourceContext& context) {
  const TimedPose now{time, from_message(message.pose.pose)};
  const std::optional<TimedPose> before = std::exchange(last_pose_, now);
  if (!before || !(time > before->time)) {
    return {};
  }
  const auto moved = relative_pose_measurement(*before, now, source_, context.T_body_sensor);
  const double way = moved.T_from_to.translation().norm();
  if (way > largest_speed_ * (time - before->time)) {
    return {.jumped = way};
  }
  return {.factor = AnyFactor(moved, kind_)};
}

SourceNews SourceInput::take(const TwistStamped& message, double time,
                             const SourceContext& context) {
  require_kind(source_, {NamedSourceKind::kGpsVelocity});
  return {.factor = AnyFactor(velocity_measurement(message, time, source_, context.T_body_sensor,
                                                   context.angular_rate),
                              kind_)};
}

SourceNews SourceInput::take(const TwistWithCovarianceStamped& message, double time,
                             const SourceContext& context) {
  require_kind(source_,
               {NamedSourceKind::kBaseVelocity, NamedSourceKind::kGpsVelocityWithCovariance});
  if (source_.kind == NamedSourceKind::kBaseVelocity) {
    return body_velocity(message.twist, time, context);
  }
  return {.factor = AnyFactor(velocity_measurement(message, time, source_, context.T_body_sensor,
                                                   context.angular_rate),
                              kind_)};
}

SourceNews SourceInput::take(const nav_msgs::msg::Odometry& message, double time,
                             const SourceContext& context) {
  require_kind(source_, {NamedSourceKind::kOdometryPose, NamedSourceKind::kOdometryVelocity});
  if (source_.kind == NamedSourceKind::kOdometryPose) {
    return relative_pose(message, time, context);
  }
  return body_velocity(message.twist, time, context);
}

SourceNews SourceInput::take(const MagneticField& message, double time,
                             const SourceContext& context) {
  require_kind(source_, {NamedSourceKind::kMagneticField});
  return {.factor = AnyFactor(
              magnetic_field_measurement(message, time, source_, context.T_body_sensor), kind_)};
}

SourceNews SourceInput::take(const FluidPressure& message, double time,
                             const SourceContext& context) {
  require_kind(source_, {NamedSourceKind::kFluidPressure});
  return {.factor =
              AnyFactor(height_measurement(message, time, source_, context.T_body_sensor), kind_)};
}

SourceNews SourceInput::take(const Range& message, double time, const SourceContext& context) {
  require_kind(source_, {NamedSourceKind::kRange});
  if (std::isinf(message.range)) {  // REP 117: nothing detected
    return {};
  }
  return {.factor =
              AnyFactor(range_measurement(message, time, source_, context.T_body_sensor), kind_)};
}

SourceNews SourceInput::take(const NavSatFix& message, double time, const SourceContext& context) {
  require_kind(source_, {NamedSourceKind::kGpsFix});
  if (message.status.status < sensor_msgs::msg::NavSatStatus::STATUS_FIX ||
      context.map == nullptr) {
    return {};
  }
  const estimation::GpsMeasurement fix = gps_measurement(
      message, time, *context.map, 0, source_.deviation, context.least_gps_deviation);
  return {.factor = AnyFactor(
              estimation::PositionMeasurement{.time = time,
                                              .position = fix.position,
                                              .covariance = fix.covariance,
                                              .sensor = context.T_body_sensor.translation()},
              kind_)};
}

SourceNews SourceInput::take(const PoseWithCovarianceStamped& message, double time,
                             const SourceContext& context) {
  require_kind(source_, {NamedSourceKind::kPose});
  return {.factor = AnyFactor(
              pose_measurement(message, time, source_, context.T_body_sensor, context.angular_rate),
              kind_)};
}

SourceNews SourceInput::take(const JointState& message, double time, const SourceContext& context) {
  require_kind(source_, {NamedSourceKind::kWheelEncoders});
  const auto motion = wheels_->add(time, message.name, message.position, message.velocity);
  if (!motion) {
    return {};
  }
  TwistWithCovariance twist;
  twist.twist.linear.x = motion->speed;
  twist.twist.angular.z = motion->yaw_rate;
  return body_velocity(twist, motion->time, context);
}

}  // namespace pipescout
