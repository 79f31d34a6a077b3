// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <geometry_msgs/msg/twist_with_covariance_stamped.hpp>
#include <nav_msgs/msg/odometry.hpp>
#include <sensor_msgs/msg/fluid_pressure.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <sensor_msgs/msg/magnetic_field.hpp>
#include <sensor_msgs/msg/range.hpp>

#include "pipescout/estimation/factors.hpp"
#include "pipescout/estimation/pose_factor.hpp"
#include "pipescout/estimator_sources/source_input.hpp"
#include "pipescout/geometry/se3.hpp"

/// Measurements of named sources from messages. All functions are pure; numbers that are not finite
/// are for the estimator to refuse. `T_body_sensor`: of the message's frame. Times are s since an
/// origin that the caller keeps; angular rates rad/s, as measured by the gyro, in the body.
namespace pipescout {

/// Horizontal only: receivers without a vertical velocity say 0.
[[nodiscard]] estimation::VelocityMeasurement velocity_measurement(
    const geometry_msgs::msg::TwistStamped& message, double time, const NamedSource& source,
    const geometry::SE3& T_body_sensor, const Eigen::Vector3d& angular_rate);
/// Variances that are not positive are unknown: `source.deviation` is used.
[[nodiscard]] estimation::VelocityMeasurement velocity_measurement(
    const geometry_msgs::msg::TwistWithCovarianceStamped& message, double time,
    const NamedSource& source, const geometry::SE3& T_body_sensor,
    const Eigen::Vector3d& angular_rate);
/// Of a twist in the axes of the sensor's frame; variances as above.
[[nodiscard]] estimation::BodyVelocityMeasurement body_velocity_measurement(
    const geometry_msgs::msg::TwistWithCovariance& twist, double time, const NamedSource& source,
    const geometry::SE3& T_body_sensor, const Eigen::Vector3d& angular_rate);
[[nodiscard]] estimation::MagneticFieldMeasurement magnetic_field_measurement(
    const sensor_msgs::msg::MagneticField& message, double time, const NamedSource& source,
    const geometry::SE3& T_body_sensor);
[[nodiscard]] estimation::HeightMeasurement height_measurement(
    const sensor_msgs::msg::FluidPressure& message, double time, const NamedSource& source,
    const geometry::SE3& T_body_sensor);
[[nodiscard]] estimation::RangeMeasurement range_measurement(const sensor_msgs::msg::Range& message,
                                                             double time, const NamedSource& source,
                                                             const geometry::SE3& T_body_sensor);

/// Of a pose of the sensor in the map. Variances that are not positive are unknown:
/// `source.deviation` and `source.rotation_deviation` are used. Throws std::invalid_argument for an
/// orientation that is none.
[[nodiscard]] estimation::PoseMeasurement pose_measurement(
    const geometry_msgs::msg::PoseWithCovarianceStamped& message, double time,
    const NamedSource& source, const geometry::SE3& T_body_sensor,
    const Eigen::Vector3d& angular_rate);

/// The motion of the body from one to the other.
[[nodiscard]] estimation::RelativePoseMeasurement relative_pose_measurement(
    const TimedPose& from, const TimedPose& to, const NamedSource& source,
    const geometry::SE3& T_body_sensor);

}  // namespace pipescout
