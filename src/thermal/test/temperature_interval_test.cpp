// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal/temperature_interval.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "camera_helpers.hpp"

namespace pipescout::thermal {
namespace {

constexpr ParameterDeviations kNothingUncertain{.calibration = 0,
                                                .emissivity = 0,
                                                .reflected_temperature = 0,
                                                .distance = 0,
                                                .atmospheric_temperature = 0,
                                                .relative_humidity = 0,
                                                .window_temperature = 0};

const ObjectParameters kPipe{.emissivity = 0.8,
                             .reflected_temperature = 10,
                             .distance = 10,
                             .atmospheric_temperature = 15,
                             .relative_humidity = 0.4,
                             .window_temperature = 20,
                             .window_transmission = 0.9};

TEST(TemperatureInterval, IsAPointWhereAllIsKnown) {
  const Radiometry radiometry(test::sc660(), kPipe);
  const TemperatureInterval interval =
      temperature_interval(radiometry, radiometry.counts(150), kNothingUncertain);
  EXPECT_NEAR(interval.mean, 150, 1e-8);
  EXPECT_DOUBLE_EQ(interval.deviation, 0);
  EXPECT_DOUBLE_EQ(interval.low, interval.mean);
  EXPECT_DOUBLE_EQ(interval.high, interval.mean);
}

TEST(TemperatureInterval, AddsSquares) {
  const Radiometry radiometry(test::sc660(), kPipe);
  ParameterDeviations both = kNothingUncertain;
  both.calibration = 3;
  both.counts = 4 * radiometry.slope(150);
  EXPECT_NEAR(temperature_interval(radiometry, radiometry.counts(150), both).deviation, 5, 1e-6);
}

TEST(TemperatureInterval, HoldsTheTruthAsOftenAsItSays) {
  // The camera is told wrong parameters, drawn as the deviations say.
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  ParameterDeviations d;
  d.counts = 5;
  d.window_transmission = 0.01;
  int held = 0;
  constexpr int kDraws = 4000;
  for (int i = 0; i < kDraws; ++i) {
    ObjectParameters told = kPipe;
    told.emissivity += d.emissivity * normal(random);
    told.reflected_temperature += d.reflected_temperature * normal(random);
    told.distance += d.distance * normal(random);
    told.atmospheric_temperature += d.atmospheric_temperature * normal(random);
    told.relative_humidity += d.relative_humidity * normal(random);
    told.window_temperature += d.window_temperature * normal(random);
    told.window_transmission += d.window_transmission * normal(random);
    told.relative_humidity = std::abs(told.relative_humidity);
    const double counts =
        Radiometry(test::sc660(), kPipe).counts(150 + d.calibration * normal(random)) +
        d.counts * normal(random);
    const TemperatureInterval interval =
        temperature_interval(Radiometry(test::sc660(), told), counts, d);
    held += interval.low <= 150 && 150 <= interval.high ? 1 : 0;
  }
  // 0.95 +- 4 of its own standard deviations.
  EXPECT_NEAR(held / double{kDraws}, 0.95, 0.014);
}

TEST(DifferenceInterval, WhatIsSharedCancels) {
  const Radiometry radiometry(test::sc660(), kPipe);
  const double counts = radiometry.counts(200);
  const double base = radiometry.counts(140);
  ParameterDeviations d;
  const TemperatureInterval difference = difference_interval(radiometry, counts, base, d);
  EXPECT_NEAR(difference.mean, 60, 1e-8);
  EXPECT_LT(difference.deviation, temperature_interval(radiometry, counts, d).deviation);
  EXPECT_NEAR(difference_interval(radiometry, counts, counts, d).deviation, 0, 1e-12);
  d.counts = 10;
  EXPECT_NEAR(difference_interval(radiometry, counts, counts, d).deviation,
              std::sqrt(2.0) * 10 / radiometry.slope(200), 1e-6);
}

TEST(TemperatureInterval, NoTemperatureNoInterval) {
  const Radiometry radiometry(test::sc660(), ibarguren2013_object());
  const TemperatureInterval interval = temperature_interval(radiometry, 0, {});
  EXPECT_TRUE(std::isnan(interval.mean));
  EXPECT_TRUE(std::isnan(interval.low));
  EXPECT_TRUE(std::isnan(interval.high));
}

TEST(TemperatureInterval, FirstOrderIsFiniteAtTheLens) {
  const Radiometry radiometry(test::sc660(), {.distance = 0, .relative_humidity = 0});
  EXPECT_TRUE(std::isfinite(temperature_interval(radiometry, 20000, {}).deviation));
}

TEST(ParameterDeviations, NamesWhatIsOutOfRange) {
  const Radiometry radiometry(test::sc660(), {});
  EXPECT_THAT(
      [&] { (void)temperature_interval(radiometry, 20000, {.counts = -1}); },
      ::testing::ThrowsMessage<std::invalid_argument>("deviations.counts: -1 is outside [0, inf)"));
  EXPECT_THROW(
      (void)difference_interval(radiometry, 20000, 19000,
                                {.window_transmission = std::numeric_limits<double>::quiet_NaN()}),
      std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::thermal
