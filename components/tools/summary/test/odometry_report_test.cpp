// SPDX-License-Identifier: Apache-2.0
#include "tables/odometry_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <limits>
#include <vector>

namespace pipescout::summary {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Time at(int second) {
  return Time(std::chrono::seconds(second));
}

OdometryReport::Fused fused_at(int second, double distance) {
  return {.stamp = at(second),
          .has_consensus = true,
          .distance = distance,
          .standard_deviation = 0.01,
          .in_fusion_set = {true, true}};
}

OdometryReport::Options two_odometers() {
  return {.odometers = {"left", "right"}, .reference = {}, .reference_name = "paper"};
}

TEST(OdometryReport, PutsFusedBesideReadings) {
  OdometryReport report(two_odometers());
  EXPECT_EQ(report.add_reading(at(1), {5.45, 5.34}), 1U);
  EXPECT_EQ(report.add_fused(fused_at(1, 5.50994)), 1U);
  const MissionSection section = report.section("");
  EXPECT_THAT(section.columns, ElementsAre("reading", "left [m]", "right [m]", "support set",
                                           "fused [m]", "standard deviation [m]"));
  ASSERT_EQ(section.rows.size(), 1U);
  EXPECT_THAT(section.rows[0],
              ElementsAre(MissionCell(std::int64_t{1}), MissionCell(5.45), MissionCell(5.34),
                          MissionCell(std::string("1 2")), MissionCell(5.5099), MissionCell(0.01)));
  EXPECT_EQ(section.figures.at("odometry_readings"), 1.0);
  EXPECT_EQ(section.figures.at("odometry_fused"), 1.0);
}

/// Reading 10 of Wang and others (2008), Table 1.
TEST(OdometryReport, ReadingsAreShownAsTheyWereFused) {
  OdometryReport report({.odometers = {"front", "left", "right"},
                         .offsets = std::vector<double>{0.18, 0.155, -0.165},
                         .reference = {},
                         .reference_name = ""});
  (void)report.add_reading(at(1), {5.45, 5.34, 5.69});
  OdometryReport::Fused fused = fused_at(1, 5.51);
  fused.in_fusion_set = {false, true, true};
  (void)report.add_fused(fused);
  const MissionSection section = report.section("");
  EXPECT_THAT(section.columns,
              ElementsAre("reading", "front + 0.18 [m]", "left + 0.155 [m]", "right - 0.165 [m]",
                          "support set", "fused [m]", "standard deviation [m]"));
  EXPECT_THAT(section.rows[0],
              ElementsAre(MissionCell(std::int64_t{1}), MissionCell(5.63), MissionCell(5.495),
                          MissionCell(5.525), MissionCell(std::string("2 3")), MissionCell(5.51),
                          MissionCell(0.01)));
  EXPECT_THAT(section.notes,
              ElementsAre(HasSubstr("with the offsets 0.18, 0.155, -0.165 m added")));
}

TEST(OdometryReport, OffsetsThatAreNotKnownAreSaidWhereTheyShow) {
  OdometryReport unknown(two_odometers());
  (void)unknown.add_reading(at(1), {5.45, 5.34});
  (void)unknown.add_fused(fused_at(1, 5.55));
  EXPECT_THAT(unknown.section("").notes,
              ElementsAre(HasSubstr("In 1 of 1 rows the fused distance is not between the readings "
                                    "that were fused: offsets were added")));
  OdometryReport::Options none = two_odometers();
  none.offsets = {0.0, 0.0};
  OdometryReport changed(none);
  (void)changed.add_reading(at(1), {5.45, 5.34});
  (void)changed.add_fused(fused_at(1, 5.55));
  EXPECT_THAT(changed.section("").notes, ElementsAre(HasSubstr("were changed during the run")));
  OdometryReport agreeing(none);
  (void)agreeing.add_reading(at(1), {5.45, 5.34});
  (void)agreeing.add_fused(fused_at(1, 5.4));
  EXPECT_THAT(agreeing.section("").notes, ::testing::IsEmpty());
}

TEST(OdometryReport, OrderOfArrivalDoesNotMatter) {
  rc::check([] {
    // What arrives: readings 0..n-1 in order, and their fused distances whenever.
    const int count = *rc::gen::inRange(1, 20);
    std::vector<int> events;
    for (int i = 0; i < count; ++i) {
      events.push_back(i);
      events.push_back(i + count);
    }
    const auto keys =
        *rc::gen::container<std::vector<int>>(events.size(), rc::gen::arbitrary<int>());
    std::vector<std::size_t> order(events.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
      order[i] = i;
    }
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return keys[a] < keys[b]; });
    OdometryReport report(two_odometers());
    int next_reading = 0;
    for (const std::size_t i : order) {
      if (events[i] < count) {
        (void)report.add_reading(at(next_reading), {1.0 * next_reading, 0.0});
        ++next_reading;
      } else {
        (void)report.add_fused(fused_at(events[i] - count, 1.0 * (events[i] - count)));
      }
    }
    RC_ASSERT(report.pairs() == static_cast<std::uint64_t>(count));
    const MissionSection section = report.section("");
    for (const auto& row : section.rows) {
      RC_ASSERT(row[1] == row[4]);
    }
  });
}

TEST(OdometryReport, ReadingsOfOneStampArePairedInOrder) {
  OdometryReport report(two_odometers());
  (void)report.add_reading(at(1), {1.0, 1.0});
  (void)report.add_reading(at(1), {2.0, 2.0});
  EXPECT_EQ(report.add_fused(fused_at(1, 1.0)), 1U);
  EXPECT_EQ(report.add_fused(fused_at(1, 2.0)), 2U);
  EXPECT_EQ(report.add_fused(fused_at(1, 3.0)), std::nullopt);
  EXPECT_EQ(report.pairs(), 2U);
  EXPECT_EQ(report.fused(), 3U);
}

TEST(OdometryReport, WhatIsMissingHasNoValue) {
  OdometryReport report(two_odometers());
  (void)report.add_reading(at(1), {kNan, 5.34});
  (void)report.add_reading(at(2), {5.4, 5.34});
  OdometryReport::Fused none = fused_at(2, kNan);
  none.has_consensus = false;
  none.standard_deviation = kNan;
  none.in_fusion_set = {false, false};
  (void)report.add_fused(none);
  const MissionSection section = report.section("");
  EXPECT_THAT(section.rows[0],
              ElementsAre(MissionCell(std::int64_t{1}), MissionCell(), MissionCell(5.34),
                          MissionCell(), MissionCell(), MissionCell()));
  EXPECT_THAT(section.rows[1],
              ElementsAre(MissionCell(std::int64_t{2}), MissionCell(5.4), MissionCell(5.34),
                          MissionCell(std::string()), MissionCell(), MissionCell()));
  EXPECT_EQ(section.figures.at("odometry_without_consensus"), 1.0);
}

TEST(OdometryReport, ComparesWithTheReference) {
  OdometryReport::Options options = two_odometers();
  options.reference = {5.51, kNan, 5.51};
  OdometryReport report(options);
  for (int i = 1; i <= 4; ++i) {
    (void)report.add_reading(at(i), {5.4, 5.4});
    (void)report.add_fused(fused_at(i, i == 3 ? 5.5 : 5.512));
  }
  const MissionSection section = report.section("robot_1.");
  ASSERT_EQ(section.columns.size(), 8U);
  EXPECT_EQ(section.columns[6], "paper [m]");
  EXPECT_EQ(section.columns[7], "difference [m]");
  EXPECT_EQ(section.rows[0][6], MissionCell(5.51));
  EXPECT_EQ(section.rows[0][7], MissionCell(0.002));
  EXPECT_EQ(section.rows[1][7], MissionCell());
  EXPECT_EQ(section.rows[3][6], MissionCell());
  EXPECT_NEAR(section.figures.at("robot_1.odometry_max_abs_difference_m"), 0.01, 1e-12);
  EXPECT_THAT(section.notes, Contains(HasSubstr("at reading 3")));
}

TEST(OdometryReport, KeepsAsManyRowsAsTheTableShows) {
  OdometryReport::Options options = two_odometers();
  options.maximum_rows = 3;
  OdometryReport report(options);
  for (int i = 1; i <= 10; ++i) {
    (void)report.add_reading(at(i), {5.4, 5.4});
    (void)report.add_fused(fused_at(i, 5.5));
  }
  const MissionSection section = report.section("");
  EXPECT_EQ(section.rows.size(), 3U);
  EXPECT_EQ(section.figures.at("odometry_readings"), 10.0);
  EXPECT_EQ(report.pairs(), 10U);
  EXPECT_THAT(section.notes, Contains("The table shows the first 3 of 10 readings."));
}

TEST(OdometryReport, ForgetsTheOldestOfWhatNobodyPairs) {
  OdometryReport report(two_odometers());
  for (int i = 0; i < 5000; ++i) {
    (void)report.add_reading(at(i), {5.4, 5.4});
  }
  EXPECT_EQ(report.add_fused(fused_at(0, 5.5)), std::nullopt);
  EXPECT_EQ(report.add_fused(fused_at(4999, 5.5)), 5000U);
}

TEST(FusionSet, CountsFromOne) {
  EXPECT_EQ(format_fusion_set({false, true, true}), "2 3");
  EXPECT_EQ(format_fusion_set({false, false}), "");
}

}  // namespace
}  // namespace pipescout::summary
