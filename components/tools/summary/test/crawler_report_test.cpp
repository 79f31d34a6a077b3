// SPDX-License-Identifier: Apache-2.0
#include "tables/crawler_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace pipescout::summary {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

Time at(double seconds) {
  return Time{} + from_seconds(seconds);
}

CrawlerReport::Position position(double time, std::uint32_t joint, double into) {
  return {.stamp = at(time),
          .locked = true,
          .joint = joint,
          .into_joint = into,
          .standard_deviation = 0.01,
          .odometer_distance = 12.0 * joint + into};
}

TEST(CrawlerReport, ComparesPositionsWithTheTruthBetweenItsStamps) {
  CrawlerReport report(10);
  report.add_truth(position(1.0, 2, 4.0));
  report.add_truth(position(2.0, 2, 6.0));
  report.add_position(position(1.5, 2, 5.015));  // 1.5 cm off, within 1.96 cm
  report.add_position(position(2.0, 2, 6.05));
  const auto figures = report.section("").figures;
  EXPECT_EQ(figures.at("crawler_positions"), 2.0);
  EXPECT_NEAR(figures.at("crawler_in_joint_worst_m"), 0.05, 1e-9);
  EXPECT_EQ(figures.at("crawler_coverage95_percent"), 50.0);
  EXPECT_EQ(figures.at("crawler_wrong_joint"), 0.0);
  EXPECT_EQ(figures.at("crawler_distance_m"), 30.05);
}

TEST(CrawlerReport, CountsAWrongJointButNotTheNextOneAtAWeld) {
  CrawlerReport report(10);
  report.add_truth(position(1.0, 2, 11.99));
  report.add_position(position(1.0, 3, 0.01));
  EXPECT_EQ(report.section("").figures.count("crawler_wrong_joint"), 0U);
  report.add_truth(position(2.0, 3, 0.2));
  report.add_position(position(2.0, 2, 12.1));
  EXPECT_EQ(report.section("").figures.count("crawler_wrong_joint"), 0U);
  report.add_truth(position(3.0, 3, 5.0));
  report.add_position(position(3.0, 4, 5.0));
  report.add_truth(position(4.0, 3, 6.0));
  report.add_position(position(4.0, 9, 0.1));
  EXPECT_EQ(report.section("").figures.at("crawler_wrong_joint"), 2.0);
  EXPECT_EQ(report.section("").figures.at("crawler_coverage95_percent"), 0.0);
}

TEST(CrawlerReport, SaysWhenItLocked) {
  CrawlerReport report(10);
  EXPECT_THAT(report.section("").notes, Contains(HasSubstr("never locked")));
  auto lost = position(1.0, 0, 0.0);
  lost.locked = false;
  report.add_position(lost);
  report.add_weld({.chainage = std::numeric_limits<double>::quiet_NaN(), .distance = 3.0});
  report.add_weld({.id = "W2", .chainage = 24.0, .distance = 15.0});
  report.add_position(position(2.0, 2, 0.1));
  const auto section = report.section("robot_1.");
  EXPECT_EQ(section.figures.at("robot_1.crawler_welds_to_lock"), 2.0);
  EXPECT_EQ(section.figures.at("robot_1.crawler_welds"), 2.0);
  EXPECT_EQ(section.figures.at("robot_1.crawler_welds_recognised"), 1.0);
  EXPECT_EQ(section.figures.at("robot_1.crawler_positions_locked"), 1.0);
  ASSERT_EQ(section.rows.size(), 2U);
  EXPECT_EQ(section.rows[0][1], MissionCell(std::monostate{}));
}

TEST(CrawlerReport, StaysSmall) {
  CrawlerReport report(5);
  for (int k = 0; k < 20000; ++k) {
    report.add_weld({.id = "W", .chainage = 1.0 * k});
    report.add_truth(position(k, 1, 1.0));
    report.add_position(position(k, 1, 1.0));
  }
  const auto section = report.section("");
  EXPECT_EQ(section.rows.size(), 5U);
  EXPECT_THAT(section.notes, Contains(HasSubstr("first 5 of 20000 welds")));
  EXPECT_NEAR(section.figures.at("crawler_in_joint_p95_m"), 0.001, 1e-12);
}

TEST(CrawlerReport, ForgetsTheTruthOfATimeBefore) {
  CrawlerReport report(5);
  report.add_truth(position(100.0, 1, 1.0));
  report.add_truth(position(1.0, 1, 1.0));
  report.add_position(position(100.0, 1, 1.0));
  EXPECT_EQ(report.section("").figures.count("crawler_coverage95_percent"), 0U);
}

}  // namespace
}  // namespace pipescout::summary
