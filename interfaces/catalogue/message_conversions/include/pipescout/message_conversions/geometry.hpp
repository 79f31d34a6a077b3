// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <geometry_msgs/msg/pose.hpp>
#include <geometry_msgs/msg/pose_with_covariance.hpp>
#include <geometry_msgs/msg/transform.hpp>

#include "pipescout/geometry/se3.hpp"

/// Conversions between messages and the types of the algorithm packages. All functions are pure and
/// thread-safe, and validate received data.
namespace pipescout {

[[nodiscard]] geometry_msgs::msg::Pose to_message(const geometry::SE3& pose);
/// The quaternion is normalised: its norm may be off by 1e-3, as after rounding to text or float.
/// Throws std::invalid_argument naming the field when a value is not finite or the norm deviates
/// more from 1 (also for a quaternion of zeros).
[[nodiscard]] geometry::SE3 from_message(const geometry_msgs::msg::Pose& message);

[[nodiscard]] geometry_msgs::msg::Transform transform_message(const geometry::SE3& pose);
/// As for a pose.
[[nodiscard]] geometry::SE3 from_message(const geometry_msgs::msg::Transform& message);

/// Covariances over (x, y, z, rotation about the fixed axes X, Y, Z), row-major.
[[nodiscard]] std::array<double, 36> to_message(const geometry::Matrix6d& covariance);
/// Throws std::invalid_argument naming the entry when one is not finite, a variance is not above 0,
/// or the matrix is not symmetric within a millionth of the variances or not positive definite.
[[nodiscard]] geometry::Matrix6d covariance_from_message(const std::array<double, 36>& covariance);

}  // namespace pipescout
