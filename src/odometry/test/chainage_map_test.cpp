// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry/chainage_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

namespace pipescout::odometry {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(ChainageMap, IsExactAtItsKnotsAndLinearBetween) {
  const ChainageMap map({{0.0, 100.0, 0.03}, {10.0, 111.0, 0.04}, {20.0, 121.0, 0.05}});
  EXPECT_DOUBLE_EQ(map.map(0.0).chainage, 100.0);
  EXPECT_DOUBLE_EQ(map.map(10.0).chainage, 111.0);
  EXPECT_DOUBLE_EQ(map.map(20.0).chainage, 121.0);
  EXPECT_DOUBLE_EQ(map.map(5.0).chainage, 105.5);
  EXPECT_NEAR(map.map(10.0).standard_deviation, 0.04, 1e-12);
  EXPECT_NEAR(map.map(20.0).standard_deviation, 0.05, 1e-12);
  EXPECT_TRUE(map.map(20.0).between_welds);
}

TEST(ChainageMap, UncertaintyBetweenKnotsIsThatOfTheFormula) {
  // Joints of 10, 10, 10, the middle one 12 long in `to`: D = 2.
  const ChainageMap map({{0.0, 0.0, 0.1}, {10.0, 10.0, 0.1}, {20.0, 22.0, 0.2}, {30.0, 32.0, 0.2}},
                        {.length_noise = 0.05});
  EXPECT_NEAR(map.slip(1), 2.0, 1e-12);
  const double t = 0.25;
  const double expected = 0.75 * 0.75 * 0.01 + t * t * 0.04 + (0.0025 * 10.0 + 4.0) * t * (1 - t);
  EXPECT_NEAR(map.map(12.5).standard_deviation, std::sqrt(expected), 1e-12);
}

TEST(ChainageMap, ContinuesBeyondTheEndsWithGrowingUncertainty) {
  const ChainageMap map({{0.0, 0.0, 0.1}, {10.0, 20.0, 0.1}},
                        {.length_noise = 0.0, .scale_sigma = 0.02});
  EXPECT_DOUBLE_EQ(map.map(15.0).chainage, 30.0);
  EXPECT_DOUBLE_EQ(map.map(-5.0).chainage, -10.0);
  EXPECT_NEAR(map.map(15.0).standard_deviation, std::hypot(0.1, 0.02 * 5.0), 1e-12);
  EXPECT_FALSE(map.map(15.0).between_welds);
  const ChainageMap single({{5.0, 7.0, 0.1}});
  EXPECT_DOUBLE_EQ(single.map(6.0).chainage, 8.0);
}

TEST(ChainageMap, InverseLeadsBack) {
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> step(1.0, 12.0);
  for (const double sign : {1.0, -1.0}) {
    std::vector<ChainageKnot> knots{{0.0, 50.0, 0.02}};
    for (int k = 0; k < 100; ++k) {
      knots.push_back(
          {knots.back().from + step(engine), knots.back().to + sign * step(engine), 0.02});
    }
    const ChainageMap map(knots);
    const ChainageMap inverse = map.inverse();
    double previous = map.map(-20.0).chainage;
    for (double x = -19.5; x < knots.back().from + 20.0; x += 0.5) {
      const double there = map.map(x).chainage;
      EXPECT_GT(sign * (there - previous), 0.0);
      EXPECT_NEAR(inverse.map(there).chainage, x, 1e-9);
      previous = there;
    }
  }
}

TEST(ChainageMap, GivesNoChainageForNone) {
  EXPECT_TRUE(std::isnan(ChainageMap().map(1.0).chainage));
  EXPECT_TRUE(std::isnan(ChainageMap({{0.0, 0.0, 0.0}}).map(kNaN).chainage));
}

TEST(ChainageMap, RefusesWhatIsNotMonotone) {
  const auto refused = [](std::vector<ChainageKnot> knots, const char* what,
                          ChainageMapParameters parameters = {}) {
    try {
      const ChainageMap map(std::move(knots), parameters);
      ADD_FAILURE() << what << " was accepted";
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(what));
    }
  };
  refused({{0.0, 0.0, 0.0}, {0.0, 1.0, 0.0}}, "knots[1].from");
  refused({{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}, "knots[1].to");
  refused({{0.0, 0.0, 0.0}, {1.0, 1.0, 0.0}, {2.0, 0.5, 0.0}}, "knots[2].to");
  refused({{0.0, 0.0, 0.0}, {1.0, -1.0, 0.0}, {2.0, 0.5, 0.0}}, "knots[2].to");
  refused({{kNaN, 0.0, 0.0}}, "knots[0]");
  refused({{0.0, 0.0, -1.0}}, "standard_deviation: -1");
  refused({}, "length_noise: nan", {.length_noise = kNaN});
  refused({}, "scale_sigma: -1", {.scale_sigma = -1.0});
}

}  // namespace
}  // namespace pipescout::odometry
