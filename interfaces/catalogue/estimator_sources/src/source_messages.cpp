// SPDX-License-Identifier: Apache-2.0
#include "source_messages.hpp"

#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/motion.hpp"

namespace pipescout {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::SE3;

/// m/s; a velocity that is not known.
constexpr double kUnknownVelocity = 1e3;

/// In the form of geometry_msgs/PoseWithCovariance.
geometry::Matrix6d pose_covariance(const std::array<double, 36>& all, const NamedSource& source) {
  geometry::Matrix6d covariance =
      Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(all.data());
  for (int i = 0; i < 6; ++i) {
    if (covariance(i, i) <= 0) {
      const double deviation = i < 3 ? source.deviation : source.rotation_deviation;
      covariance.row(i).setZero();
      covariance.col(i).setZero();
      covariance(i, i) = deviation * deviation;
    }
  }
  return covariance;
}

/// Of the linear velocity. Variances of 0 or -1 mean unknown.
Matrix3d linear_covariance(const std::array<double, 36>& all, double deviation) {
  Matrix3d covariance = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(all.data())
                            .topLeftCorner<3, 3>();
  for (int i = 0; i < 3; ++i) {
    if (covariance(i, i) <= 0) {
      covariance.row(i).setZero();
      covariance.col(i).setZero();
      covariance(i, i) = deviation * deviation;
    }
  }
  return covariance;
}

}  // namespace

estimation::VelocityMeasurement velocity_measurement(
    const geometry_msgs::msg::TwistStamped& message, double time, const NamedSource& source,
    const SE3& T_body_sensor, const Vector3d& angular_rate) {
  estimation::VelocityMeasurement m{.time = time,
                                    .velocity = from_message(message.twist.linear),
                                    .sensor = T_body_sensor.translation(),
                                    .angular_rate = angular_rate};
  const double variance = source.deviation * source.deviation;
  m.velocity.z() = 0;
  m.covariance.diagonal() << variance, variance, kUnknownVelocity * kUnknownVelocity;
  return m;
}

estimation::VelocityMeasurement velocity_measurement(
    const geometry_msgs::msg::TwistWithCovarianceStamped& message, double time,
    const NamedSource& source, const SE3& T_body_sensor, const Vector3d& angular_rate) {
  return {.time = time,
          .velocity = from_message(message.twist.twist.linear),
          .covariance = linear_covariance(message.twist.covariance, source.deviation),
          .sensor = T_body_sensor.translation(),
          .angular_rate = angular_rate};
}

estimation::BodyVelocityMeasurement body_velocity_measurement(
    const geometry_msgs::msg::TwistWithCovariance& twist, double time, const NamedSource& source,
    const SE3& T_body_sensor, const Vector3d& angular_rate) {
  const Matrix3d R = T_body_sensor.rotation().matrix();
  const Matrix3d covariance =
      R * linear_covariance(twist.covariance, source.deviation) * R.transpose();
  return {.time = time,
          .velocity = R * from_message(twist.twist.linear),
          .covariance = 0.5 * (covariance + covariance.transpose()),
          .sensor = T_body_sensor.translation(),
          .angular_rate = angular_rate};
}

estimation::MagneticFieldMeasurement magnetic_field_measurement(
    const sensor_msgs::msg::MagneticField& message, double time, const NamedSource& source,
    const SE3& T_body_sensor) {
  return {.time = time,
          .field = T_body_sensor.rotation() * from_message(message.magnetic_field),
          .declination = source.declination,
          .standard_deviation = source.deviation,
          .bias = source.bias};
}

estimation::HeightMeasurement height_measurement(const sensor_msgs::msg::FluidPressure& message,
                                                 double time, const NamedSource& source,
                                                 const SE3& T_body_sensor) {
  return {.time = time,
          .height = estimation::pressure_height(message.fluid_pressure),
          .standard_deviation = source.deviation,
          .sensor = T_body_sensor.translation(),
          .bias = source.bias};
}

estimation::RangeMeasurement range_measurement(const sensor_msgs::msg::Range& message, double time,
                                               const NamedSource& source,
                                               const SE3& T_body_sensor) {
  return {.time = time,
          .range = message.range,
          .standard_deviation = source.deviation,
          .beacon = source.beacon.value_or(Vector3d::Zero()),
          .sensor = T_body_sensor.translation(),
          .bias = source.bias};
}

estimation::PoseMeasurement pose_measurement(
    const geometry_msgs::msg::PoseWithCovarianceStamped& message, double time,
    const NamedSource& source, const SE3& T_body_sensor, const Vector3d& angular_rate) {
  const SE3 T_map_sensor = from_message(message.pose.pose);
  estimation::PoseMeasurement m;
  m.time = time;
  m.T_rack_body = T_map_sensor * T_body_sensor.inverse();
  m.angular_rate = angular_rate;
  m.camera = T_body_sensor.translation();
  m.mounting = source.mounting;
  m.clock = source.clock;
  const Vector3d arm = m.T_rack_body.translation() - T_map_sensor.translation();
  geometry::Matrix6d by_sensor = geometry::Matrix6d::Identity();
  by_sensor.topRightCorner<3, 3>() = -geometry::skew(arm);
  by_sensor.bottomRightCorner<3, 3>() = m.T_rack_body.rotation().matrix().transpose();
  const geometry::Matrix6d covariance =
      by_sensor * pose_covariance(message.pose.covariance, source) * by_sensor.transpose();
  m.covariance = 0.5 * (covariance + covariance.transpose());
  return m;
}

estimation::RelativePoseMeasurement relative_pose_measurement(const TimedPose& from,
                                                              const TimedPose& to,
                                                              const NamedSource& source,
                                                              const SE3& T_body_sensor) {
  estimation::RelativePoseMeasurement m{
      .from_time = from.time,
      .to_time = to.time,
      .T_from_to = T_body_sensor * (from.pose.inverse() * to.pose) * T_body_sensor.inverse()};
  m.covariance.diagonal().head<3>().setConstant(source.deviation * source.deviation);
  m.covariance.diagonal().tail<3>().setConstant(source.rotation_deviation *
                                                source.rotation_deviation);
  return m;
}

}  // namespace pipescout
