// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/motion.hpp"

namespace pipescout {

geometry_msgs::msg::Vector3 to_message(const Eigen::Vector3d& vector) {
  geometry_msgs::msg::Vector3 message;
  message.x = vector.x();
  message.y = vector.y();
  message.z = vector.z();
  return message;
}

Eigen::Vector3d from_message(const geometry_msgs::msg::Vector3& message) {
  return {message.x, message.y, message.z};
}

geometry_msgs::msg::Twist twist_message(const Eigen::Vector3d& linear,
                                        const Eigen::Vector3d& angular) {
  geometry_msgs::msg::Twist message;
  message.linear = to_message(linear);
  message.angular = to_message(angular);
  return message;
}

sensor_msgs::msg::Imu imu_message(const Eigen::Vector3d& angular_rate,
                                  const Eigen::Vector3d& specific_force) {
  sensor_msgs::msg::Imu message;
  message.orientation_covariance[0] = -1;
  message.angular_velocity = to_message(angular_rate);
  message.linear_acceleration = to_message(specific_force);
  return message;
}

}  // namespace pipescout
