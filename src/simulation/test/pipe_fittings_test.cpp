// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/pipe_fittings.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "pipescout/simulation/crawler.hpp"

namespace pipescout::simulation {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

/// Where a wheel at a clock position touches the wall, 3-D: the frame is carried along the axis in
/// small steps (columns: forward, up, right), independently of `wall_distance`.
double length_on_the_wall(const PipeFittings& fittings, const WallLine& line, double from,
                          double to) {
  constexpr double kStep = 1e-4;  // m
  Matrix3d frame = Matrix3d::Identity();
  Vector3d axis = Vector3d::Zero();
  const auto contact = [&](double s) {
    const double angle = line.angle + line.turn_per_metre * s;
    return Vector3d(axis + fittings.radius * frame * Vector3d(0, std::cos(angle), std::sin(angle)));
  };
  double length = 0.0;
  Vector3d last = contact(0.0);
  const int steps = static_cast<int>(std::lround(to / kStep));
  for (int i = 0; i < steps; ++i) {
    const double s = (i + 0.5) * kStep;
    double turn = 0.0;
    Vector3d about = Vector3d::UnitX();
    for (const PipeBend& bend : fittings.bends) {
      if (s > bend.begin && s < bend.end()) {
        turn = kStep / bend.radius;
        // From forward to where the centre of the arc is.
        about = Vector3d::UnitX().cross(
            Vector3d(0, std::cos(bend.direction), std::sin(bend.direction)));
      }
    }
    const Matrix3d half = AngleAxisd(0.5 * turn, about).toRotationMatrix();
    axis += kStep * (frame * half).col(0);
    frame = frame * half * half;
    const Vector3d now = contact((i + 1) * kStep);
    length += s > from ? (now - last).norm() : 0.0;
    last = now;
  }
  return length;
}

TEST(PipeFittings, AWheelRollsAsFarAsItsLineOnTheWallIsLong) {
  for (const double diameters : {1.5, 3.0, 5.0}) {
    PipeFittings fittings{.radius = 0.5};
    fittings.bends.push_back(
        {.begin = 1.0, .radius = 2.0 * diameters * 0.5, .angle = pi / 2, .direction = 0.7});
    fittings.bends.push_back({.begin = fittings.bends[0].end() + 0.5,
                              .radius = 2.0,
                              .angle = pi / 4,
                              .direction = -2.0});
    for (const double angle : {0.0, 2.1, 4.2}) {
      const double end = fittings.bends[1].end() - 0.2;  // within the second
      const WallLine line{.angle = angle};
      EXPECT_NEAR(wall_distance(fittings, line, 0.5, end),
                  length_on_the_wall(fittings, line, 0.5, end), 2e-4)
          << diameters << ' ' << angle;
    }
  }
}

TEST(PipeFittings, ARollingCrawlersWheelsGoAlongHelices) {
  PipeFittings fittings{.radius = 0.15};
  fittings.bends.push_back({.begin = 0.3, .radius = 0.6, .angle = pi / 2, .direction = 1.0});
  const WallLine line{.angle = 0.4, .turn_per_metre = 0.05};
  EXPECT_NEAR(wall_distance(fittings, line, 0.0, 2.0), length_on_the_wall(fittings, line, 0.0, 2.0),
              4e-4);
}

TEST(PipeFittings, TheMeanOfThreeWheelsIsThatOfTheAxis) {
  PipeFittings fittings{.radius = 0.5};
  fittings.bends.push_back({.begin = 0.0, .radius = 1.5, .angle = pi / 2, .direction = 0.3});
  double sum = 0.0;
  double shortest = 1e9;
  for (const int wheel : {0, 1, 2}) {
    const double way = wall_distance(fittings, {.angle = 0.1 + 2.0 * pi / 3.0 * wheel}, -1.0, 5.0);
    sum += way / 3.0;
    shortest = std::min(shortest, way);
  }
  EXPECT_NEAR(sum, 6.0, 1e-12);
  EXPECT_LT(shortest, 5.4);
}

TEST(PipeFittings, AWheelOverATeeStandsStill) {
  PipeFittings fittings{.radius = 0.5};
  fittings.tees.push_back({.position = 3.0, .radius = 0.2, .direction = pi});
  EXPECT_NEAR(wall_distance(fittings, {.angle = pi}, 0.0, 6.0), 5.6, 1e-12);
  EXPECT_NEAR(wall_distance(fittings, {.angle = pi + std::asin(0.3)}, 0.0, 6.0),
              6.0 - 2.0 * std::sqrt(0.04 - 0.0225), 1e-12);
  EXPECT_EQ(wall_distance(fittings, {.angle = 0.0}, 0.0, 6.0), 6.0);
  EXPECT_NEAR(wall_distance(fittings, {.angle = pi}, 2.9, 3.0), 0.0, 1e-12);
}

TEST(PipeFittings, GiveThePitchOfARise) {
  PipeFittings fittings;
  fittings.rises.push_back({.begin = 2.0, .length = 3.0, .pitch = 1.5});
  EXPECT_FALSE(pitch_on_rise(fittings, 1.9));
  EXPECT_EQ(pitch_on_rise(fittings, 4.0), 1.5);
  EXPECT_FALSE(pitch_on_rise(fittings, 5.1));
}

TEST(PipeFittings, AreRefusedWhereNoPipeIsLikeThat) {
  const auto refused = [](const PipeFittings& fittings, const std::string& text) {
    try {
      fittings.validate();
    } catch (const std::invalid_argument& error) {
      return std::string(error.what()).find(text) != std::string::npos;
    }
    return false;
  };
  EXPECT_TRUE(refused({.radius = 0.0}, "radius"));
  EXPECT_TRUE(refused({.bends = {{.radius = 0.4, .angle = 1.0}}}, "bends[0].radius"));
  EXPECT_TRUE(refused({.bends = {{.radius = 1.0, .angle = 1.0}, {.begin = 0.5, .angle = 1.0}}},
                      "bends[1].begin"));
  EXPECT_TRUE(refused({.tees = {{.radius = 0.6}}}, "tees[0].radius"));
  EXPECT_TRUE(refused({.rises = {{.length = 1.0, .pitch = 2.0}}}, "rises[0].pitch"));
}

/// 12 m forward, 4 m back.
Crawler crawler_through(const PipeFittings& fittings, double ahead) {
  const Motion motion({{.speed = 0.5, .duration = 24.0}, {.speed = -0.5, .duration = 8.0}}, 1e3);
  const JointedPipe pipe({.joints = 5, .bend_share = 0.0, .slope_share = 0.0}, 1);
  return Crawler(pipe, motion,
                 {.wheels = {{.resolution = 1e-9, .clock = 0.5, .ahead = ahead}},
                  .fittings = fittings,
                  .roll = 0.2,
                  .roll_per_metre = 0.03},
                 1, {});
}

TEST(PipeFittings, ACrawlersWheelGoesItsWayForwardAndBack) {
  PipeFittings fittings{.radius = 0.5};
  fittings.bends.push_back({.begin = 6.0, .radius = 1.5, .angle = pi / 2, .direction = 1.0});
  constexpr double kAhead = 0.25;
  Crawler crawler = crawler_through(fittings, kAhead);
  const WallLine line{.angle = 0.7 - 0.03 * kAhead, .turn_per_metre = 0.03};
  while (const auto sample = crawler.next()) {
    const double expected = wall_distance(fittings, line, kAhead, sample->distance + kAhead);
    EXPECT_NEAR(sample->value, expected, 1e-6) << sample->time;
  }
}

}  // namespace
}  // namespace pipescout::simulation
