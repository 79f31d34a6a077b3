// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "pipescout/driving/coverage_map.hpp"
#include "pipescout/driving/inspection_speed.hpp"

namespace pipescout::navigation {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(InspectionSpeed, ADoubledExposureHalvesTheSpeed) {
  InspectionParameters parameters{.exposure = 0.01, .focal_length = 500, .largest_blur = 1};
  EXPECT_NEAR(InspectionSpeed(parameters).blur_limit(2), 0.4, 1e-12);
  parameters.exposure *= 2;
  InspectionSpeed slow(parameters);
  const auto decision =
      slow.decide({.time = 1, .arc_length = 3, .tracked = true, .confidence = 1, .range = 2});
  EXPECT_NEAR(decision.speed, 0.2 * parameters.speed_share, 1e-12);
  EXPECT_EQ(decision.reason, InspectionReason::kMotionBlur);
}

TEST(InspectionSpeed, ALostTrackSlowsStopsGoesBackAndIsGivenUp) {
  const InspectionParameters parameters{.exposure = 1e-3};
  InspectionSpeed speed(parameters);
  double time = 0;
  speed.decide({.time = time, .arc_length = 10, .tracked = true, .confidence = 1, .range = 2});
  const auto lost = [&](double after) {
    return speed.decide({.time = time + after, .arc_length = 10.5});
  };
  EXPECT_EQ(lost(0.1).speed, parameters.slow_speed);
  EXPECT_EQ(lost(0.8).speed, 0);
  const auto back = lost(2);
  ASSERT_TRUE(back.go_back_to.has_value());
  EXPECT_NEAR(*back.go_back_to, 9, 1e-12);
  lost(2.1);
  EXPECT_TRUE(lost(4).go_back_to.has_value());
  lost(4.1);
  const auto given_up = lost(6);
  EXPECT_FALSE(given_up.go_back_to.has_value());
  EXPECT_EQ(given_up.reason, InspectionReason::kPipeGivenUp);
  EXPECT_GT(given_up.speed, 0);
}

TEST(InspectionSpeed, ADoubtfulFindingIsPassedAgainOnceFromNearer) {
  InspectionSpeed speed({.exposure = 1e-3});
  const auto at = [&](double arc) {
    return speed.decide(
        {.time = arc, .arc_length = arc, .tracked = true, .confidence = 1, .range = 2});
  };
  at(5);
  speed.doubtful_finding(5);
  EXPECT_FALSE(at(5.5).go_back_to.has_value());
  EXPECT_NEAR(at(6.1).go_back_to.value_or(0), 4, 1e-12);
  EXPECT_TRUE(at(5).nearer);
  EXPECT_EQ(at(5).reason, InspectionReason::kDoubtfulFinding);
  EXPECT_FALSE(at(6.1).nearer);
  speed.doubtful_finding(5);
  EXPECT_FALSE(at(7).go_back_to.has_value());
}

TEST(InspectionSpeed, LowConfidenceAndNaN) {
  InspectionSpeed speed({.exposure = 1e-3});
  const auto with = [&](double confidence) {
    return speed.decide(
        {.time = 1, .arc_length = 1, .tracked = true, .confidence = confidence, .range = kNan});
  };
  EXPECT_EQ(with(0.5).reason, InspectionReason::kLowConfidence);
  EXPECT_LT(with(0.4).speed, with(0.6).speed);
  EXPECT_EQ(with(kNan).reason, InspectionReason::kTrackLost);
  EXPECT_THROW(InspectionSpeed({.exposure = 0}), std::invalid_argument);
}

TEST(CoverageMap, GrowsKeepsTheSharpestAndNamesGaps) {
  CoverageMap map(0.5, 1);
  EXPECT_TRUE(map.add({.pipe = 3, .from = 0, .to = 4, .time = 1, .temperature = 200, .blur = 2}));
  EXPECT_EQ(map.sharp_percent(3, 0, 4), 0);
  EXPECT_TRUE(
      map.add({.pipe = 3, .from = 0.9, .to = 3, .time = 2, .temperature = 210, .blur = 0.5}));
  EXPECT_NEAR(map.sharp_percent(3, 0, 4), 50, 1e-9);
  const auto gaps = map.gaps(3, 0, 4);
  ASSERT_EQ(gaps.size(), 2U);
  EXPECT_NEAR(gaps[0].to, 1, 1e-12);
  EXPECT_NEAR(gaps[1].from, 3, 1e-12);
  EXPECT_EQ(map.pipes().at(3)[2].temperature, 210);
  EXPECT_EQ(map.pipes().at(3)[7].temperature, 200);
  EXPECT_EQ(map.sharp_percent(4, 0, 4), 0);
  EXPECT_TRUE(map.add({.pipe = 4, .from = 0, .to = 4, .time = 1, .temperature = kNan}));
}

TEST(CoverageMap, RefusesWhatIsWrong) {
  CoverageMap map(0.5, 1);
  EXPECT_FALSE(map.add({.from = kNan, .to = 1}));
  EXPECT_FALSE(map.add({.from = 2, .to = 1}));
  EXPECT_FALSE(map.add({.from = 0, .to = 1e9}));
  EXPECT_TRUE(map.pipes().empty());
  EXPECT_THROW(CoverageMap(0, 1), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::navigation
