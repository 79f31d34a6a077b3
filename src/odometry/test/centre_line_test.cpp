// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry/centre_line.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace pipescout::odometry {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

SurveyedPoint point(double x, double y, double z, std::optional<double> chainage = {}) {
  return {.position = {.coordinates = {x, y, z}, .standard_deviation = 0.1}, .chainage = chainage};
}

TEST(CentreLine, LaysChainagesAlongItsLength) {
  const CentreLine line(MapFrame::kLocal, {point(0, 0, 0), point(30, 40, 0), point(30, 40, 10)},
                        {.wander = 0.0});
  EXPECT_DOUBLE_EQ(line.length(), 60.0);
  const auto middle = line.at(25.0, 0.3);
  ASSERT_TRUE(middle);
  EXPECT_DOUBLE_EQ(middle->coordinates[0], 15.0);
  EXPECT_DOUBLE_EQ(middle->coordinates[1], 20.0);
  EXPECT_NEAR(middle->standard_deviation, std::sqrt(0.5 * 0.01 + 0.09), 1e-12);
  EXPECT_DOUBLE_EQ(line.at(55.0, 0.1)->coordinates[2], 5.0);
  EXPECT_FALSE(line.at(-0.1, 0.1));
  EXPECT_FALSE(line.at(60.1, 0.1));
  EXPECT_FALSE(line.at(kNaN, 0.1));
}

TEST(CentreLine, KnownChainagesHoldItInPlace) {
  // The odometer has 10 % more than the survey between the two known points.
  const CentreLine line(
      MapFrame::kLocal,
      {point(0, 0, 0), point(100, 0, 0, 500.0), point(200, 0, 0, 610.0), point(300, 0, 0)},
      {.wander = 0.0, .chainage_noise = 0.02});
  EXPECT_DOUBLE_EQ(line.at(555.0, 9.0)->coordinates[0], 150.0);
  EXPECT_DOUBLE_EQ(line.at(490.0, 9.0)->coordinates[0], 90.0);
  EXPECT_DOUBLE_EQ(line.at(620.0, 9.0)->coordinates[0], 210.0);
  EXPECT_NEAR(line.at(500.0, 9.0)->standard_deviation, 0.1, 1e-12);
  EXPECT_LT(line.at(555.0, 9.0)->standard_deviation, 0.2);
  EXPECT_GT(line.at(490.0, 9.0)->standard_deviation, 8.0);
}

TEST(CentreLine, MeasuresOnTheEllipsoid) {
  // A degree of latitude at the equator and at 60 degrees, of longitude at 60 degrees (WGS 84).
  const auto distance = [](std::array<double, 3> a, std::array<double, 3> b) {
    return map_distance(MapFrame::kGeodetic, a, b);
  };
  EXPECT_NEAR(distance({-0.05, 0, 0}, {0.05, 0, 0}), 11057.43, 0.1);
  EXPECT_NEAR(distance({59.95, 5, 0}, {60.05, 5, 0}), 11141.2, 0.2);
  EXPECT_NEAR(distance({60, 5, 0}, {60, 5.1, 0}), 5580.02, 0.1);
  EXPECT_NEAR(distance({60, 179.95, 0}, {60, -179.95, 0}), 5580.02, 0.1);
  EXPECT_NEAR(distance({60, 5, 0}, {60, 5, 7}), 7.0, 1e-8);
  const auto over = map_between(MapFrame::kGeodetic, {0, 179.9, 0}, {0, -179.7, 0}, 0.75);
  EXPECT_NEAR(over[1], -179.8, 1e-9);
}

TEST(CentreLine, RefusesWhatIsNoLine) {
  const auto refused = [](MapFrame frame, std::vector<SurveyedPoint> points, const char* what) {
    try {
      const CentreLine line(frame, std::move(points));
      ADD_FAILURE() << what << " was accepted";
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(what));
    }
  };
  refused(MapFrame::kLocal, {point(0, 0, 0)}, "points: 1");
  refused(MapFrame::kNone, {point(0, 0, 0), point(1, 0, 0)}, "frame: 0");
  refused(MapFrame::kLocal, {point(0, 0, 0), point(0, 0, 0)}, "points[1]");
  refused(MapFrame::kLocal, {point(0, kNaN, 0), point(1, 0, 0)}, "coordinates: nan");
  refused(MapFrame::kGeodetic, {point(91, 0, 0), point(1, 0, 0)}, "latitude: 91");
  refused(MapFrame::kGeodetic, {point(1, 181, 0), point(1, 0, 0)}, "longitude: 181");
  refused(MapFrame::kLocal, {point(0, 0, 0, 5.0), point(1, 0, 0, 5.0)}, "points[1].chainage: 5");
}

}  // namespace
}  // namespace pipescout::odometry
