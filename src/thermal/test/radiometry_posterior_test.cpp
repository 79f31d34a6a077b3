// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal/radiometry_posterior.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "camera_helpers.hpp"
#include "pipescout/statistics/draw.hpp"

namespace pipescout::thermal {
namespace {

constexpr ParameterDeviations kVague{.calibration = 0,
                                     .emissivity = 0.02,
                                     .reflected_temperature = 6,
                                     .distance = 1.7,
                                     .atmospheric_temperature = 6};

RadiometryPosterior collectors(const ParameterDeviations& deviations) {
  return {test::sc660(), ibarguren2013_object(), deviations, collector_temperatures()};
}

/// What a black body with the counts of this object shows.
double apparent(const ObjectParameters& object, double temperature) {
  const CameraConstants camera = test::sc660();
  return camera.planck.temperature(Radiometry(camera, object).counts(temperature));
}

TEST(RadiometryPosterior, IsWhatIsToldWhereThatIsSure) {
  RadiometryPosterior posterior = collectors({.calibration = 0,
                                              .emissivity = 0,
                                              .reflected_temperature = 0,
                                              .distance = 0,
                                              .atmospheric_temperature = 0,
                                              .relative_humidity = 0,
                                              .window_temperature = 0});
  const double tube = apparent(ibarguren2013_object(), 150);
  const double leak = apparent(ibarguren2013_object(), 225);
  posterior.observe(tube);
  EXPECT_NEAR(posterior.pipe_temperature().mean, 150, 1e-6);
  EXPECT_NEAR(posterior.difference(leak, tube).low, 75, 1e-6);
  EXPECT_NEAR(posterior.difference(leak, tube).high, 75, 1e-6);
  EXPECT_FALSE(posterior.contradicted());
}

TEST(RadiometryPosterior, IntervalsHoldTheTruthWhereWhatIsToldIsWrong) {
  statistics::Draw draw(7, 1);
  int covered = 0;
  constexpr int kTrials = 300;
  for (int i = 0; i < kTrials; ++i) {
    ObjectParameters truth = ibarguren2013_object();
    truth.emissivity = 0.02 * std::pow(5, draw.uniform(0, 1));
    truth.reflected_temperature += draw.uniform(-10, 10);
    truth.distance *= draw.uniform(0.7, 1.3);
    const double sound = draw.uniform(130, 180);
    const double rise = draw.uniform(75, 120);
    const double tube = apparent(truth, sound);
    RadiometryPosterior posterior = collectors(kVague);
    posterior.observe(tube);
    const TemperatureInterval delta = posterior.difference(apparent(truth, sound + rise), tube);
    covered += delta.low <= rise && rise <= delta.high ? 1 : 0;
    EXPECT_LT(delta.low, delta.mean);
    EXPECT_GT(delta.low, 0);
  }
  EXPECT_GE(covered, 0.9 * kTrials);
  EXPECT_LE(covered, 0.99 * kTrials);
}

TEST(RadiometryPosterior, ThePipeNarrowsWhatMayBe) {
  RadiometryPosterior posterior = collectors(kVague);
  const double before = posterior.temperature(12).high - posterior.temperature(12).low;
  posterior.observe(12);
  EXPECT_LT(posterior.temperature(12).high - posterior.temperature(12).low, 0.7 * before);
  EXPECT_GT(posterior.pipe_temperature().low, 80);
}

TEST(RadiometryPosterior, SaysThatWhatIsToldIsImpossible) {
  RadiometryPosterior posterior = collectors(kVague);
  posterior.observe(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(posterior.images(), 0U);
  EXPECT_TRUE(std::isnan(posterior.pipe_temperature().mean));
  posterior.observe(-60);  // far below what the pipe reflects
  EXPECT_TRUE(posterior.contradicted());
}

TEST(RadiometryPosterior, RefusesARangeThatIsNone) {
  EXPECT_THROW(
      RadiometryPosterior(test::sc660(), ibarguren2013_object(), {}, {.least = 200, .most = 100}),
      std::invalid_argument);
  EXPECT_THROW(RadiometryPosterior(test::sc660(), ibarguren2013_object(), {.emissivity = -1}, {}),
               std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::thermal
