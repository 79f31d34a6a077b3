// SPDX-License-Identifier: Apache-2.0
#include "tables/rack_lines.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

namespace pipescout::summary {
namespace {

using pipescout_msgs::msg::RackState;
using ::testing::HasSubstr;

auto columns(const std::string& line) {
  return std::count(line.begin(), line.end(), ',') + 1;
}

TEST(CsvLines, State) {
  pipescout_msgs::msg::RackState message;
  message.status = RackState::STATUS_LOST;
  message.quality = 0.5;
  message.inlier_share = std::numeric_limits<double>::quiet_NaN();
  message.edges = 7;
  message.losses = 2;
  EXPECT_EQ(columns(state_csv_line(message)), columns(state_csv_header()));
  EXPECT_EQ(state_csv_line(message), "0.000000000,lost,0.5,,nan,7,0,0,0,0,0,0,2");
  message.reason = "a \"b\",\nc";
  EXPECT_THAT(state_csv_line(message), HasSubstr(",\"a \"\"b\"\", c\","));
  message.reason = std::string(100000, 'a');
  EXPECT_LT(state_csv_line(message).size(), 400U);
  message.status = 77;
  EXPECT_THAT(state_csv_line(message), HasSubstr(",unknown,"));
}

TEST(CsvLines, Offset) {
  pipescout_msgs::msg::RackState message;
  message.pipe = {"water", "gas"};
  message.offset = {0.0, 0.05};
  message.offset_variance = {0.0, 0.0625};
  message.offset_observed = {false, true};
  EXPECT_EQ(columns(offset_csv_line(message, 0)), columns(offset_csv_header()));
  EXPECT_EQ(offset_csv_line(message, 1), "0.000000000,gas,0.05,0.25,1");
}

TEST(CsvLines, CommandWayPointAndImage) {
  geometry_msgs::msg::TwistStamped command;
  command.twist.linear.x = 0.5;
  command.twist.angular.z = -0.25;
  EXPECT_EQ(columns(command_csv_line(command)), columns(command_csv_header()));
  EXPECT_EQ(command_csv_line(command), "0.000000000,0.5,0,0,0,0,-0.25");
  pipescout_msgs::msg::MissionStatus status;
  status.done = 1;
  status.total = 4;
  status.message = "1 of 4 reached";
  EXPECT_EQ(columns(way_point_csv_line(status)), columns(way_point_csv_header()));
  EXPECT_EQ(way_point_csv_line(status), "0.000000000,1,4,1 of 4 reached");
  EXPECT_EQ(columns(image_csv_header()), 2);
  EXPECT_EQ(image_csv_line({}, "images/000000.pgm"), "0.000000000,images/000000.pgm");
}

}  // namespace
}  // namespace pipescout::summary
