// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation_study/sensor_loss.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "pipescout/estimation_study/run_score.hpp"

namespace pipescout::estimation_study {
namespace {

VehicleRun made_up() {
  VehicleRun run;
  for (int i = 0; i < 10'000; ++i) {
    const double time = 0.01 * i;
    run.events.push_back({.arrival = time, .reading = estimation::ImuReading{.time = time}});
    run.events.push_back({.arrival = time, .reading = estimation::OdometerReading{.time = time}});
    run.truth.push_back({.time = time});
  }
  return run;
}

std::ptrdiff_t count(const VehicleRun& run, Sensor sensor) {
  return std::ranges::count_if(
      run.events, [&](const Event& event) { return sensor_of(event.reading) == sensor; });
}

TEST(SensorLoss, LosesItsShareOneByOneOrInBursts) {
  const VehicleRun run = made_up();
  for (const double share : {0.01, 0.1, 0.3}) {
    const auto single = with_loss(run, {.sensor = Sensor::kImu, .share = share}, 0, 1);
    EXPECT_NEAR(static_cast<double>(count(single, Sensor::kImu)), 1e4 * (1 - share), 200);
    EXPECT_EQ(count(single, Sensor::kOdometer), 10'000);
    EXPECT_LT(longest_gap(single, Sensor::kImu), 0.15);
    const auto bursts =
        with_loss(run, {.sensor = Sensor::kImu, .share = share, .longest_burst = 2}, 0, 1);
    EXPECT_NEAR(static_cast<double>(count(bursts, Sensor::kImu)), 1e4 * (1 - share),
                2500 * std::sqrt(share));
    EXPECT_LE(longest_gap(bursts, Sensor::kImu), 2.02);
    if (share >= 0.1) {
      EXPECT_GT(longest_gap(bursts, Sensor::kImu), 0.5);
    }
  }
}

TEST(SensorLoss, SparesTheBeginningAndDelaysTheRest) {
  const auto lost =
      with_loss(made_up(), {.sensor = Sensor::kOdometer, .share = 0.3, .lag = 0.5}, 20, 1);
  double newest = 0;
  for (const Event& event : lost.events) {
    EXPECT_GE(event.arrival, newest);
    newest = event.arrival;
    const double time = time_of(event.reading);
    const bool late = sensor_of(event.reading) == Sensor::kOdometer && time >= 20;
    EXPECT_NEAR(event.arrival - time, late ? 0.5 : 0, 1e-9);
  }
  EXPECT_EQ(std::ranges::count_if(lost.events,
                                  [](const Event& event) {
                                    return sensor_of(event.reading) == Sensor::kOdometer &&
                                           time_of(event.reading) < 20;
                                  }),
            2000);
}

TEST(SensorLoss, RefusesWhatIsNoLoss) {
  EXPECT_THROW((void)with_loss({}, {.share = 1}, 0, 1), std::invalid_argument);
  EXPECT_THROW((void)with_loss({}, {.lag = -1}, 0, 1), std::invalid_argument);
}

TEST(SensorLoss, SensorsThatLoseAndLagAreStillFollowed) {
  const RunOptions options{.duration = 80};
  const VehicleRun whole = ground_robot_run(options, 1);
  const auto parameters = estimator_parameters(whole, options);
  for (const Sensor sensor : {Sensor::kImu, Sensor::kOdometer, Sensor::kGps}) {
    const VehicleRun run =
        with_loss(whole, {.sensor = sensor, .share = 0.3, .longest_burst = 2, .lag = 0.5}, 10, 1);
    const RunScore score = score_run(run, options, parameters);
    EXPECT_LT(score.position_rmse(), 0.1);
    EXPECT_GT(score.position_coverage(), 0.85);
    for (std::size_t i = 0; i < kSensors; ++i) {
      EXPECT_LE(score.refusals[i].longest, longest_gap(run, static_cast<Sensor>(i)) + 0.01);
    }
  }
}

/// After a gap of the IMU the attitude is uncertain by some degrees. What the wheels then say of
/// the velocity must turn it, and is no slip.
TEST(SensorLoss, AfterAGapOfTheImuTheWheelsOfACrawlerAreBelieved) {
  const RunOptions options{.duration = 100};
  const VehicleRun whole = crawler_run(options, 1);
  const auto parameters = estimator_parameters(whole, options);
  const VehicleRun run =
      with_loss(whole, {.sensor = Sensor::kImu, .share = 0.1, .longest_burst = 2}, 20, 1);
  const RunScore score = score_run(run, options, parameters);
  EXPECT_LT(score.position_rmse(), 1.5 * score_run(whole, options, parameters).position_rmse());
  EXPECT_LT(score.largest_position_error(), 0.1);
}

}  // namespace
}  // namespace pipescout::estimation_study
