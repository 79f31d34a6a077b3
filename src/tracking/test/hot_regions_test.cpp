// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking/hot_regions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace pipescout::tracking {
namespace {

constexpr ImageSize kImage{.width = 160, .height = 120};
constexpr float kHot = 250;

/// Cold, but for the pixels that are in the shape.
std::vector<float> picture(const std::function<bool(double x, double y)>& is_in) {
  std::vector<float> celsius;
  for (int y = 0; y < kImage.height; ++y) {
    for (int x = 0; x < kImage.width; ++x) {
      celsius.push_back(is_in(x, y) ? kHot : 10);
    }
  }
  return celsius;
}

std::vector<float> disc(double u, double v, double radius) {
  return picture([=](double x, double y) { return std::hypot(x - u, y - v) < radius; });
}

std::vector<float> rectangle(const VesselShape::State& shape) {
  const double c = std::cos(shape[VesselShape::kAngle]);
  const double s = std::sin(shape[VesselShape::kAngle]);
  return picture([=](double x, double y) {
    const double dx = x - shape[VesselShape::kX];
    const double dy = y - shape[VesselShape::kY];
    return std::abs(c * dx + s * dy) < shape[VesselShape::kLength] / 2 &&
           std::abs(c * dy - s * dx) < shape[VesselShape::kWidth] / 2;
  });
}

RC_GTEST_PROP(HotRegions, AValveIsACircleOfTheSameArea, ()) {
  const double radius = *rc::gen::inRange(60, 300) / 10.0;
  const double u = *rc::gen::inRange(400, 1200) / 10.0;
  const double v = *rc::gen::inRange(400, 800) / 10.0;
  HotRegionFinder finder({});
  RC_ASSERT(finder.find(disc(u, v, radius), kImage).size() == 1U);
  const auto valves = finder.valves();
  RC_ASSERT(valves.size() == 1U);
  RC_ASSERT((valves[0] - ValveShape::Region(u, v, radius)).norm() < 0.7);
}

RC_GTEST_PROP(HotRegions, AVesselIsARectangleOfTheSameMoments, ()) {
  VesselShape::State shape;
  shape << *rc::gen::inRange(600, 1000) / 10.0, *rc::gen::inRange(500, 700) / 10.0,
      *rc::gen::inRange(400, 600) / 10.0, *rc::gen::inRange(150, 300) / 10.0,
      *rc::gen::inRange(-150, 150) / 100.0;
  HotRegionFinder finder({});
  finder.find(rectangle(shape), kImage);
  const auto vessels = finder.vessels();
  RC_ASSERT(vessels.size() == 1U);
  RC_ASSERT((vessels[0].head<4>() - shape.head<4>()).cwiseAbs().maxCoeff() < 1.2);
  RC_ASSERT(std::abs(std::remainder(vessels[0][VesselShape::kAngle] - shape[VesselShape::kAngle],
                                    std::numbers::pi)) < 0.05);
}

TEST(HotRegions, ALongOneIsNoValveAndADiscNoVessel) {
  HotRegionFinder finder({.least_fill = 0.8});
  finder.find(rectangle({80, 60, 60, 20, 0.4}), kImage);
  EXPECT_TRUE(finder.valves().empty());
  EXPECT_EQ(finder.vessels().size(), 1U);
  finder.find(picture([](double x, double y) {
                return std::abs(std::hypot(x - 80, y - 60) - 30) < 4;  // a ring
              }),
              kImage);
  EXPECT_TRUE(finder.valves().empty());
  EXPECT_TRUE(finder.vessels().empty());
}

TEST(HotRegions, OneThatTheBorderCutsIsNotTaken) {
  HotRegionFinder finder({});
  for (const auto& [u, v] : {std::pair{5, 60}, {155, 60}, {80, 3}, {80, 117}}) {
    EXPECT_TRUE(finder.find(disc(u, v, 10), kImage).empty()) << u << ' ' << v;
  }
}

TEST(HotRegions, SmallAndMissingOnesAreIgnored) {
  HotRegionFinder finder({.least_pixels = 30});
  auto celsius = disc(80, 60, 20);
  celsius[10 * 160 + 20] = kHot;  // a dead pixel
  celsius[60 * 160 + 80] = std::numeric_limits<float>::quiet_NaN();
  const auto& regions = finder.find(celsius, kImage);
  ASSERT_EQ(regions.size(), 1U);
  EXPECT_NEAR(regions[0].middle.x(), 80, 0.1);
  EXPECT_TRUE(finder.find({}, {.width = 0, .height = 0}).empty());
}

TEST(HotRegions, WhatIsWrongIsNamed) {
  using ::testing::HasSubstr;
  using ::testing::ThrowsMessage;
  EXPECT_THAT([] { HotRegionFinder({.least_pixels = 1}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("least_pixels: 1 is outside")));
  EXPECT_THAT([] { HotRegionFinder({.threshold = NAN}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("threshold")));
  EXPECT_THAT([] { HotRegionFinder({.least_fill = 2}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("least_fill")));
  EXPECT_THAT([] { HotRegionFinder({.most_regions = 0}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("most_regions")));
  HotRegionFinder finder({});
  const std::vector<float> few(10);
  EXPECT_THAT(
      [&] { finder.find(few, kImage); },
      ThrowsMessage<std::invalid_argument>(HasSubstr("celsius: 10 temperatures: must be 19200")));
}

}  // namespace
}  // namespace pipescout::tracking
