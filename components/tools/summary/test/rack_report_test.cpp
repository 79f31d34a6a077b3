// SPDX-License-Identifier: Apache-2.0
#include "tables/rack_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

namespace pipescout::summary {
namespace {

using geometry::SE3;
using geometry::SO3;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180.0;

Time at(double seconds) {
  return Time{} + from_seconds(seconds);
}

SE3 place(double x, double y, double z, double yaw = 0.0) {
  return {SO3::about_z(yaw) * SO3::about_x(std::numbers::pi), {x, y, z}};
}

RackReport::Pose pose(double time, const SE3& T_rack_camera) {
  return {.stamp = at(time),
          .T_rack_camera = T_rack_camera,
          .standard_deviation = geometry::Vector6d::Constant(0.004)};
}

TEST(RackReport, ComparesPosesWithTheTruthBetweenItsStamps) {
  RackReport report;
  report.add_truth(at(1.0), place(0.0, 0.0, 3.0, 0.0));
  report.add_truth(at(1.1), place(1.0, 2.0, 3.0, 0.2));
  report.add_pose(pose(1.05, place(0.503, 1.0, 2.988, 0.1 + 1.0 * kDegree)));
  const auto section = report.section("");
  EXPECT_NEAR(section.figures.at("rack_across_median_m"), 0.003, 1e-9);
  EXPECT_NEAR(section.figures.at("rack_along_median_m"), 0.0, 1e-9);
  EXPECT_NEAR(section.figures.at("rack_up_median_m"), 0.012, 1e-9);
  EXPECT_NEAR(section.figures.at("rack_position_p95_m"), std::hypot(0.003, 0.012), 1e-9);
  EXPECT_NEAR(section.figures.at("rack_orientation_median_deg"), 1.0, 1e-9);
  ASSERT_EQ(section.rows.size(), 8U);
  EXPECT_EQ(section.rows[1].back(), MissionCell(100.0)) << "3 mm are within 1.96 * 4 mm";
  EXPECT_EQ(section.rows[3].back(), MissionCell(0.0)) << "12 mm are not";
  EXPECT_EQ(section.rows[0].back(), MissionCell(std::monostate{}));
  EXPECT_EQ(section.rows[1][5], MissionCell(0.004));
}

TEST(RackReport, WaitsForATruthThatComesLater) {
  RackReport report;
  report.add_pose(pose(1.0, place(0.001, 0.0, 3.0)));
  report.add_pose(pose(1.1, place(0.002, 0.0, 3.0)));
  EXPECT_EQ(report.section("").figures.count("rack_position_median_m"), 0U);
  report.add_truth(at(1.0), place(0.0, 0.0, 3.0));
  EXPECT_THAT(report.section("").notes, Contains(HasSubstr("Errors of 1 poses")));
  report.add_truth(at(1.1), place(0.0, 0.0, 3.0));
  EXPECT_THAT(report.section("").notes, Contains(HasSubstr("Errors of 2 poses")));
  EXPECT_NEAR(report.section("").figures.at("rack_position_p95_m"), 0.002, 1e-9);
}

TEST(RackReport, DoesNotGuessATruth) {
  RackReport report;
  report.add_truth(at(1.0), place(0.0, 0.0, 3.0));
  report.add_truth(at(9.0), place(9.0, 0.0, 3.0));
  report.add_pose(pose(5.0, place(5.0, 0.0, 3.0)));
  report.add_pose(pose(0.5, place(5.0, 0.0, 3.0)));
  EXPECT_EQ(report.section("").figures.count("rack_position_median_m"), 0U);
  EXPECT_THAT(report.section("").notes,
              Contains(HasSubstr("No ground truth is available at the times")));
}

TEST(RackReport, ForgetsTheTruthOfATimeBefore) {
  RackReport report;
  report.add_truth(at(100.0), place(0.0, 0.0, 3.0));
  report.add_truth(at(1.0), place(0.0, 0.0, 3.0));
  report.add_pose(pose(100.0, place(0.0, 0.0, 3.0)));
  EXPECT_EQ(report.section("").figures.count("rack_position_median_m"), 0U);
}

TEST(RackReport, CountsLossesAndHowLongTheyLast) {
  RackReport report;
  report.add_state(at(0.0), false, 0);
  report.add_state(at(1.0), true, 0);
  report.add_state(at(2.0), false, 1);
  report.add_state(at(3.0), false, 1);
  report.add_state(at(3.5), true, 1);
  report.add_state(at(9.0), true, 1);   // no images in between is no loss
  report.add_state(at(10.0), true, 0);  // the localizer was started again
  report.add_state(at(11.0), false, 1);
  const auto section = report.section("robot_1.");
  EXPECT_EQ(section.figures.at("robot_1.rack_losses"), 2.0);
  EXPECT_EQ(section.figures.at("robot_1.rack_longest_loss_s"), 2.5);
  EXPECT_EQ(section.figures.at("robot_1.rack_tracked_percent"), 50.0);
  EXPECT_EQ(section.figures.at("robot_1.rack_images"), 8.0);
  EXPECT_THAT(section.notes, Contains(HasSubstr("lost 2 times")));
  report.add_state(at(14.0), false, 1);
  EXPECT_EQ(report.section("").figures.at("rack_longest_loss_s"), 4.0) << "up to the last image";
}

TEST(RackReport, AFlightThatNeverTrackedHasNoLongestLossAndNoTable) {
  RackReport report;
  report.add_state(at(0.0), false, 1);
  report.add_state(at(9.0), false, 1);
  const auto section = report.section("");
  EXPECT_EQ(section.figures.count("rack_longest_loss_s"), 0U);
  EXPECT_EQ(section.figures.at("rack_tracked_percent"), 0.0);
  EXPECT_TRUE(section.columns.empty());
  EXPECT_THAT(section.notes, Contains(HasSubstr("lost 1 time.")));
}

TEST(RackReport, WayPoints) {
  RackReport report;
  EXPECT_EQ(report.section("").figures.count("rack_way_points"), 0U);
  report.set_way_points(3, 4, "2 reached, 1 missed");
  EXPECT_EQ(report.section("").figures.at("rack_way_points"), 4.0);
  EXPECT_EQ(report.section("").figures.at("rack_way_points_done"), 3.0);
  EXPECT_THAT(report.section("").notes, Contains(HasSubstr("2 reached, 1 missed")));
}

TEST(RackReport, StaysSmall) {
  RackReport report;
  for (int k = 0; k < 20000; ++k) {
    report.add_pose(pose(k, place(0.0, 0.0, 3.0)));
  }
  report.add_truth(at(18000.0), place(0.0, 0.0, 3.0));
  EXPECT_EQ(report.section("").figures.count("rack_position_median_m"), 0U)
      << "only the last poses wait";
  report.add_truth(at(19999.0), place(0.0, 0.0, 3.0));
  EXPECT_THAT(report.section("").notes, Contains(HasSubstr("Errors of 1 poses")));
}

}  // namespace
}  // namespace pipescout::summary
