// SPDX-License-Identifier: Apache-2.0
// What is a weld and what is none.
#include "pipescout/odometry/weld_detector.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "weld_signal.hpp"

namespace pipescout::odometry {
namespace {

using test::Complex;
using test::Crawl;
using test::doublet;
using test::welds_at;
using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Pointwise;
using testing::SizeIs;

constexpr double kNoise = 0.05;  // 26 dB below the welds
constexpr double kClose = 0.003;

std::vector<double> every_twelve_metres(double length) {
  std::vector<double> welds;
  for (double at = 5.0; at < length; at += 12.07) {
    welds.push_back(at);
  }
  return welds;
}

TEST(WeldDetector, FindsEachWeldWhereItIs) {
  const auto welds = every_twelve_metres(500.0);
  WeldDetector detector({});
  Crawl crawl(detector, welds_at(welds), kNoise, 1);
  crawl.go_to(500.0);
  crawl.finish();
  EXPECT_THAT(crawl.distances(), Pointwise(DoubleNear(kClose), welds));
  EXPECT_EQ(detector.counts().welds, welds.size());
  for (const auto& event : crawl.events()) {
    EXPECT_GT(event.confidence, 0.5);
    EXPECT_LE(event.confidence, 1.0);
    EXPECT_GT(event.standard_deviation, 0.0005);
    EXPECT_LT(event.standard_deviation, kClose);
  }
}

TEST(WeldDetector, FindsThemAtAnySpeed) {
  const auto welds = every_twelve_metres(60.0);
  for (const double step : {0.0001, 0.0007, 0.0033, 0.0061}) {
    WeldDetector detector({});
    Crawl crawl(detector, welds_at(welds), kNoise, 2);
    crawl.go_to(60.0, step);
    crawl.finish();
    EXPECT_THAT(crawl.distances(), Pointwise(DoubleNear(kClose), welds)) << step;
  }
}

TEST(WeldDetector, FindsThemWhereTheSpeedChanges) {
  const auto welds = every_twelve_metres(200.0);
  WeldDetector detector({});
  Crawl crawl(detector, welds_at(welds), 0.2, 3);
  for (double at = 10.0; at <= 200.0; at += 10.0) {
    crawl.go_to(at, static_cast<int>(at / 10.0) % 2 == 0 ? 0.0002 : 0.004);
  }
  crawl.finish();
  EXPECT_THAT(crawl.distances(), Pointwise(DoubleNear(0.006), welds));
}

TEST(WeldDetector, FindsTheSameInTheOtherDirection) {
  const auto welds = every_twelve_metres(100.0);
  WeldDetector detector({});
  Crawl crawl(detector, welds_at(welds), kNoise, 4);
  crawl.sample(100.0);
  crawl.go_to(-3.0);
  crawl.finish();
  EXPECT_THAT(crawl.distances(),
              Pointwise(DoubleNear(kClose), std::vector<double>(welds.rbegin(), welds.rend())));
}

TEST(WeldDetector, TellsPeakWidthAndPhase) {
  for (const double width : {0.028, 0.033, 0.04, 0.047, 0.055}) {
    WeldDetector detector({});
    Crawl crawl(detector, welds_at({10.0}, width, std::polar(2.0, -1.1)), 0.01, 5);
    crawl.go_to(20.0);
    ASSERT_THAT(crawl.events(), SizeIs(1)) << width;
    EXPECT_NEAR(crawl.events()[0].amplitude, 2.0, 0.15) << width;
    EXPECT_NEAR(crawl.events()[0].width / width, 1.0, 0.1) << width;
    EXPECT_NEAR(crawl.events()[0].phase, -1.1, 0.02) << width;
    EXPECT_GT(crawl.events()[0].match, 0.9) << width;
    EXPECT_GT(crawl.events()[0].confidence, 0.9) << width;
  }
}

TEST(WeldDetector, ReportsAWeldOneDelayBehind) {
  WeldDetector detector({});
  Crawl crawl(detector, welds_at({10.0}), kNoise, 6);
  crawl.go_to(10.0 + detector.delay() - 0.02);
  EXPECT_THAT(crawl.events(), IsEmpty());
  crawl.go_to(10.0 + detector.delay() + 0.04);
  EXPECT_THAT(crawl.events(), SizeIs(1));
}

TEST(WeldDetector, DecidesTheEndOfARunWhenToldSo) {
  WeldDetector detector({});
  Crawl crawl(detector, welds_at({10.0}), kNoise, 7);
  crawl.go_to(10.3);
  EXPECT_THAT(crawl.events(), IsEmpty());
  crawl.finish();
  EXPECT_THAT(crawl.distances(), ElementsAre(DoubleNear(10.0, kClose)));
  crawl.go_to(20.0);
  crawl.finish();
  EXPECT_THAT(crawl.events(), SizeIs(1));
}

TEST(WeldDetector, MakesUpForTheWarmUp) {
  WeldDetector detector({.warm_up = 5.0});
  Crawl crawl(detector, welds_at({1.0, 4.0}), kNoise, 8);
  crawl.go_to(4.9);
  EXPECT_THAT(crawl.events(), IsEmpty());
  crawl.go_to(8.0);
  EXPECT_THAT(crawl.distances(), ElementsAre(DoubleNear(1.0, kClose), DoubleNear(4.0, kClose)));
}

/// One odd thing at 30 m, between two welds.
WeldDetectorCounts counts_with(const test::Signal& odd, const WeldDetectorParameters& parameters) {
  WeldDetector detector(parameters);
  const auto welds = welds_at({10.0, 50.0});
  Crawl crawl(
      detector, [&](double d) { return welds(d) + odd(d - 30.0); }, kNoise, 9);
  crawl.go_to(60.0);
  crawl.finish();
  EXPECT_THAT(crawl.distances(), ElementsAre(DoubleNear(10.0, kClose), DoubleNear(50.0, kClose)));
  return detector.counts();
}

TEST(WeldDetector, RefusesADent) {
  for (const double width : {0.09, 0.12, 0.2}) {
    const auto counts = counts_with([&](double d) { return doublet(d, 0.0, width, 3.0); }, {});
    EXPECT_GE(counts.too_wide, 1U) << width;
  }
  counts_with([](double d) { return doublet(d, 0.0, 0.5, 3.0); }, {});  // no peak at all
}

TEST(WeldDetector, RefusesANarrowPulse) {
  const auto counts = counts_with([](double d) { return doublet(d, 0.0, 0.009, 6.0); }, {});
  EXPECT_GE(counts.too_narrow, 1U);
}

TEST(WeldDetector, RefusesALoneBump) {
  for (const double deviation : {0.01, 0.015, 0.02}) {
    const auto counts = counts_with(
        [&](double d) { return Complex(2.0 * std::exp(-d * d / (2 * deviation * deviation))); },
        {});
    EXPECT_GE(counts.wrong_shape + counts.too_narrow + counts.too_wide + counts.crowded, 1U)
        << deviation;
  }
}

TEST(WeldDetector, RefusesASlowRiseAndAStep) {
  for (const double length : {0.0001, 0.05, 0.5, 3.0}) {
    counts_with([&](double d) { return Complex(2.0 * std::tanh(d / length), 1.0); }, {});
  }
}

TEST(WeldDetector, RefusesACrowd) {
  const auto crowd = [](double d) {
    Complex sum{};
    for (int i = 0; i < 8; ++i) {
      sum += doublet(d, 0.13 * i, 0.04, std::polar(1.0, 1.3 * i));
    }
    return sum;
  };
  EXPECT_GE(counts_with(crowd, {}).crowded, 1U);
}

TEST(WeldDetector, RefusesAnotherPhaseWhenToldWhich) {
  const auto weld = [](double d) { return doublet(d, 0.0, 0.04, Complex(0.0, 1.0)); };
  EXPECT_EQ(counts_with(weld, {.phase = 0.0, .phase_tolerance = 0.8}).wrong_phase, 1U);
  // Across the jump of the angle.
  WeldDetector detector({.phase = std::numbers::pi, .phase_tolerance = 0.5});
  Crawl crawl(detector, welds_at({10.0}, 0.04, std::polar(1.0, -3.0)), kNoise, 10);
  crawl.go_to(20.0);
  EXPECT_THAT(crawl.events(), SizeIs(1));
}

TEST(WeldDetector, UsesAllChannels) {
  const auto found = [](std::size_t channels) {
    const auto welds = every_twelve_metres(1000.0);
    const auto signal = welds_at(welds);
    WeldDetector detector({.channels = channels});
    std::mt19937_64 engine(11);
    std::normal_distribution<double> noise(0.0, 0.7);
    std::size_t count = 0;
    for (double d = 0.0; d < 1000.0; d += 0.002) {
      std::array<Impedance, 3> values;
      const Complex value = signal(d);
      for (auto& one : values) {
        one = {value.real() + noise(engine), value.imag() + noise(engine)};
      }
      count += detector.update(d, std::span(values).first(channels)).size();
    }
    return static_cast<double>(count) / static_cast<double>(welds.size());
  };
  EXPECT_LT(found(1), 0.9);
  EXPECT_GT(found(3), found(1) + 0.1);
}

TEST(WeldThreshold, KeepsItsFormula) {
  for (const std::size_t channels : {1U, 2U, 8U}) {
    for (const double rate : {0.001, 0.05, 10.0}) {
      const WeldDetectorParameters parameters{.channels = channels, .false_alarms_per_km = rate};
      const double threshold = weld_threshold(parameters);
      EXPECT_NEAR(weld_false_alarms_per_km(parameters, threshold) / rate, 1.0, 1e-6);
    }
  }
  // One filter, one channel, fine cells: two bells of deviation s, 2 a apart. White noise through
  // them has the correlation 2 R(x) - R(x - 2a) - R(x + 2a) with R = exp(-x^2 / 4s^2).
  const WeldDetectorParameters one{.cell = 0.0002, .smallest_width = 0.04, .largest_width = 0.04};
  const double a = 0.02;
  const double s = a / 1.4;
  const double far = std::exp(-a * a / (s * s));
  const double curvature = (2.0 - 2.0 * far * (1.0 - 2.0 * a * a / (s * s))) / (2.0 * s * s);
  const double rho = curvature / (2.0 - 2.0 * far);
  const double expected = 1000.0 * std::sqrt(rho * 12.0 / std::numbers::pi) * std::exp(-12.0);
  // The straight line that is taken out of the filter makes it a little steeper.
  EXPECT_NEAR(weld_false_alarms_per_km(one, 12.0) / expected, 1.05, 0.05);
}

TEST(WeldThreshold, BoundsTheFalseAlarmsOfNoise) {
  // Every peak counts, whatever its shape.
  const WeldDetectorParameters parameters{.width_tolerance = 3.0,
                                          .false_alarms_per_km = 20.0,
                                          .smallest_match = 0.0,
                                          .largest_asymmetry = 1.0,
                                          .largest_neighbour = 1.0,
                                          .crowd_distance = 0.0};
  WeldDetector detector(parameters);
  Crawl crawl(detector, welds_at({}), 1.0, 12);
  crawl.go_to(20000.0, 0.0035);
  const auto& counts = detector.counts();
  const auto peaks =
      static_cast<double>(counts.welds + counts.too_wide + counts.too_narrow + counts.wrong_shape);
  EXPECT_LT(peaks / 20.0, 20.0);  // a bound
  EXPECT_GT(peaks / 20.0, 4.0);   // and not a careless one
}

TEST(WeldThreshold, HoldsWhereTheNoiseChanges) {
  WeldDetector detector({.false_alarms_per_km = 1.0});
  Crawl crawl(detector, welds_at({}), 1.0, 13);
  for (int i = 1; i <= 200; ++i) {  // 10 m each, six-fold changes of the samples per metre
    crawl.go_to(10.0 * i, i % 2 == 0 ? 0.0006 : 0.0036);
  }
  EXPECT_LE(crawl.events().size(), 4U);
}

std::string refusal(const WeldDetectorParameters& parameters) {
  try {
    const WeldDetector detector(parameters);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(WeldDetectorParameters, RefuseWhatIsOutOfRange) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal({}), "accepted");
  EXPECT_EQ(refusal({.channels = 0}), "channels: 0 is outside [1, 8]");
  EXPECT_EQ(refusal({.channels = 9}), "channels: 9 is outside [1, 8]");
  EXPECT_THAT(refusal({.cell = 0.01}), HasSubstr("cell: 0.01 is outside"));
  EXPECT_THAT(refusal({.cell = 1e-7}), HasSubstr("cell: 1e-07 is outside"));
  EXPECT_THAT(refusal({.smallest_width = 0.0}), HasSubstr("smallest_width: 0"));
  EXPECT_THAT(refusal({.largest_width = 0.02}), HasSubstr("largest_width: 0.02"));
  EXPECT_THAT(refusal({.false_alarms_per_km = 0.0}), HasSubstr("false_alarms_per_km: 0"));
  EXPECT_THAT(refusal({.smallest_match = kNaN}), HasSubstr("smallest_match: nan"));
  EXPECT_THAT(refusal({.noise_floor = 0.0}), HasSubstr("noise_floor: 0"));
  EXPECT_THAT(refusal({.largest_step = 1000.0}), HasSubstr("largest_step: 1000"));
  EXPECT_THAT(refusal({.largest_jump = 0.1}), HasSubstr("largest_jump: 0.1"));
}

TEST(WeldDetector, RefusesAnotherNumberOfChannels) {
  WeldDetector detector({.channels = 2});
  const std::array<Impedance, 3> values{};
  EXPECT_THROW(detector.update(0.0, values), std::invalid_argument);
  EXPECT_THROW(detector.update(0.0, {}), std::invalid_argument);
  EXPECT_EQ(detector.counts().samples, 0U);
}

TEST(WeldDetector, CanBeMoved) {
  WeldDetector first({});
  Crawl before(first, welds_at({10.0}), kNoise, 14);
  before.go_to(9.0);
  WeldDetector detector = std::move(first);
  Crawl crawl(detector, welds_at({10.0}), kNoise, 15);
  crawl.sample(9.0);
  crawl.go_to(12.0);
  EXPECT_THAT(crawl.distances(), ElementsAre(DoubleNear(10.0, kClose)));
}

}  // namespace
}  // namespace pipescout::odometry
