// SPDX-License-Identifier: Apache-2.0
// Closed forms of the distance and its variance; how odometers of different kinds come together.
#include "pipescout/odometry/odometer_stream.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "odometer_bench.hpp"

namespace pipescout::odometry {
namespace {

using test::BenchWheel;
using test::fine_odometers;
using test::OdometerBench;

constexpr double kSpeed = 0.3;  // m/s

double at_speed(double time) {
  return kSpeed * time;
}

std::string refusal_of(const OdometerStreamParameters& parameters) {
  try {
    OdometerStream stream(parameters);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(OdometerStream, AgreeingOdometersGiveTheirDistance) {
  OdometerStream stream(fine_odometers(3));
  OdometerBench bench(stream, std::vector<BenchWheel>(3), at_speed);
  bench.run_until(100.0);
  const auto& state = stream.state();
  EXPECT_EQ(state.status, StreamStatus::kOk);
  EXPECT_NEAR(state.time, 100.0, 1e-6);
  EXPECT_NEAR(state.distance, 30.0, 1e-9);
  EXPECT_NEAR(state.speed, kSpeed, 1e-9);
  EXPECT_EQ(state.consensus.fusion_set.to_ulong(), 0b111U);
  EXPECT_EQ(state.windows_no_consensus, 0U);
}

TEST(OdometerStream, IndependentErrorsAddUpAsVariances) {
  auto parameters = fine_odometers(3);
  for (auto& odometer : parameters.odometers) {
    odometer.resolution = 1e-6;
  }
  OdometerStream stream(parameters);
  OdometerBench bench(stream, std::vector<BenchWheel>(3), at_speed);
  bench.run_until(100.0);
  EXPECT_NEAR(stream.state().variance, 0.003 * 0.003 * 30.0 / 3.0, 1e-9);
  EXPECT_DOUBLE_EQ(stream.state().variance, stream.state().random_variance);
}

TEST(OdometerStream, CountingIsPaidAtTheEndsOnly) {
  auto parameters = fine_odometers(2);
  for (auto& odometer : parameters.odometers) {
    odometer.resolution = 0.01;
    odometer.sigma_per_sqrt_metre = 1e-9;
  }
  OdometerStream stream(parameters);
  OdometerBench bench(stream, std::vector<BenchWheel>(2), at_speed);
  bench.run_until(1000.0);
  // Two odometers of weight 1/2, each with a first and a last reading.
  EXPECT_NEAR(stream.state().variance, 2.0 * 2.0 * 0.25 * 1e-4 / 12.0, 1e-10);
}

TEST(OdometerStream, ScaleErrorsGrowWithTheDistanceAndVanishOnTheWayBack) {
  auto parameters = fine_odometers(2);
  for (auto& odometer : parameters.odometers) {
    odometer.resolution = 1e-6;
    odometer.sigma_per_sqrt_metre = 1e-6;
    odometer.correction.covariance(0, 0) = 1e-4;
  }
  OdometerStream stream(parameters);
  OdometerBench bench(stream, std::vector<BenchWheel>(2),
                      [](double time) { return kSpeed * (time < 100.0 ? time : 200.0 - time); });
  bench.run_until(100.0);
  EXPECT_NEAR(std::sqrt(stream.state().variance), 0.01 * 30.0 / std::sqrt(2.0), 1e-3);
  bench.run_until(200.0);
  EXPECT_NEAR(stream.state().distance, 0.0, 1e-9);
  EXPECT_NEAR(stream.state().variance, 0.0, 1e-8);
}

TEST(OdometerStream, CommonErrorsAreNotAveragedAway) {
  auto parameters = fine_odometers(16);
  parameters.common_sigma_per_sqrt_metre = 0.01;
  parameters.common_scale_sigma = 0.005;
  OdometerStream stream(parameters);
  OdometerBench bench(stream, std::vector<BenchWheel>(16), at_speed);
  bench.run_until(100.0);
  const double expected = 1e-4 * 30.0 + 0.15 * 0.15 + 9e-6 * 30.0 / 16.0;
  EXPECT_NEAR(stream.state().variance, expected, 1e-6);
}

TEST(OdometerStream, KindsRatesStartsAndOffsetsMayDiffer) {
  auto parameters = fine_odometers(4);
  parameters.odometers[1].kind = OdometerKind::kIncrement;
  parameters.odometers[3].wrap = 4.096;
  OdometerStream stream(parameters);
  std::vector<BenchWheel> wheels(4);
  wheels[0] = {.model = [](double, double distance) { return distance - 700.0; }, .period = 0.013};
  wheels[1].model = [before = 0.0](double, double distance) mutable {
    return distance - std::exchange(before, distance);
  };
  wheels[2] = {
      .model = [](double, double distance) { return distance; }, .period = 0.17, .start = 0.37};
  wheels[3].model = [](double, double distance) { return std::fmod(distance, 4.096); };
  OdometerBench bench(stream, wheels, at_speed);
  bench.run_until(200.0);
  const auto& state = stream.state();
  EXPECT_EQ(state.status, StreamStatus::kOk);
  EXPECT_EQ(state.consensus.fusion_set.to_ulong(), 0b1111U);
  // The distance counts from the first tick at which all have a position, 0.4 s.
  EXPECT_NEAR(state.distance, kSpeed * (state.time - 0.4), 1e-6);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(state.odometers[i].gaps, 0U) << i;
    EXPECT_EQ(state.odometers[i].health, OdometerHealth::kOk) << i;
  }
}

TEST(OdometerStream, AnOdometerTooSlowForTheTicksStillTakesPart) {
  auto parameters = fine_odometers(3);
  parameters.maximum_gap = 5.0;
  parameters.silent_after = 3.0;
  OdometerStream stream(parameters);
  std::vector<BenchWheel> wheels(3);
  wheels[2].period = 1.7;  // the ticks wait for 0.5 s
  OdometerBench bench(stream, wheels, at_speed);
  bool fused = false;
  bench.observe = [&] { fused = fused || stream.state().consensus.fusion_set[2]; };
  bench.run_until(100.0);
  EXPECT_TRUE(fused);
  EXPECT_NEAR(stream.state().distance, kSpeed * stream.state().time, 1e-6);
}

// Four wheels of a vehicle: in a turn no majority travels the same way.
class TurningVehicle : public ::testing::Test {
 protected:
  static constexpr double kTrack = 0.8;  // m
  static constexpr double kSpeed = 0.5;  // m/s
  static constexpr double kRate = 0.25;  // rad/s, in the turns: 2 m of radius

  static OdometerStreamParameters parameters(double track) {
    OdometerStreamParameters result;
    result.odometers.resize(4);
    for (std::size_t i = 0; i < 4; ++i) {
      result.odometers[i].sigma_per_sqrt_metre = 0.004;
      result.odometers[i].lateral = (i % 2 == 0 ? 0.5 : -0.5) * track;
    }
    return result;
  }
  /// 10 s straight on, 10 s of a turn to the left, and so on; wheel 1 slips by `slip` in the turns.
  static void drive(OdometerStream& stream, bool with_rates, double slip = 0.0) {
    constexpr double kPeriod = 0.05;  // s
    double heading = 0.0;
    double slipped = 0.0;
    for (int k = 0; k <= 1200; ++k) {
      const double time = k * kPeriod;
      const bool turns = (k / 200) % 2 == 1;
      const double rate = turns ? kRate : 0.0;
      if (k > 0) {
        heading += rate * kPeriod;
        slipped += turns ? slip * kSpeed * kPeriod : 0.0;
      }
      if (with_rates) {
        stream.push_yaw_rate(time, rate);
      }
      for (std::size_t i = 0; i < 4; ++i) {
        const double aside = (i % 2 == 0 ? 0.5 : -0.5) * kTrack;
        stream.push({.odometer = i,
                     .time = time,
                     .value = kSpeed * time - aside * heading + (i == 1 ? slipped : 0.0)});
      }
    }
    stream.flush();
  }
};

TEST_F(TurningVehicle, WithoutTheTurnNoMajorityAgrees) {
  OdometerStream stream(parameters(0.0));
  drive(stream, true);
  EXPECT_GT(stream.state().windows_no_consensus, 5U);
}

TEST_F(TurningVehicle, TurnsAreTakenOutOfTheWheels) {
  OdometerStream stream(parameters(kTrack));
  drive(stream, true);
  EXPECT_EQ(stream.state().windows_no_consensus, 0U);
  EXPECT_NEAR(stream.state().distance, 30.0, 0.01);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(stream.state().odometers[i].unsupported, 0U) << i;
    EXPECT_EQ(stream.state().odometers[i].health, OdometerHealth::kOk) << i;
  }
}

TEST_F(TurningVehicle, AWheelThatSlipsInATurnIsLeftOut) {
  OdometerStream stream(parameters(kTrack));
  drive(stream, true, 0.3);
  EXPECT_EQ(stream.state().windows_no_consensus, 0U);
  EXPECT_NEAR(stream.state().distance, 30.0, 0.05);
  EXPECT_GT(stream.state().odometers[1].unsupported, 3U);
}

TEST_F(TurningVehicle, UnusableRatesAreIgnored) {
  OdometerStream sound(parameters(kTrack));
  drive(sound, false);
  OdometerStream stream(parameters(kTrack));
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  stream.push_yaw_rate(kNone, 1.0);
  stream.push_yaw_rate(0.0, kNone);
  stream.push_yaw_rate(std::numeric_limits<double>::infinity(), 1.0);
  drive(stream, false);
  EXPECT_EQ(stream.state().distance, sound.state().distance);
}

TEST(OdometerStream, ReversingGoesBackBySign) {
  OdometerStream stream(fine_odometers(3));
  OdometerBench bench(stream, std::vector<BenchWheel>(3),
                      [](double time) { return 5.0 * std::sin(0.05 * time); });
  bench.run_until(200.0);
  EXPECT_NEAR(stream.state().distance, 5.0 * std::sin(10.0), 1e-3);
  EXPECT_EQ(stream.state().status, StreamStatus::kOk);
}

TEST(OdometerStream, ACorrectionCountsFromWhenItIsSet) {
  OdometerStream stream(fine_odometers(2));
  OdometerBench bench(stream, std::vector<BenchWheel>(2), at_speed);
  bench.run_until(100.0);
  OdometerCorrection correction{.scale = 1.02};
  correction.covariance(0, 0) = 1e-6;
  stream.set_correction(0, correction);
  stream.set_correction(1, correction);
  EXPECT_NEAR(stream.state().distance, 30.0, 1e-6);
  bench.run_until(200.0);
  EXPECT_NEAR(stream.state().distance, 30.0 + 1.02 * 30.0, 1e-6);
  EXPECT_EQ(stream.state().odometers[0].correction.scale, 1.02);
  EXPECT_NEAR(stream.state().odometers[0].measured, 60.0, 1e-6);
  // 30 m since, each half: the errors of the two scales are independent.
  const double systematic = stream.state().variance - stream.state().random_variance;
  EXPECT_NEAR(systematic, 2.0 * 15.0 * 15.0 * 1e-6, 1e-6);
}

TEST(OdometerStream, SettingACorrectionAgainDoesNotMakeItsErrorSmaller) {
  OdometerStream stream(fine_odometers(2));
  OdometerBench bench(stream, std::vector<BenchWheel>(2), at_speed);
  OdometerCorrection correction;
  correction.covariance(0, 0) = 1e-6;
  for (int k = 1; k <= 10; ++k) {
    stream.set_correction(0, correction);
    stream.set_correction(1, correction);
    bench.run_until(10.0 * k);
  }
  const double systematic = stream.state().variance - stream.state().random_variance;
  EXPECT_NEAR(systematic, 2.0 * 15.0 * 15.0 * 1e-6, 1e-6);
}

TEST(OdometerStream, OffsetsAreAddedWhereASegmentEnds) {
  auto parameters = fine_odometers(2);
  parameters.odometers[0].correction.offset = 0.18;
  parameters.odometers[1].correction.offset = 0.14;
  parameters.odometers[0].correction.covariance(1, 1) = 4e-4;
  OdometerStream stream(parameters);
  OdometerBench bench(stream, std::vector<BenchWheel>(2), at_speed);
  bench.run_until(50.0);
  stream.end_segment();
  EXPECT_NEAR(stream.state().distance, 15.0 + 0.16, 1e-6);
  bench.run_until(100.0);
  stream.end_segment();
  EXPECT_NEAR(stream.state().distance, 30.0 + 0.32, 1e-6);
  // Twice half of an offset that is the same each time.
  EXPECT_NEAR(stream.state().variance - stream.state().random_variance, 4e-4, 1e-9);
  stream.end_segment();  // nothing travelled: nothing added
  EXPECT_NEAR(stream.state().distance, 30.0 + 0.32, 1e-6);
}

TEST(OdometerStream, TheSameSamplesGiveTheSameBits) {
  const auto run = [] {
    OdometerStream stream(fine_odometers(3));
    std::vector<BenchWheel> wheels(3);
    wheels[1].model = [](double time, double distance) { return distance + 0.01 * std::sin(time); };
    OdometerBench bench(stream, wheels, at_speed);
    bench.run_until(60.0);
    return stream.state();
  };
  const auto first = run();
  const auto second = run();
  EXPECT_EQ(first.distance, second.distance);
  EXPECT_EQ(first.variance, second.variance);
}

TEST(OdometerStream, FlushFusesWhatWaitsForLateOdometers) {
  OdometerStream stream(fine_odometers(2));
  for (int k = 0; k <= 10; ++k) {
    stream.push({.odometer = 0, .time = 0.1 * k, .value = 0.03 * k});
    if (k <= 7) {
      stream.push({.odometer = 1, .time = 0.1 * k, .value = 0.03 * k});
    }
  }
  EXPECT_NEAR(stream.state().time, 0.7, 1e-9);
  EXPECT_EQ(stream.flush(), 3U);
  EXPECT_NEAR(stream.state().time, 1.0, 1e-9);
  EXPECT_NEAR(stream.state().distance, 0.3, 1e-9);
  EXPECT_EQ(stream.flush(), 0U);
}

TEST(OdometerStreamParameters, RefuseWhatCannotWork) {
  EXPECT_EQ(refusal_of({}), "odometers: 0 of them is outside [2, 16]");
  EXPECT_EQ(refusal_of(fine_odometers(17)), "odometers: 17 of them is outside [2, 16]");
  const auto refusal = [](auto change) {
    auto parameters = fine_odometers(3);
    change(parameters);
    return refusal_of(parameters);
  };
  using Parameters = OdometerStreamParameters;
  EXPECT_EQ(refusal([](Parameters& p) { p.odometers[1].resolution = 0.0; }),
            "odometers[1].resolution: 0 is outside (0, inf)");
  EXPECT_EQ(refusal([](Parameters& p) { p.odometers[2].correction.scale = 3.0; }),
            "odometers[2].correction.scale: 3 is outside [0.5, 2]");
  EXPECT_EQ(refusal([](Parameters& p) { p.maximum_delay = 7.0; }),
            "maximum_delay: 7 is outside [0, 6]");
  EXPECT_EQ(refusal([](Parameters& p) { p.tick_period = std::nan(""); }),
            "tick_period: nan is outside (0, 60]");
  EXPECT_EQ(refusal([](Parameters& p) { p.sigma_margin = 0.5; }),
            "sigma_margin: 0.5 is outside [1, 10]");
  EXPECT_EQ(refusal([](Parameters& p) { p.health.bad_share_leave = 0.4; }),
            "health.bad_share_leave: 0.4 is outside (0, 0.3)");
  EXPECT_THAT(refusal([](Parameters& p) {
                p.consensus.offsets = {0.1, 0.1, 0.1};
              }),
              testing::StartsWith("consensus.offsets: 3 values"));
  EXPECT_EQ(refusal([](Parameters& p) { p.consensus.epsilon = 1.0; }),
            "epsilon: 1 is outside (0, 1)");
}

TEST(OdometerCorrection, RefusesWhatIsNoCovariance) {
  OdometerStream stream(fine_odometers(2));
  OdometerCorrection correction;
  correction.covariance(0, 0) = -1.0;
  EXPECT_THROW(stream.set_correction(0, correction), std::invalid_argument);
  correction.covariance << 1e-4, 2e-4, 2e-4, 1e-4;
  EXPECT_THROW(stream.set_correction(0, correction), std::invalid_argument);
  correction.covariance << 1e-4, 1e-5, 0.0, 1e-4;
  EXPECT_THROW(stream.set_correction(0, correction), std::invalid_argument);
  EXPECT_THROW(stream.set_correction(2, {}), std::invalid_argument);
  EXPECT_EQ(stream.state().odometers[0].correction.covariance(0, 0), 0.0);
}

TEST(OdometerStream, NamesItsValues) {
  EXPECT_STREQ(to_string(SampleOutcome::kStampLeap), "stamp leap");
  EXPECT_STREQ(to_string(OdometerHealth::kWorn), "worn");
  EXPECT_STREQ(to_string(OdometerUse::kDrifted), "drifted");
  EXPECT_STREQ(to_string(StreamStatus::kNoData), "no data");
  EXPECT_STREQ(to_string(static_cast<SampleOutcome>(99)), "unknown");
  EXPECT_STREQ(to_string(static_cast<OdometerHealth>(99)), "unknown");
  EXPECT_STREQ(to_string(static_cast<OdometerUse>(99)), "unknown");
  EXPECT_STREQ(to_string(static_cast<StreamStatus>(99)), "unknown");
}

}  // namespace
}  // namespace pipescout::odometry
