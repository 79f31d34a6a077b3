// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <geometry_msgs/msg/twist.hpp>
#include <geometry_msgs/msg/vector3.hpp>
#include <sensor_msgs/msg/imu.hpp>

/// Conversions between messages and velocities, rates and forces. All functions are pure and
/// thread-safe.
namespace pipescout {

[[nodiscard]] geometry_msgs::msg::Vector3 to_message(const Eigen::Vector3d& vector);
/// Copies the values without checks.
[[nodiscard]] Eigen::Vector3d from_message(const geometry_msgs::msg::Vector3& message);

/// m/s and rad/s.
[[nodiscard]] geometry_msgs::msg::Twist twist_message(const Eigen::Vector3d& linear,
                                                      const Eigen::Vector3d& angular);

/// rad/s and m/s^2, in the axes of the IMU. The covariances are set to unknown (zero) and the
/// orientation to not available (-1), as sensor_msgs/Imu defines. Does not fill in the header.
[[nodiscard]] sensor_msgs::msg::Imu imu_message(const Eigen::Vector3d& angular_rate,
                                                const Eigen::Vector3d& specific_force);

}  // namespace pipescout
