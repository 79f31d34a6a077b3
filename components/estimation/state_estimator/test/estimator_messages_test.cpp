// SPDX-License-Identifier: Apache-2.0
#include "estimator_messages.hpp"

#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "pipescout/runtime/conversions.hpp"

namespace pipescout {
namespace {

using pipescout_msgs::msg::FusedOdometer;
using sensor_msgs::msg::NavSatFix;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

EstimatorSettings settings() {
  EstimatorSettings result;
  result.gps_deviation = 2;
  result.least_gps_deviation = 0.1;
  result.heading_deviation = 0.2;
  return result;
}

sensor_msgs::msg::NavSatFix fix() {
  sensor_msgs::msg::NavSatFix message;
  message.latitude = 47.0;
  message.longitude = 8.0;
  message.altitude = 500.0;
  message.position_covariance = {1, 0.2, 0, 0.2, 2, 0, 0, 0, 9};
  message.position_covariance_type = NavSatFix::COVARIANCE_TYPE_KNOWN;
  return message;
}

const geometry::LocalFrame kMap({47.0, 8.0, 490.0});

TEST(GpsMeasurement, IsInTheMap) {
  const auto measured = gps_measurement(fix(), 3, kMap, 0, settings());
  EXPECT_EQ(measured.time, 3);
  EXPECT_LT((measured.position - Eigen::Vector3d(0, 0, 10)).norm(), 1e-6);
  EXPECT_NEAR(measured.covariance(0, 1), 0.2, 1e-9);
  EXPECT_NEAR(measured.covariance(2, 2), 9, 1e-9);
}

TEST(GpsMeasurement, WithoutACovarianceHasThatOfTheParameter) {
  auto message = fix();
  message.position_covariance_type = NavSatFix::COVARIANCE_TYPE_UNKNOWN;
  EXPECT_EQ(gps_measurement(message, 0, kMap, 0, settings()).covariance,
            Eigen::Matrix3d(4 * Eigen::Matrix3d::Identity()));
  auto none = settings();
  none.gps_deviation = 0;
  EXPECT_THROW((void)gps_measurement(message, 0, kMap, 0, none), std::invalid_argument);
}

TEST(GpsMeasurement, ClaimsNoMoreThanItMay) {
  auto message = fix();
  message.position_covariance = {1e-8, 0, 0, 0, 1e-8, 0, 0, 0, 1e-8};
  const auto measured = gps_measurement(message, 0, kMap, 0, settings());
  EXPECT_NEAR(measured.covariance(0, 0), 0.01, 1e-9);
  message.position_covariance = {};  // zeros state nothing
  EXPECT_NEAR(gps_measurement(message, 0, kMap, 0, settings()).covariance(2, 2),
              std::pow(settings().gps_deviation, 2), 1e-9);
}

TEST(GpsMeasurement, WithoutAnAltitudeSaysNothingOfTheHeight) {
  auto message = fix();
  message.altitude = kNan;
  const auto measured = gps_measurement(message, 0, kMap, 7, settings());
  EXPECT_EQ(measured.position.z(), 7);
  EXPECT_GT(measured.covariance(2, 2), 1e6);
  EXPECT_EQ(measured.covariance(0, 2), 0);
  EXPECT_NEAR(measured.covariance(0, 0), 1, 1e-9);
}

TEST(GpsMeasurement, RefusesPlacesThatAreNone) {
  for (const double bad : {kNan, 91.0}) {
    auto message = fix();
    message.latitude = bad;
    try {
      (void)gps_measurement(message, 0, kMap, 0, settings());
      FAIL() << "latitude " << bad;
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), HasSubstr("latitude"));
    }
  }
}

TEST(OdometerReading, HasTheIndependentPartOfTheVariance) {
  pipescout_msgs::msg::FusedOdometer message;
  message.distance = 12;
  message.variance = 4;
  message.independent_variance = 0.25;
  EXPECT_EQ(odometer_reading(message, 1).variance, 0.25);
  message.independent_variance = kNan;
  EXPECT_EQ(odometer_reading(message, 1).variance, 4);
  EXPECT_EQ(odometer_reading(message, 1).distance, 12);
}

TEST(OdometerReading, SaysWhetherTheOdometersAgree) {
  pipescout_msgs::msg::FusedOdometer message;
  EXPECT_EQ(odometer_reading(message, 0).status, estimation::OdometerStatus::kGood);
  message.status = FusedOdometer::STATUS_NO_CONSENSUS;
  EXPECT_EQ(odometer_reading(message, 0).status, estimation::OdometerStatus::kNoConsensus);
  for (const std::uint8_t status : {FusedOdometer::STATUS_NO_DATA, std::uint8_t{200}}) {
    message.status = status;
    EXPECT_EQ(odometer_reading(message, 0).status, estimation::OdometerStatus::kNoData);
  }
}

TEST(Heading, IsThatOfTheBody) {
  auto turned = settings();
  turned.estimator.R_body_imu = geometry::SO3::about_z(M_PI_2);  // the IMU looks to the left
  sensor_msgs::msg::Imu message;
  message.orientation.w = std::cos(0.6);
  message.orientation.z = std::sin(0.6);
  const auto measured = heading(message, 4, turned);
  ASSERT_TRUE(measured);
  EXPECT_NEAR(measured->heading, 1.2 - M_PI_2, 1e-12);
  EXPECT_EQ(measured->standard_deviation, 0.2);
  message.orientation_covariance[8] = 0.01;
  EXPECT_NEAR(heading(message, 4, turned)->standard_deviation, 0.1, 1e-12);
}

TEST(Heading, IsNotThereWhereTheDriverSaysSo) {
  sensor_msgs::msg::Imu message;
  message.orientation_covariance[0] = -1;
  EXPECT_FALSE(heading(message, 0, settings()));
  message.orientation_covariance[0] = 0;
  message.orientation.w = 0;
  EXPECT_THROW((void)heading(message, 0, settings()), std::invalid_argument);  // a zero quaternion
}

TEST(StateMessage, BeforeTheStartSaysWhatItWaitsFor) {
  const estimation::StateEstimator estimator(estimation::StateEstimatorParameters::ground_robot());
  const auto message = state_message(estimator, estimator.status(), Time{});
  EXPECT_EQ(message.phase, "starting");
  EXPECT_THAT(message.waits_for, HasSubstr("IMU"));
  EXPECT_EQ(message.source.size(), estimation::kSources);
  EXPECT_EQ(message.source_state.size(), estimation::kSources);
  EXPECT_TRUE(message.factor.empty());
}

TEST(Transform, NamesItsFrames) {
  const auto message = transform(geometry::SE3(geometry::SO3::about_z(M_PI_2), {1, 2, 3}),
                                 Time(std::chrono::seconds(5)), "map", "odom");
  EXPECT_EQ(message.header.frame_id, "map");
  EXPECT_EQ(message.child_frame_id, "odom");
  EXPECT_EQ(message.header.stamp.sec, 5);
  EXPECT_EQ(message.transform.translation.y, 2);
  EXPECT_NEAR(message.transform.rotation.z, std::sqrt(0.5), 1e-12);
}

}  // namespace
}  // namespace pipescout
