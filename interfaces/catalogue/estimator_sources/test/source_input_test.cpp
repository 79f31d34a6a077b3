// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimator_sources/source_input.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/motion.hpp"

namespace pipescout {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;
using ::testing::HasSubstr;

constexpr double kLargestSpeed = 30;  // m/s

SourceInput input_of(NamedSourceKind kind) {
  return {default_source("one", kind), 3, kLargestSpeed};
}

TEST(SourceInputTest, FactorsAreOfTheKindOfTheSourcesPlace) {
  SourceInput compass = input_of(NamedSourceKind::kMagneticField);
  sensor_msgs::msg::MagneticField field;
  field.magnetic_field = to_message(Vector3d(0, 2e-5, 0));
  const SourceNews news = compass.take(field, 5, {});
  ASSERT_TRUE(news.factor);
  EXPECT_EQ(news.factor->kind(), estimation::own_kind(3));
  EXPECT_EQ(news.factor->to_time(), 5);
  EXPECT_FALSE(news.motion);
}

TEST(SourceInputTest, TheFirstPoseIsNoMotionAndAJumpIsTold) {
  SourceInput lidar = input_of(NamedSourceKind::kOdometryPose);
  nav_msgs::msg::Odometry odometry;
  const auto at = [&](double x, double time) {
    odometry.pose.pose = to_message(SE3(SO3(), Vector3d(x, 0, 0)));
    return lidar.take(odometry, time, {});
  };
  EXPECT_FALSE(at(5, 0).factor);
  EXPECT_TRUE(at(5.1, 0.1).factor);
  const SourceNews jump = at(105.1, 0.2);
  EXPECT_FALSE(jump.factor);
  EXPECT_NEAR(jump.jumped, 100, 1e-9);
  EXPECT_TRUE(at(105.2, 0.3).factor);  // goes on from there
  EXPECT_FALSE(at(105.2, 0.3).factor);
}

// A sensor half a metre to the left of the body's origin, on a body that turns to the left.
TEST(SourceInputTest, VelocityOfABaseIsAMotionOfTheBody) {
  SourceInput base = input_of(NamedSourceKind::kBaseVelocity);
  geometry_msgs::msg::TwistWithCovarianceStamped twist;
  twist.twist.twist.linear = to_message(Vector3d(1, 0, 0));
  twist.twist.twist.angular = to_message(Vector3d(0, 0, 0.4));
  const SourceNews news = base.take(twist, 2, {.T_body_sensor = SE3(SO3(), Vector3d(0, 0.5, 0))});
  ASSERT_TRUE(news.factor);
  ASSERT_TRUE(news.motion);
  EXPECT_NEAR(news.motion->speed, 1.2, 1e-12);
  EXPECT_EQ(news.motion->yaw_rate, 0.4);
}

TEST(SourceInputTest, FixesWaitForTheMapAndRangesForABeacon) {
  SourceInput antenna = input_of(NamedSourceKind::kGpsFix);
  sensor_msgs::msg::NavSatFix fix;
  fix.latitude = 47;
  fix.longitude = 8;
  EXPECT_FALSE(antenna.take(fix, 0, {}).factor);
  const geometry::LocalFrame map({47, 8, 0});
  EXPECT_TRUE(antenna.take(fix, 0, {.map = &map}).factor);
  fix.status.status = sensor_msgs::msg::NavSatStatus::STATUS_NO_FIX;
  EXPECT_FALSE(antenna.take(fix, 0, {.map = &map}).factor);
  sensor_msgs::msg::Range range;
  range.range = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(input_of(NamedSourceKind::kRange).take(range, 0, {}).factor);
}

TEST(SourceInputTest, MessagesOfAnotherKindAreRefusedByName) {
  SourceInput compass = input_of(NamedSourceKind::kMagneticField);
  try {
    static_cast<void>(compass.take(sensor_msgs::msg::Range{}, 0, {}));
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("sensor_msgs/msg/MagneticField"));
  }
}

TEST(NamedSourceTest, KindsAreFoundByTheirNames) {
  for (std::size_t i = 0; i < kNamedSourceKinds; ++i) {
    const auto kind = static_cast<NamedSourceKind>(i);
    EXPECT_EQ(named_source_kind(to_string(kind)), kind);
    EXPECT_THAT(all_named_source_kinds(), HasSubstr(std::string(to_string(kind))));
    EXPECT_NE(message_type_of(kind), "");
  }
  EXPECT_FALSE(named_source_kind("sundial"));
}

TEST(NamedSourceTest, EachGetsItsPlaceAndItsBias) {
  std::vector<NamedSource> sources = {default_source("compass", NamedSourceKind::kMagneticField),
                                      default_source("barometer", NamedSourceKind::kFluidPressure)};
  sources[0].correlation_time = 2;
  sources[1].gate = 0.99;
  auto estimator = estimation::StateEstimatorParameters::ground_robot();
  place_sources(sources, estimator);
  EXPECT_EQ(sources[0].bias, -1);
  EXPECT_EQ(sources[1].bias, 0);
  ASSERT_EQ(estimator.own_sources.size(), 2U);
  EXPECT_EQ(estimator.own_sources[0].correlation_time, 2);
  EXPECT_EQ(estimator.smoother.global_deviations.own[0], 1000);
  const auto kind = static_cast<std::size_t>(estimation::own_kind(1));
  EXPECT_EQ(estimator.smoother.robustness[kind].gate_probability, 0.99);
  EXPECT_NO_THROW(estimator.validate());
}

TEST(NamedSourceTest, TheMountingAndTheDelayOfAPoseAreStates) {
  std::vector<NamedSource> sources = {default_source("barometer", NamedSourceKind::kFluidPressure),
                                      default_source("markers", NamedSourceKind::kPose)};
  sources[1].mounting_position_deviation = 0.03;
  sources[1].mounting_rotation_deviation = 0.02;
  sources[1].time_offset_deviation = 0.05;
  auto estimator = estimation::StateEstimatorParameters::uav();
  place_sources(sources, estimator);
  EXPECT_EQ(sources[0].bias, 0);
  EXPECT_EQ(sources[1].clock, 1);
  EXPECT_EQ(sources[1].mounting, 2);
  EXPECT_EQ(estimator.smoother.global_deviations.own[1], 0.05);
  EXPECT_EQ(estimator.smoother.global_deviations.own[7], 0.02);
  EXPECT_NO_THROW(estimator.validate());
  sources[0].bias_deviation = 0;
  sources.push_back(sources[1]);
  estimator = estimation::StateEstimatorParameters::uav();
  EXPECT_THROW(place_sources(sources, estimator), std::invalid_argument);
}

TEST(NamedSourceTest, WhatIsMissingOrTooMuchIsNamed) {
  auto estimator = estimation::StateEstimatorParameters::ground_robot();
  const auto refused = [&](std::vector<NamedSource> sources) -> std::string {
    try {
      place_sources(sources, estimator);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return {};
  };
  EXPECT_THAT(refused({default_source("anchor", NamedSourceKind::kRange)}),
              HasSubstr("anchor.beacon"));
  EXPECT_THAT(refused({default_source("base", NamedSourceKind::kWheelEncoders)}),
              HasSubstr("source 'base'"));
  const NamedSource velocity = default_source("velocity", NamedSourceKind::kGpsVelocity);
  EXPECT_THAT(refused(std::vector<NamedSource>(17, velocity)), HasSubstr("more than 16"));
  const NamedSource barometer = default_source("barometer", NamedSourceKind::kFluidPressure);
  EXPECT_THAT(refused(std::vector<NamedSource>(9, barometer)),
              HasSubstr("barometer.bias_deviation"));
}

}  // namespace
}  // namespace pipescout
