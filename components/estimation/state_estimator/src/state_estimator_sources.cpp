// SPDX-License-Identifier: Apache-2.0
// Sources that the parameter `sources` names.
#include <pipescout/estimation/camera_calibration.hpp>
#include <stdexcept>
#include <string>

#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/runtime/transforms.hpp"
#include "pipescout/state_estimator/state_estimator.hpp"
#include "pipescout/validation/number_text.hpp"

namespace pipescout {

namespace {

using geometry::SE3;
using geometry_msgs::msg::TwistStamped;
using geometry_msgs::msg::TwistWithCovarianceStamped;
using sensor_msgs::msg::FluidPressure;
using sensor_msgs::msg::JointState;
using sensor_msgs::msg::MagneticField;
using sensor_msgs::msg::Range;

/// As for the other sensors: drivers publish best effort or reliable.
constexpr QoS kQos = QoS::sensor_data(50);

}  // namespace

void StateEstimator::subscribe_to_sources() {
  named_.clear();
  named_.resize(settings_.sources.size());
  for (std::size_t i = 0; i < named_.size(); ++i) {
    named_[i].input.emplace(settings_.sources[i], i, settings_.estimator.odometer.largest_speed);
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
      case NamedSourceKind::kPose:
        subscribe_to_source<Pose>(i);
        break;
      case NamedSourceKind::kWheelEncoders:
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

void StateEstimator::imply_imu(const estimation::WheelMotion& motion) {
  imu_silence_.heard();
  for (const estimation::ImuReading& reading :
       planar_->add(motion.time, motion.speed, motion.yaw_rate)) {
    take_reading(reading);
  }
}

Eigen::Vector3d StateEstimator::angular_rate() const {
  return last_reading_ ? settings_.estimator.R_body_imu * last_reading_->angular_rate
                       : Eigen::Vector3d(Eigen::Vector3d::Zero());
}

template <class Message>
void StateEstimator::on_source(std::size_t source, const Message& message) {
  const std::string& name = settings_.sources[source].name;
  const auto time = time_of(name, message.header.stamp);
  if (!time) {
    return;
  }
  try {
    const auto T_base_sensor = place_of(source, sensor_frame(message));
    if (!T_base_sensor) {
      return;
    }
    const SE3 T_body_base(geometry::SO3(), -settings_.imu);
    const SourceNews news =
        named_[source].input->take(message, *time,
                                   {.T_body_sensor = T_body_base * *T_base_sensor,
                                    .angular_rate = angular_rate(),
                                    .map = map_ ? &*map_ : nullptr,
                                    .least_gps_deviation = settings_.least_gps_deviation});
    if (news.jumped > 0) {
      report_fault(name + ".jump", "source '" + name + "': its pose jumped by " +
                                       validation::number_text(news.jumped) + " m");
    }
    if (news.motion && settings_.implied_imu == source) {
      imply_imu(*news.motion);
    }
    if (news.motion) {
      (void)estimator_->add(
          estimation::WheelTurn{.time = news.motion->time, .yaw_rate = news.motion->yaw_rate});
    }
    if (news.factor) {
      report_outcome(name, estimator_->add(*news.factor));
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
    const NamedSource& source = settings_.sources[i];
    if (now_so.accepted > 0 && (source.mounting >= 0 || source.clock >= 0)) {
      diagnostics().set_value(
          name + ".calibration",
          camera_calibration_text(estimator_->smoother(), settings_.estimator.smoother,
                                  source.mounting, source.clock));
    }
  }
}

}  // namespace pipescout
