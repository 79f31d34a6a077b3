// SPDX-License-Identifier: Apache-2.0
#include "tables/estimator_lines.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/motion.hpp"
#include "pipescout/runtime/conversions.hpp"

namespace pipescout::summary {
namespace {

using pipescout_msgs::msg::EstimatorState;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

auto columns(const std::string& line) {
  return std::count(line.begin(), line.end(), ',') + 1;
}

TEST(CsvLines, Estimate) {
  nav_msgs::msg::Odometry message;
  message.header.stamp = to_message(Time{} + std::chrono::seconds(3));
  message.twist.twist = twist_message({1.5, 0.0, -0.5}, {0.0, 0.0, 0.25});
  message.twist.covariance[0] = 0.0625;
  message.twist.covariance[35] = -1e-12;
  const std::string line =
      estimate_csv_line(message, geometry::SE3(geometry::SO3(), {1.0, 2.0, 3.0}),
                        geometry::Matrix6d(geometry::Matrix6d::Identity() * 0.25));
  EXPECT_EQ(columns(line), columns(estimate_csv_header()));
  EXPECT_THAT(line, StartsWith("3.000000000,1,2,3,0,0,0,1,0,0,0,0.5,"));
  EXPECT_THAT(line, EndsWith(",1.5,0,-0.5,0,0,0.25,0.25,0,0,0,0,0"));
  EXPECT_THAT(estimate_csv_header(), HasSubstr(",linear_x,linear_y,linear_z,angular_x,"));
  EXPECT_THAT(estimate_csv_header(), EndsWith(",angular_z_standard_deviation"));
}

TEST(CsvLines, Error) {
  EstimatorReport::Error error{.position_nees = 2.5, .pose_nees = 7.0};
  error.error << 0.5, 0.0, -0.25, 0.0, 0.0, 0.125;
  EXPECT_EQ(columns(error_csv_line({}, error)), columns(error_csv_header()));
  EXPECT_EQ(error_csv_line({}, error), "0.000000000,0.5,0,-0.25,0,0,0.125,2.5,7");
}

TEST(CsvLines, State) {
  EstimatorState message;
  message.phase = "starting";
  message.waits_for = "a heading";
  message.since_absolute_position = std::numeric_limits<double>::quiet_NaN();
  message.restart_reason = "none";
  message.gyro_bias = to_message(Eigen::Vector3d(1.0, 2.0, 3.0));
  std::string line = estimator_state_csv_line(message);
  EXPECT_EQ(columns(line), columns(estimator_state_csv_header()));
  EXPECT_THAT(line, StartsWith("0.000000000,starting,a heading,0,nan,0,none,,,,"))
      << "its biases are void";
  message.phase = "running";
  message.waits_for = "";
  message.standing_still = true;
  message.since_absolute_position = 0.5;
  message.gyro_bias_deviation = to_message(Eigen::Vector3d(0.25, 0.25, 0.5));
  line = estimator_state_csv_line(message);
  EXPECT_EQ(columns(line), columns(estimator_state_csv_header()));
  EXPECT_THAT(line,
              StartsWith("0.000000000,running,,1,0.5,0,none,1,2,3,0.25,0.25,0.5,0,0,0,0,0,0,,"));
  EXPECT_THAT(line, EndsWith(",,,,,,,,,,,,,,")) << "neither scale nor rack is estimated";
}

TEST(CsvLines, StateOfARobotWithOdometerOverARack) {
  EstimatorState message;
  message.phase = "coasting";
  message.odometer_scale = 1.01;
  message.odometer_scale_deviation = 0.005;
  message.rack.pose = to_message(geometry::SE3(geometry::SO3::about_z(0.5), {7.0, 8.0, 9.0}));
  message.rack.covariance = to_message(geometry::Matrix6d(geometry::Matrix6d::Identity() * 0.04));
  const std::string line = estimator_state_csv_line(message);
  EXPECT_EQ(columns(line), columns(estimator_state_csv_header()));
  EXPECT_THAT(line, HasSubstr(",1.01,0.005,7,8,9,0,0,0.5,0.2,0.2,"));
  message.rack.pose.position.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)estimator_state_csv_line(message), std::invalid_argument);
}

TEST(CsvLines, FactorSourceAndFix) {
  EstimatorState message;
  message.factor = {"gps", "odometer"};
  message.factor_stamp = {to_message(Time{}), to_message(Time{} + std::chrono::seconds(2))};
  message.factor_outcome = {"gated", "accepted"};
  message.factor_chi_square = {100.0, 1.5};
  message.factor_degrees = {3, 1};
  message.factor_weight = {0.0, 0.75};
  EXPECT_EQ(columns(factor_csv_line(message, 0)), columns(factor_csv_header()));
  EXPECT_EQ(factor_csv_line(message, 1), "2.000000000,odometer,accepted,1.5,1,0.75");
  message.source = {"gps"};
  message.source_state = {"doubted"};
  message.source_accepted = {5};
  message.source_gated = {6};
  message.source_held = {7};
  message.source_refused = {8};
  EXPECT_EQ(columns(source_csv_line(message, 0)), columns(source_csv_header()));
  EXPECT_EQ(source_csv_line(message, 0), "0.000000000,gps,doubted,5,6,7,8");
  const GpsPlace fix{.place = {46.5, -8.25, std::numeric_limits<double>::quiet_NaN()}};
  EXPECT_EQ(columns(gps_csv_line(fix, {})), columns(gps_csv_header()));
  EXPECT_EQ(gps_csv_line(fix, {1.0, 2.0, 3.0}), "0.000000000,46.5,-8.25,nan,1,2,3");
}

}  // namespace
}  // namespace pipescout::summary
