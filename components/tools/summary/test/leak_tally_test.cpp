// SPDX-License-Identifier: Apache-2.0
#include "tables/leak_tally.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pipescout::summary {
namespace {

using pipescout_msgs::msg::LeakDetections;
using pipescout_msgs::msg::LeakEvent;
using pipescout_msgs::msg::LeakFinding;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

LeakFinding finding(std::uint64_t id, double x, const char* state = "raised",
                    double deviation = 0.1) {
  LeakFinding result;
  result.id = id;
  result.state = state;
  result.severity = "minor";
  result.position_known = true;
  result.position.x = x;
  for (const std::size_t variance : {0U, 4U, 8U}) {
    result.position_covariance[variance] = deviation * deviation;
  }
  return result;
}

LeakEvent event(const LeakFinding& finding) {
  LeakEvent result;
  result.finding = finding;
  return result;
}

TEST(LeakTally, CountsPictures) {
  LeakTally tally;
  LeakDetections detections;
  tally.add(detections);
  detections.pipes.resize(1);
  tally.add(detections);
  detections.leaks.resize(2);
  tally.add(detections);
  detections = {};
  detections.fault = "saturated";
  tally.add(detections);
  const auto figures = tally.section("robot.").figures;
  EXPECT_EQ(figures.at("robot.leak_pictures"), 4);
  EXPECT_EQ(figures.at("robot.leak_pictures_with_pipe"), 2);
  EXPECT_EQ(figures.at("robot.leak_pictures_with_leak"), 1);
  EXPECT_EQ(figures.at("robot.leak_pictures_failed"), 1);
  EXPECT_EQ(figures.count("robot.leaks_found_percent"), 0U) << "there is no truth";
}

TEST(LeakTally, AFindingCountsAsItWasLastTold) {
  LeakTally tally;
  tally.add(event(finding(3, 10)));
  tally.add(event(finding(4, 20)));
  tally.add(event(finding(3, 10, "cleared")));
  const MissionSection section = tally.section("");
  EXPECT_EQ(section.figures.at("leaks_raised"), 1);
  ASSERT_EQ(section.rows.size(), 2U);
  EXPECT_EQ(section.rows[0][1], MissionCell("cleared"));
  EXPECT_EQ(section.rows[1][3], MissionCell(20.0));
}

TEST(LeakTally, JudgesFindingsByTheTruth) {
  LeakTally tally;
  tally.add_truth(finding(1, 10));
  tally.add_truth(finding(2, 20));
  tally.add_truth(finding(3, 50));
  tally.add(event(finding(7, 10.1)));            // right, within its ellipsoid
  tally.add(event(finding(8, 20.5)));            // right, beyond it
  tally.add(event(finding(9, 20.6)));            // the same again: false
  tally.add(event(finding(10, 35)));             // false
  tally.add(event(finding(11, 50, "cleared")));  // is no longer said
  const MissionSection section = tally.section("");
  EXPECT_NEAR(section.figures.at("leaks_found_percent"), 66.667, 1e-3);
  EXPECT_EQ(section.figures.at("leaks_false"), 2);
  EXPECT_NEAR(section.figures.at("leak_position_worst_m"), 0.5, 1e-12);
  EXPECT_EQ(section.figures.at("leak_in_ellipsoid_percent"), 50);
  EXPECT_THAT(section.notes, ElementsAre(HasSubstr("Not found: the true leak 3")));
}

TEST(LeakTally, AFindingWithoutAPlaceIsNotTheTrueOne) {
  LeakTally tally;
  tally.add_truth(finding(1, 0));
  LeakFinding nowhere = finding(5, 0);
  nowhere.position_known = false;
  tally.add(event(nowhere));
  const MissionSection section = tally.section("");
  EXPECT_EQ(section.figures.at("leaks_found_percent"), 0);
  EXPECT_EQ(section.figures.at("leaks_false"), 1);
  EXPECT_EQ(section.rows[0][3], MissionCell());
}

}  // namespace
}  // namespace pipescout::summary
