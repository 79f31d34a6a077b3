// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/motion.hpp"

#include <gtest/gtest.h>

namespace pipescout {
namespace {

TEST(Motion, VectorsThereAndBack) {
  const Eigen::Vector3d v(1, -2, 3.5);
  EXPECT_EQ(from_message(to_message(v)), v);
}

TEST(Motion, TwistKeepsItsParts) {
  const auto message = twist_message({1, 2, 3}, {4, 5, 6});
  EXPECT_EQ(from_message(message.linear), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(from_message(message.angular), Eigen::Vector3d(4, 5, 6));
}

TEST(Motion, AnImuWithoutOrientationSaysSo) {
  const auto message = imu_message({0.1, 0.2, 0.3}, {1, 2, 9.8});
  EXPECT_EQ(from_message(message.angular_velocity), Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(from_message(message.linear_acceleration), Eigen::Vector3d(1, 2, 9.8));
  EXPECT_EQ(message.orientation_covariance[0], -1);
  EXPECT_EQ(message.angular_velocity_covariance[0], 0);
}

}  // namespace
}  // namespace pipescout
