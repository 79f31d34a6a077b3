// SPDX-License-Identifier: Apache-2.0
// Wheels around the circumference of a pipe: in a bend each goes its own way.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "odometer_bench.hpp"
#include "pipescout/odometry/odometer_stream.hpp"

namespace pipescout::odometry {
namespace {

using std::numbers::pi;
using test::BenchWheel;
using test::OdometerBench;

constexpr double kSpeed = 0.3;   // m/s
constexpr double kRadius = 0.5;  // m, of the pipe
constexpr double kBegin = 10.0;  // m, of the bend
constexpr double kEnd = 30.0;    // m, of the drive

struct Bend {
  double radius = 3.0;  // m, of the axis
  double angle = pi / 2;
  double direction = 0.0;
};

/// m, that a wheel at a clock position has rolled where the axis is `distance` long.
double rolled(const Bend& bend, double clock, double distance) {
  const double length = std::clamp(distance - kBegin, 0.0, bend.radius * bend.angle);
  return distance - kRadius / bend.radius * length * std::cos(clock - bend.direction);
}

double clock_of(std::size_t wheel, std::size_t wheels) {
  return 2.0 * pi * static_cast<double>(wheel) / static_cast<double>(wheels);
}

OdometerStreamParameters wheels_around(std::size_t count, FusionRule rule) {
  auto parameters = test::fine_odometers(count);
  parameters.rule = rule;
  parameters.circumference.radius = kRadius;
  parameters.window_distance = 0.5;
  parameters.lookback_windows = 16;
  for (std::size_t i = 0; i < count; ++i) {
    parameters.odometers[i].clock = clock_of(i, count);
  }
  return parameters;
}

struct Slip {
  std::size_t wheel = 0;
  double begin = 0.0;
  double length = 0.0;
  double ratio = 0.0;
};

/// `in_bend`: speed within the bend, as a share of that elsewhere.
FusedStream drive(const OdometerStreamParameters& parameters, const Bend& bend,
                  const std::vector<Slip>& slips = {}, double in_bend = 1.0) {
  OdometerStream stream(parameters);
  std::vector<BenchWheel> wheels(parameters.odometers.size());
  for (std::size_t i = 0; i < wheels.size(); ++i) {
    wheels[i].model = [&, i](double, double distance) {
      double value = rolled(bend, parameters.odometers[i].clock, distance);
      for (const Slip& slip : slips) {
        value -= slip.wheel == i ? slip.ratio * std::clamp(distance - slip.begin, 0.0, slip.length)
                                 : 0.0;
      }
      return value;
    };
  }
  const double entered = kBegin / kSpeed;
  const double length = bend.radius * bend.angle;
  const double left = entered + length / (in_bend * kSpeed);
  const auto distance = [&](double time) {
    return kSpeed * (time - std::clamp(time - entered, 0.0, left - entered)) +
           in_bend * kSpeed * std::clamp(time - entered, 0.0, left - entered);
  };
  OdometerBench bench(stream, wheels, distance);
  bench.run_until(left + (kEnd - kBegin - length) / kSpeed);
  stream.flush();
  return stream.state();
}

TEST(PipeBends, TheConsensusDropsTheMinorityOfABend) {
  double largest = 0.0;
  for (const double direction : {0.3, 1.3, 2.3}) {
    const auto state = drive(wheels_around(3, FusionRule::kConsensus), {.direction = direction});
    largest = std::max(largest, std::abs(state.distance - kEnd));
  }
  EXPECT_GT(largest, 0.1);
}

TEST(PipeBends, WheelsAroundTheCircumferenceAreExactInABend) {
  for (const double radius : {1.5, 3.0, 5.0}) {
    for (const double direction : {0.5, 1.2, -0.6, 3.0}) {
      const auto state = drive(wheels_around(3, FusionRule::kCircumference),
                               {.radius = radius, .direction = direction});
      EXPECT_NEAR(state.distance, kEnd, 0.005) << radius << ' ' << direction;
      ASSERT_EQ(state.bends, 1U) << radius << ' ' << direction;
      EXPECT_NEAR(state.recent_bends[0].angle, pi / 2, 0.03);
      EXPECT_NEAR(std::remainder(state.recent_bends[0].direction - direction, 2.0 * pi), 0.0, 0.03);
      EXPECT_NEAR(state.recent_bends[0].middle, kBegin + 0.5 * radius * pi / 2, 0.25);
      EXPECT_NEAR(state.recent_bends[0].length, radius * pi / 2, 0.5);
      EXPECT_GT(state.recent_bends[0].probability, 0.99);
      EXPECT_LT(std::sqrt(state.variance), 0.03);
    }
  }
}

TEST(PipeBends, TheAverageIsExactInABendAndWrongInASlip) {
  const auto parameters = wheels_around(3, FusionRule::kAverage);
  EXPECT_NEAR(drive(parameters, {.direction = 0.4}).distance, kEnd, 0.005);
  const auto slipped =
      drive(parameters, {.angle = 0.0}, {{.wheel = 1, .begin = 5.0, .length = 3.0, .ratio = 0.3}});
  EXPECT_NEAR(slipped.distance, kEnd - 0.3, 0.01);
}

TEST(PipeBends, ASlipOnAStraightIsNoBend) {
  for (const double ratio : {0.05, 0.15, 0.3, 1.0}) {
    const auto state = drive(wheels_around(3, FusionRule::kCircumference), {.angle = 0.0},
                             {{.wheel = 2, .begin = 15.1, .length = 3.0, .ratio = ratio}});
    EXPECT_NEAR(state.distance, kEnd, 0.01) << ratio;
    EXPECT_EQ(state.bends, 0U) << ratio;
  }
}

TEST(PipeBends, ABendTowardsAWheelIsDecidedBySpeed) {
  const auto state =
      drive(wheels_around(3, FusionRule::kCircumference), {.direction = 2.0 * pi / 3.0});
  EXPECT_EQ(state.bends, 1U);
  EXPECT_LT(std::abs(state.distance - kEnd), 2.0 * std::sqrt(state.variance));
  EXPECT_NEAR(state.distance, kEnd, 0.02);
}

struct SlowBend {
  double radius;  // m
  double angle;
  double speed;  // share of that elsewhere
};

FusedStream drive_towards_a_wheel(const SlowBend& bend) {
  return drive(wheels_around(3, FusionRule::kCircumference),
               {.radius = bend.radius, .angle = bend.angle, .direction = 2.0 * pi / 3.0}, {},
               bend.speed);
}

/// Were it a slip of that wheel, the others would say that the crawler changes its speed where the
/// slip begins and ends.
TEST(PipeBends, ABendTowardsAWheelInWhichTheCrawlerSlowsIsFound) {
  for (const SlowBend& bend :
       {SlowBend{2.0, pi / 2, 0.95}, {3.0, pi / 4, 0.85}, {4.0, pi / 2, 0.9}}) {
    const auto state = drive_towards_a_wheel(bend);
    EXPECT_EQ(state.bends, 1U) << bend.radius;
    EXPECT_NEAR(state.distance, kEnd, 0.07) << bend.radius;
  }
}

/// The crawler slows by about what the other wheels go further in the bend: they say nothing.
TEST(PipeBends, ABendThatCannotBeToldFromASlipIsUncertain) {
  for (const SlowBend& bend :
       {SlowBend{2.0, pi / 2, 0.85}, {2.0, pi / 2, 0.8}, {3.0, pi / 2, 0.9}}) {
    const auto state = drive_towards_a_wheel(bend);
    EXPECT_LT(std::abs(state.distance - kEnd), 2.0 * std::sqrt(state.variance)) << bend.radius;
  }
}

/// What makes a wheel slip may slow the crawler.
TEST(PipeBends, ASlipInWhichTheCrawlerSlowsIsNoBend) {
  for (const double ratio : {0.1, 0.15, 0.25}) {
    // 3 m of a bend that is straight but for 1e-6 rad: where the crawler is slower.
    const Bend straight{.radius = 3e6, .angle = 1e-6};
    const auto state = drive(wheels_around(3, FusionRule::kCircumference), straight,
                             {{.wheel = 2, .begin = kBegin, .length = 3.0, .ratio = ratio}}, 0.8);
    EXPECT_EQ(state.bends, 0U) << ratio;
    EXPECT_NEAR(state.distance, kEnd, 0.05) << ratio;
  }
}

TEST(PipeBends, ASlipBesideABendIsToldApart) {
  const auto state = drive(wheels_around(3, FusionRule::kCircumference), {.direction = 0.5},
                           {{.wheel = 1, .begin = 4.2, .length = 3.0, .ratio = 0.2},
                            {.wheel = 2, .begin = 20.0, .length = 2.0, .ratio = 0.1}});
  EXPECT_NEAR(state.distance, kEnd, 0.02);
  EXPECT_EQ(state.bends, 1U);
}

TEST(PipeBends, FiveWheelsTellASlipInABend) {
  const auto state = drive(wheels_around(5, FusionRule::kCircumference), {.direction = 0.5},
                           {{.wheel = 1, .begin = 11.0, .length = 2.0, .ratio = 0.2}});
  EXPECT_NEAR(state.distance, kEnd, 0.02);
  EXPECT_EQ(state.bends, 1U);
}

TEST(PipeBends, ThreeWheelsTellASlipInABendThatTheyKnow) {
  const auto state = drive(wheels_around(3, FusionRule::kCircumference), {.direction = 0.5},
                           {{.wheel = 1, .begin = 11.6, .length = 1.5, .ratio = 0.2}});
  EXPECT_NEAR(state.distance, kEnd, 0.03);
  EXPECT_EQ(state.bends, 1U);
  EXPECT_NEAR(state.recent_bends[0].angle, pi / 2, 0.06);
}

/// Of a wheel on the outer side: the curvature changes, and no direction.
TEST(PipeBends, ASlipThatLooksLikeAnotherCurvatureIsTold) {
  constexpr double kLost = 0.15 * 2.0;  // m, of the wheel
  for (const double begin : {11.6, 12.2}) {
    const auto state = drive(wheels_around(3, FusionRule::kCircumference), {.direction = pi},
                             {{.wheel = 0, .begin = begin, .length = 2.0, .ratio = 0.15}});
    EXPECT_LT(std::abs(state.distance - kEnd), kLost / 6.0) << begin;
    EXPECT_LT(std::abs(state.distance - kEnd), 2.0 * std::sqrt(state.variance)) << begin;
  }
}

TEST(PipeBends, ASlipThatEndsInABendIsToldInRetrospect) {
  constexpr double kLost = 0.2 * 1.6;  // m, of the wheel
  const auto state = drive(wheels_around(3, FusionRule::kCircumference), {.direction = 0.5},
                           {{.wheel = 1, .begin = 10.2, .length = 1.6, .ratio = 0.2}});
  EXPECT_LT(std::abs(state.distance - kEnd), kLost / 6.0);
  EXPECT_LT(std::abs(state.distance - kEnd), 2.0 * std::sqrt(state.variance));
}

TEST(PipeBends, TheRollOfTheCrawlerIsAddedToTheDirection) {
  const auto parameters = wheels_around(3, FusionRule::kCircumference);
  const Bend bend{.direction = 0.5};
  OdometerStream stream(parameters);
  stream.set_roll(1.0);
  stream.set_roll(std::nan(""));
  std::vector<BenchWheel> wheels(3);
  for (std::size_t i = 0; i < 3; ++i) {
    wheels[i].model = [&, i](double, double distance) {
      return rolled(bend, parameters.odometers[i].clock, distance);
    };
  }
  OdometerBench bench(stream, wheels, [](double time) { return kSpeed * time; });
  bench.run_until(kEnd / kSpeed);
  EXPECT_NEAR(stream.state().recent_bends[0].direction, 1.5, 0.03);
}

TEST(PipeBends, WheelsThatCannotTellABendAreRefused) {
  const auto refusal = [](const OdometerStreamParameters& parameters) {
    try {
      parameters.validate();
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refusal(wheels_around(3, FusionRule::kCircumference)), "");
  EXPECT_THAT(refusal(wheels_around(2, FusionRule::kCircumference)),
              testing::HasSubstr("odometers"));
  auto parameters = wheels_around(3, FusionRule::kCircumference);
  parameters.odometers[1].clock = std::nan("");
  EXPECT_THAT(refusal(parameters), testing::HasSubstr("odometers[1].clock"));
  parameters.odometers[1].clock = 0.01;
  parameters.odometers[2].clock = 0.02;
  EXPECT_THAT(refusal(parameters), testing::HasSubstr("too near"));
  parameters = wheels_around(3, FusionRule::kCircumference);
  parameters.circumference.radius = 0.0;
  EXPECT_THAT(refusal(parameters), testing::HasSubstr("circumference.radius"));
  parameters = wheels_around(3, FusionRule::kCircumference);
  parameters.circumference.tightest_bend = 0.1;
  EXPECT_THAT(refusal(parameters), testing::HasSubstr("circumference.tightest_bend"));
  parameters = wheels_around(3, static_cast<FusionRule>(7));
  EXPECT_THAT(refusal(parameters), testing::HasSubstr("rule"));
}

}  // namespace
}  // namespace pipescout::odometry
