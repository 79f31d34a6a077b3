// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/geometry.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace pipescout {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

geometry::SE3 some_pose() {
  return {geometry::SO3::from_roll_pitch_yaw({0.1, -0.2, 3.0}), {1, -2, 3}};
}

geometry::Matrix6d some_covariance() {
  geometry::Matrix6d m = geometry::Matrix6d::Identity();
  m(0, 4) = m(4, 0) = 0.3;
  m(1, 1) = 1e6;
  return m;
}

TEST(PoseMessage, RoundTrip) {
  const geometry::SE3 back = from_message(to_message(some_pose()));
  EXPECT_TRUE(back.matrix().isApprox(some_pose().matrix(), 1e-14));
}

TEST(PoseMessage, NormalisesWhatRoundingLeft) {
  auto message = to_message(some_pose());
  message.orientation.w = message.orientation.w + 5e-4;
  EXPECT_NEAR(from_message(message).rotation().quaternion().norm(), 1, 1e-15);
}

TEST(PoseMessage, NamesTheFieldThatIsNotANumber) {
  auto message = to_message(some_pose());
  message.position.y = kNan;
  EXPECT_THAT([&] { (void)from_message(message); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("position.y")));
  message = to_message(some_pose());
  message.orientation.z = std::numeric_limits<double>::infinity();
  EXPECT_THAT([&] { (void)from_message(message); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("orientation.z")));
}

TEST(PoseMessage, RefusesAnOrientationOfZeros) {
  geometry_msgs::msg::Pose message;
  message.orientation.w = 0;
  EXPECT_THAT([&] { (void)from_message(message); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("orientation has a norm of 0")));
}

TEST(CovarianceMessage, RoundTrip) {
  EXPECT_EQ(covariance_from_message(to_message(some_covariance())), some_covariance());
}

TEST(CovarianceMessage, NamesWhatIsWrong) {
  auto message = to_message(some_covariance());
  message[7] = kNan;
  EXPECT_THAT([&] { (void)covariance_from_message(message); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("covariance[7]")));
  message[7] = 0;
  EXPECT_THAT([&] { (void)covariance_from_message(message); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("above 0")));
  message = to_message(some_covariance());
  message[4] = -0.3;
  EXPECT_THAT([&] { (void)covariance_from_message(message); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("not symmetric")));
  message[4] = message[24] = 1.5;
  EXPECT_THAT([&] { (void)covariance_from_message(message); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("positive definite")));
}

}  // namespace
}  // namespace pipescout
