// SPDX-License-Identifier: Apache-2.0
#include "../src/source_messages.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/motion.hpp"

namespace pipescout {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;

// A sensor that looks to the left, half a metre ahead of the body's origin.
const SE3 kLeft(SO3::about_z(M_PI_2), Vector3d(0.5, 0, 0.2));

TEST(SourceMessagesTest, VelocityOfAReceiverIsHorizontalWithoutCovariance) {
  geometry_msgs::msg::TwistStamped message;
  message.twist.linear = to_message(Vector3d(1, -2, 0));
  const auto m = velocity_measurement(message, 3, {.deviation = 0.2}, kLeft, Vector3d(0, 0, 0.1));
  EXPECT_EQ(m.time, 3);
  EXPECT_EQ(m.velocity, Vector3d(1, -2, 0));
  EXPECT_NEAR(m.covariance(0, 0), 0.04, 1e-12);
  EXPECT_GT(m.covariance(2, 2), 1e5);
  EXPECT_EQ(m.sensor, kLeft.translation());
  EXPECT_EQ(m.angular_rate, Vector3d(0, 0, 0.1));
  EXPECT_EQ(check(m), estimation::InputFault::kNone);
}

TEST(SourceMessagesTest, VariancesOfZeroAreUnknown) {
  geometry_msgs::msg::TwistWithCovarianceStamped message;
  message.twist.twist.linear = to_message(Vector3d(1, 0, 0));
  message.twist.covariance[0] = 0.01;
  message.twist.covariance[7] = -1;
  const NamedSource source{.deviation = 0.2};
  const auto in_map = velocity_measurement(message, 0, source, kLeft, Vector3d::Zero());
  EXPECT_EQ(Vector3d(in_map.covariance.diagonal()), Vector3d(0.01, 0.2 * 0.2, 0.2 * 0.2));
  // In the axes of the sensor: what is ahead of it is to the left of the body.
  const auto in_body = body_velocity_measurement(message.twist, 0, source, kLeft, Vector3d::Zero());
  EXPECT_LT((in_body.velocity - Vector3d(0, 1, 0)).norm(), 1e-12);
  EXPECT_NEAR(in_body.covariance(1, 1), 0.01, 1e-12);
  EXPECT_NEAR(in_body.covariance(0, 0), 0.04, 1e-12);
  EXPECT_EQ(check(in_body), estimation::InputFault::kNone);
}

TEST(SourceMessagesTest, NumbersThatAreNotFiniteAreRefusedByTheFactor) {
  sensor_msgs::msg::FluidPressure pressure;
  pressure.fluid_pressure = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(check(height_measurement(pressure, 0, {.deviation = 1}, kLeft)),
            estimation::InputFault::kNotFinite);
  pressure.fluid_pressure = 101325;
  EXPECT_NEAR(height_measurement(pressure, 0, {.deviation = 1}, kLeft).height, 0, 1e-9);
  geometry_msgs::msg::TwistWithCovarianceStamped twist;
  twist.twist.covariance[1] = std::numeric_limits<double>::infinity();
  twist.twist.covariance[0] = twist.twist.covariance[7] = twist.twist.covariance[14] = 1;
  EXPECT_NE(check(velocity_measurement(twist, 0, {.deviation = 1}, kLeft, Vector3d::Zero())),
            estimation::InputFault::kNone);
}

TEST(SourceMessagesTest, AFieldIsTurnedIntoTheBody) {
  sensor_msgs::msg::MagneticField message;
  message.magnetic_field = to_message(Vector3d(2e-5, 0, -4e-5));
  const auto m = magnetic_field_measurement(
      message, 0, {.deviation = 0.1, .declination = 0.05, .bias = 3}, kLeft);
  EXPECT_LT((m.field - Vector3d(0, 2e-5, -4e-5)).norm(), 1e-15);
  EXPECT_EQ(m.declination, 0.05);
  EXPECT_EQ(m.bias, 3);
}

TEST(SourceMessagesTest, PosesOfASensorBecomeAMotionOfTheBody) {
  const SE3 T_map_from(SO3::about_z(0.3), Vector3d(1, 2, 0));
  const SE3 T_map_to(SO3::about_z(0.5), Vector3d(1.4, 2.1, 0));
  const SE3 T_odom_map(SO3::about_z(-1), Vector3d(7, 8, 9));
  const auto m = relative_pose_measurement({1, T_odom_map * T_map_from * kLeft},
                                           {1.1, T_odom_map * T_map_to * kLeft},
                                           {.deviation = 0.02, .rotation_deviation = 0.01}, kLeft);
  const SE3 expected = T_map_from.inverse() * T_map_to;
  EXPECT_LT((m.T_from_to.translation() - expected.translation()).norm(), 1e-12);
  EXPECT_LT((m.T_from_to.rotation().inverse() * expected.rotation()).log().norm(), 1e-12);
  EXPECT_EQ(check(m), estimation::InputFault::kNone);
}

TEST(SourceMessagesTest, APoseOfTheSensorIsThatOfTheBody) {
  const SE3 T_map_body(SO3::about_z(0.3), Vector3d(4, 5, 6));
  geometry_msgs::msg::PoseWithCovarianceStamped message;
  message.pose.pose = to_message(T_map_body * kLeft);
  message.pose.covariance[0] = message.pose.covariance[7] = message.pose.covariance[14] = 0.01;
  NamedSource source{.deviation = 0.2, .rotation_deviation = 0.1};
  source.mounting = 2;
  source.clock = 1;
  const auto m = pose_measurement(message, 3, source, kLeft, Vector3d(0, 0, 0.1));
  EXPECT_EQ(m.time, 3);
  EXPECT_LT((m.T_rack_body.inverse() * T_map_body).log().norm(), 1e-9);
  EXPECT_EQ(m.camera, kLeft.translation());
  EXPECT_EQ(m.mounting, 2);
  EXPECT_EQ(m.clock, 1);
  EXPECT_EQ(m.angular_rate, Vector3d(0, 0, 0.1));
  // The rotation is not stated: it moves the body, which is half a metre from the sensor.
  EXPECT_NEAR(m.covariance(5, 5), 0.01, 1e-9);
  EXPECT_NEAR(m.covariance(2, 2), 0.01 + 0.01 * 0.25, 1e-9);
  EXPECT_EQ(check(m), estimation::InputFault::kNone);
  message.pose.pose.orientation.w = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)pose_measurement(message, 3, source, kLeft, Vector3d::Zero()),
               std::invalid_argument);
}

}  // namespace
}  // namespace pipescout
