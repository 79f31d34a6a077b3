// SPDX-License-Identifier: Apache-2.0
#include "tables/crawler_lines.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

namespace pipescout::summary {
namespace {

using pipescout_msgs::msg::BendDetection;
using pipescout_msgs::msg::EddyCurrentSamples;
using pipescout_msgs::msg::FusedOdometer;
using pipescout_msgs::msg::PipePosition;
using pipescout_msgs::msg::WeldDetection;

auto columns(const std::string& line) {
  return std::count(line.begin(), line.end(), ',') + 1;
}

TEST(CsvLines, FusedDistance) {
  FusedOdometer message;
  message.header.stamp.sec = 12;
  message.header.stamp.nanosec = 500000000;
  message.distance = 3.25;
  message.variance = 0.0004;
  message.speed = 0.5;
  message.name = {"a", "b"};
  message.in_fusion_set = {true, false};
  message.support = {1, 1, 0, 1};
  message.rejection_reason = {FusedOdometer::REJECTED_NONE, FusedOdometer::REJECTED_STUCK};
  message.health = {FusedOdometer::HEALTH_OK, FusedOdometer::HEALTH_STUCK};
  message.scale = {1.0, 1.5};
  message.scale_standard_deviation = {0.25, 0.5};
  EXPECT_EQ(fused_csv_header({"a", "b"}),
            "stamp,distance,standard_deviation,speed,status,support,a.rejection,a.health,a.scale,"
            "a.scale_standard_deviation,b.rejection,b.health,b.scale,b.scale_standard_deviation");
  EXPECT_EQ(fused_csv_line(message),
            "12.500000000,3.25,0.02,0.5,ok,1>2,none,ok,1,0.25,stuck,stuck,1.5,0.5");
  message.health.clear();
  EXPECT_EQ(fused_csv_line(message), "12.500000000,3.25,0.02,0.5,ok,1>2,none,,,,stuck,,,");
}

TEST(CsvLines, Weld) {
  WeldDetection message;
  message.distance = 1.5;
  message.weld = -1;
  EXPECT_EQ(columns(weld_csv_line(message)), columns(weld_csv_header()));
  message.weld = 7;
  message.weld_id = "W7";
  message.weld_probability = 1.0;
  message.chainage = 84.0;
  message.chainage_variance = 0.25;
  EXPECT_EQ(weld_csv_line(message), "0.000000000,girth weld,1.5,0,0,0,0,7,W7,1,84,0.5");
  message.weld_id = "a,\"b\"";
  EXPECT_NE(weld_csv_line(message).find("\"a,\"\"b\"\"\""), std::string::npos);
}

TEST(CsvLines, Bend) {
  BendDetection message;
  message.distance = 25.5;
  message.length = 3.0;
  message.angle = 0.75;
  message.direction = -1.5;
  message.probability = 1.0;
  EXPECT_EQ(columns(bend_csv_line(message)), columns(bend_csv_header()));
  EXPECT_EQ(bend_csv_line(message), "0.000000000,25.5,0,3,0.75,0,-1.5,1");
}

TEST(CsvLines, Position) {
  PipePosition message;
  message.locked = true;
  message.joint = 4;
  message.orientation = 1;
  message.covariance = {0.25, 0.0, 0.0, 1.0};
  message.chainage = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(columns(position_csv_line(message)), columns(position_csv_header()));
  EXPECT_EQ(position_csv_line(message), "0.000000000,0,0,1,4,0,backward,0,nan,0.5,0,1,0,0,0,0");
  message.orientation = 9;
  EXPECT_NE(position_csv_line(message).find(",unknown,"), std::string::npos);
}

TEST(CsvLines, Samples) {
  EddyCurrentSamples message;
  message.sample_interval = 0.5;
  message.channels = 2;
  message.x = {1.0, 2.0, 0.1, 4.0};
  message.y = {5.0, 6.0, std::numeric_limits<double>::quiet_NaN(), 8.0};
  EXPECT_EQ(samples_csv_header(2), "stamp,x1,y1,x2,y2");
  EXPECT_EQ(samples_csv_line(message, 0), "0.000000000,1,5,2,6");
  EXPECT_EQ(samples_csv_line(message, 1), "0.500000000,0.1,nan,4,8");
}

}  // namespace
}  // namespace pipescout::summary
