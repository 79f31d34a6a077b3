// SPDX-License-Identifier: Apache-2.0
// Sources that the parameter `sources` names.
#include <cmath>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "estimator_messages.hpp"
#include "named_source_messages.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/motion.hpp"
#include "pipescout/runtime/transforms.hpp"
#include "pipescout/state_estimator/state_estimator.hpp"

namespace pipescout {

namespace {

using estimation::AnyFactor;
using estimation::own_kind;
using geometry::SE3;
using geometry_msgs::msg::TwistStamped;
using geometry_msgs::msg::TwistWithCovariance;
using geometry_msgs::msg::TwistWithCovarianceStamped;
using sensor_msgs::msg::FluidPressure;
using sensor_msgs::msg::JointState;
using sensor_msgs::msg::MagneticField;
using sensor_msgs::msg::Range;

/// As for the other sensors: drivers publish best effort or reliable.
constexpr QoS kQos = QoS::sensor_data(50);

/// The frame in which a message's numbers are, or on which its sensor is.
template <class Message>
const std::string& frame_of(const Message& message) {
  if constexpr (std::is_same_v<Message, nav_msgs::msg::Odometry>) {
    return message.child_frame_id;
  } else if constexpr (std::is_same_v<Message, JointState>) {
    static const std::string
        base;  // the motion is that of the base, whatever frame the joints have
    return base;
  } else {
    return message.header.frame_id;
  }
}

}  // namespace

void StateEstimator::subscribe_to_sources() {
  named_.clear();
  named_.resize(settings_.sources.size());
  for (std::size_t i = 0; i < named_.size(); ++i) {
    switch (settings_.sources[i].kind) {
      case NamedSourceKind::kGpsVelocity:
        subscribe_to_source<TwistStamped>(i);
        break;
      case NamedSourceKind::kGpsVelocityWithCovariance:
      case NamedSourceKind::kBaseVelocity:
        subscribe_to_source<TwistWithCovarianceStamped>(i);
        break;
      case NamedSourceKind::kOdometryVelocity:
      case NamedSourceKind::kOdometryPose:
        subscribe_to_source<Odometry>(i);
        break;
      case NamedSourceKind::kMagneticField:
        subscribe_to_source<MagneticField>(i);
        break;
      case NamedSourceKind::kFluidPressure:
        subscribe_to_source<FluidPressure>(i);
        break;
      case NamedSourceKind::kRange:
        subscribe_to_source<Range>(i);
        break;
      case NamedSourceKind::kGpsFix:
        subscribe_to_source<Fix>(i);
        break;
      case NamedSourceKind::kWheelEncoders:
        named_[i].wheels.emplace(settings_.sources[i].wheels);
        subscribe_to_source<JointState>(i);
        break;
    }
    if (!settings_.sources[i].position) {
      static_cast<void>(transforms());  // listens from now on
    }
  }
}

template <class Message>
void StateEstimator::subscribe_to_source(std::size_t source) {
  named_[source].subscription =
      std::make_shared<Subscription<Message>>(create_subscription<Message>(
          settings_.sources[source].topic, kQos,
          [this, source](const Message& message) { on_source(source, message); }));
}

std::optional<SE3> StateEstimator::place_of(std::size_t source, const std::string& frame) {
  const NamedSource& named = settings_.sources[source];
  if (named.position) {
    return SE3(named.R_base_sensor, *named.position);
  }
  if (frame.empty() || frame == settings_.base_frame) {
    return SE3();
  }
  auto& places = named_[source].places;
  if (const auto known = places.find(frame); known != places.end()) {
    return known->second;
  }
  const TransformResult found = transforms().lookup(settings_.base_frame, frame);
  if (!found) {
    report_fault(named.name + ".tf", "source '" + named.name + "': " + found.failure().text +
                                         " (or give parameter " + named.name + ".position)");
    return std::nullopt;
  }
  return places.emplace(frame, from_message(found->transform)).first->second;
}

std::optional<AnyFactor> StateEstimator::relative_pose(std::size_t source, const Odometry& message,
                                                       double time, const SE3& T_body_sensor) {
  const NamedSource& named = settings_.sources[source];
  std::optional<TimedPose>& last = named_[source].last_pose;
  const TimedPose now{time, from_message(message.pose.pose)};
  const std::optional<TimedPose> before = std::exchange(last, now);
  if (!before || !(time > before->time)) {
    return std::nullopt;
  }
  const auto moved = relative_pose_measurement(*before, now, named, T_body_sensor);
  // Its frame began again elsewhere.
  if (moved.T_from_to.translation().norm() >
      settings_.estimator.odometer.largest_speed * (time - before->time)) {
    report_fault(named.name + ".jump", "source '" + named.name + "': its pose jumped by " +
                                           std::to_string(moved.T_from_to.translation().norm()) +
                                           " m");
    return std::nullopt;
  }
  return AnyFactor(moved, own_kind(source));
}

AnyFactor StateEstimator::base_velocity(std::size_t source, const TwistWithCovariance& twist,
                                        double time, const SE3& T_body_sensor) {
  if (settings_.implied_imu == source) {
    imply_imu(twist.twist, time, T_body_sensor);
  }
  return AnyFactor(body_velocity_measurement(twist, time, settings_.sources[source], T_body_sensor,
                                             angular_rate()),
                   own_kind(source));
}

void StateEstimator::imply_imu(const geometry_msgs::msg::Twist& twist, double time,
                               const SE3& T_body_sensor) {
  const Eigen::Vector3d rate = T_body_sensor.rotation() * from_message(twist.angular);
  const Eigen::Vector3d velocity = T_body_sensor.rotation() * from_message(twist.linear) -
                                   rate.cross(T_body_sensor.translation());
  imu_heard_ = true;
  for (const estimation::ImuReading& reading : planar_->add(time, velocity.x(), rate.z())) {
    take_reading(reading);
  }
}

Eigen::Vector3d StateEstimator::angular_rate() const {
  return last_reading_ ? settings_.estimator.R_body_imu * last_reading_->angular_rate
                       : Eigen::Vector3d(Eigen::Vector3d::Zero());
}

template <class Message>
std::optional<AnyFactor> StateEstimator::factor_of(std::size_t source, const Message& message,
                                                   double time, const SE3& T_body_sensor) {
  const NamedSource& named = settings_.sources[source];
  const estimation::FactorKind kind = own_kind(source);
  const Eigen::Vector3d rate = angular_rate();
  if constexpr (std::is_same_v<Message, TwistStamped>) {
    return AnyFactor(velocity_measurement(message, time, named, T_body_sensor, rate), kind);
  } else if constexpr (std::is_same_v<Message, TwistWithCovarianceStamped>) {
    if (named.kind == NamedSourceKind::kBaseVelocity) {
      return base_velocity(source, message.twist, time, T_body_sensor);
    }
    return AnyFactor(velocity_measurement(message, time, named, T_body_sensor, rate), kind);
  } else if constexpr (std::is_same_v<Message, Odometry>) {
    if (named.kind == NamedSourceKind::kOdometryPose) {
      return relative_pose(source, message, time, T_body_sensor);
    }
    return base_velocity(source, message.twist, time, T_body_sensor);
  } else if constexpr (std::is_same_v<Message, JointState>) {
    const auto motion =
        named_[source].wheels->add(time, message.name, message.position, message.velocity);
    if (!motion) {
      return std::nullopt;
    }
    TwistWithCovariance twist;
    twist.twist.linear.x = motion->speed;
    twist.twist.angular.z = motion->yaw_rate;
    return base_velocity(source, twist, motion->time, T_body_sensor);
  } else if constexpr (std::is_same_v<Message, MagneticField>) {
    return AnyFactor(magnetic_field_measurement(message, time, named, T_body_sensor), kind);
  } else if constexpr (std::is_same_v<Message, FluidPressure>) {
    return AnyFactor(height_measurement(message, time, named, T_body_sensor), kind);
  } else if constexpr (std::is_same_v<Message, Range>) {
    if (std::isinf(message.range)) {  // REP 117: nothing detected
      return std::nullopt;
    }
    return AnyFactor(range_measurement(message, time, named, T_body_sensor), kind);
  } else {
    if (message.status.status < sensor_msgs::msg::NavSatStatus::STATUS_FIX || !map_) {
      return std::nullopt;  // no fix, or the first antenna has not said yet where the map is
    }
    const estimation::GpsMeasurement fix =
        gps_measurement(message, time, *map_, 0, named.deviation, settings_.least_gps_deviation);
    return AnyFactor(estimation::PositionMeasurement{.time = time,
                                                     .position = fix.position,
                                                     .covariance = fix.covariance,
                                                     .sensor = T_body_sensor.translation()},
                     kind);
  }
}

template <class Message>
void StateEstimator::on_source(std::size_t source, const Message& message) {
  const std::string& name = settings_.sources[source].name;
  const auto time = time_of(name, message.header.stamp);
  if (!time) {
    return;
  }
  try {
    const auto T_base_sensor = place_of(source, frame_of(message));
    if (!T_base_sensor) {
      return;
    }
    const SE3 T_body_base(geometry::SO3(), -settings_.imu);
    if (const auto factor = factor_of(source, message, *time, T_body_base * *T_base_sensor)) {
      report_outcome(name, estimator_->add(*factor));
      publish_news();
    }
  } catch (const std::invalid_argument& error) {
    report_fault(name + ".refused", "source '" + name + "': " + error.what());
  }
}

void StateEstimator::tell_sources() {
  for (std::size_t i = 0; i < settings_.sources.size(); ++i) {
    const std::string& name = settings_.sources[i].name;
    const estimation::SourceStatus& now_so = status_.own_sources[i];
    const estimation::SourceStatus& before = told_.own_sources[i];
    if (now_so.state != before.state) {
      logger().info("source '" + name + "' is " + std::string(to_string(now_so.state)));
    }
    if (now_so.gated > before.gated) {
      diagnostics().count(name + ".gated", now_so.gated - before.gated);
    }
    diagnostics().set_value(name + ".state", std::string(to_string(now_so.state)));
    diagnostics().set_value(name + ".accepted", std::to_string(now_so.accepted));
    diagnostics().set_value(name + ".waiting", std::to_string(now_so.waiting));
  }
}

}  // namespace pipescout
