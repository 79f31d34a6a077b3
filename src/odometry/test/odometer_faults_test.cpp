// SPDX-License-Identifier: Apache-2.0
// Odometers that slip, stick, wear, fall silent, count wrong or say nonsense.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "odometer_bench.hpp"
#include "pipescout/odometry/odometer_stream.hpp"

namespace pipescout::odometry {
namespace {

using test::BenchWheel;
using test::fine_odometers;
using test::OdometerBench;

constexpr double kSpeed = 0.5;  // m/s
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double at_speed(double time) {
  return kSpeed * time;
}

/// What the wheel shows when it loses `ratio` of the distance between `from` and `to`, m.
double slipped(double distance, double from, double to, double ratio) {
  return distance - ratio * std::clamp(distance - from, 0.0, to - from);
}

std::uint64_t count_of(const OdometerStream& stream, std::size_t odometer, SampleOutcome outcome) {
  return stream.state().odometers[odometer].samples[static_cast<std::size_t>(outcome)];
}

OdometerHealth health_of(const OdometerStream& stream, std::size_t odometer) {
  return stream.state().odometers[odometer].health;
}

TEST(OdometerSlip, IsLeftOutSeenAndForgiven) {
  OdometerStream stream(fine_odometers(3));
  std::vector<BenchWheel> wheels(3);
  wheels[1].model = [](double, double distance) { return slipped(distance, 20.0, 30.0, 0.3); };
  OdometerBench bench(stream, wheels, at_speed);
  bench.run_until(38.0);  // 19 m
  EXPECT_EQ(health_of(stream, 1), OdometerHealth::kOk);
  bench.run_until(50.0);  // 25 m
  EXPECT_EQ(health_of(stream, 1), OdometerHealth::kSlipping);
  EXPECT_NE(stream.state().odometers[1].use, OdometerUse::kFused);
  EXPECT_FALSE(stream.state().consensus.fusion_set[1]);
  bench.run_until(80.0);  // 40 m
  EXPECT_EQ(health_of(stream, 1), OdometerHealth::kOk);
  EXPECT_EQ(stream.state().odometers[1].use, OdometerUse::kFused);
  EXPECT_NEAR(stream.state().distance, 40.0, 0.01);
}

TEST(OdometerSlip, OneTooSmallForAWindowIsTakenOutAfterwards) {
  auto parameters = fine_odometers(3);
  for (auto& odometer : parameters.odometers) {
    odometer.sigma_per_sqrt_metre = 0.03;
  }
  const auto error = [&](std::size_t lookback) {
    parameters.lookback_windows = lookback;
    OdometerStream stream(parameters);
    std::vector<BenchWheel> wheels(3);
    wheels[2].model = [](double, double distance) { return slipped(distance, 10.0, 20.0, 0.08); };
    OdometerBench bench(stream, wheels, at_speed);
    bench.run_until(80.0);
    return std::abs(stream.state().distance - 40.0);
  };
  EXPECT_NEAR(error(0), 0.8 / 3.0, 0.01);  // a third of the slip, never refused
  EXPECT_LT(error(8), 0.05);
}

TEST(OdometerStuck, IsNamedAndLeavesTheOthersTheirMajority) {
  // Two of four stand still one after the other: without being left out they would be half.
  OdometerStream stream(fine_odometers(4));
  std::vector<BenchWheel> wheels(4);
  wheels[0].model = [](double, double distance) { return std::min(distance, 10.0); };
  wheels[3].model = [](double, double distance) {
    return distance < 20.0 ? distance : std::max(20.0, distance - 20.0);
  };
  OdometerBench bench(stream, wheels, at_speed);
  bench.run_until(30.0);
  EXPECT_EQ(health_of(stream, 0), OdometerHealth::kStuck);
  EXPECT_EQ(stream.state().odometers[0].use, OdometerUse::kStuck);
  bench.run_until(60.0);
  EXPECT_EQ(health_of(stream, 3), OdometerHealth::kStuck);
  EXPECT_EQ(stream.state().status, StreamStatus::kOk);
  EXPECT_NEAR(stream.state().distance, 30.0, 0.01);
  bench.run_until(100.0);  // the last one goes on from 40 m
  EXPECT_EQ(health_of(stream, 3), OdometerHealth::kOk);
  EXPECT_NEAR(stream.state().distance, 50.0, 0.01);
}

TEST(OdometerStuck, StandingStillTogetherIsNoFault) {
  OdometerStream stream(fine_odometers(3));
  OdometerBench bench(stream, std::vector<BenchWheel>(3), [](double) { return 3.0; });
  bench.run_until(600.0);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(health_of(stream, i), OdometerHealth::kOk);
  }
  EXPECT_EQ(stream.state().status, StreamStatus::kOk);
  EXPECT_EQ(stream.state().distance, 0.0);
}

TEST(OdometerWear, IsNamedAgainstTheOthersAndCorrected) {
  OdometerStream stream(fine_odometers(3));
  std::vector<BenchWheel> wheels(3);
  wheels[2].model = [](double, double distance) { return 1.015 * distance; };
  OdometerBench bench(stream, wheels, at_speed);
  bench.run_until(150.0);
  EXPECT_NE(health_of(stream, 2), OdometerHealth::kWorn);  // not long enough to know
  bench.run_until(1600.0);
  EXPECT_EQ(health_of(stream, 0), OdometerHealth::kOk);
  EXPECT_EQ(health_of(stream, 1), OdometerHealth::kOk);
  EXPECT_EQ(health_of(stream, 2), OdometerHealth::kWorn);
  EXPECT_NEAR(stream.state().odometers[2].relative_scale, 1.015, 0.002);
  stream.set_correction(2, {.scale = 1.0 / 1.015});
  bench.run_until(3200.0);
  EXPECT_EQ(health_of(stream, 2), OdometerHealth::kOk);
  EXPECT_NEAR(stream.state().odometers[2].relative_scale, 1.0, 0.001);
}

TEST(OdometerSilence, OfMinutesIsNamedBridgedByTheOthersAndEnds) {
  OdometerStream stream(fine_odometers(3));
  std::vector<BenchWheel> wheels(3);
  wheels[0].sends = [](double time) { return time < 30.0 || time > 330.0; };
  OdometerBench bench(stream, wheels, at_speed);
  bench.run_until(100.0);
  EXPECT_EQ(health_of(stream, 0), OdometerHealth::kSilent);
  EXPECT_EQ(stream.state().odometers[0].use, OdometerUse::kAbsent);
  EXPECT_EQ(stream.state().status, StreamStatus::kOk);
  EXPECT_NEAR(stream.state().time, 100.0, 1e-6);  // nobody waits for it any more
  bench.run_until(340.0);
  EXPECT_EQ(health_of(stream, 0), OdometerHealth::kOk);
  EXPECT_EQ(stream.state().odometers[0].use, OdometerUse::kFused);
  EXPECT_EQ(stream.state().odometers[0].gaps, 1U);
  EXPECT_NEAR(stream.state().distance, 170.0, 1e-6);
}

TEST(OdometerSilence, OfAllIsMadeGoodByTheCounters) {
  OdometerStream stream(fine_odometers(3));
  std::vector<BenchWheel> wheels(3);
  for (auto& wheel : wheels) {
    wheel.sends = [](double time) { return time < 50.0 || time > 170.0; };
  }
  OdometerBench bench(stream, wheels, at_speed);
  bench.run_until(250.0);
  EXPECT_EQ(stream.state().leaps, 1U);
  EXPECT_EQ(stream.state().windows_no_data, 0U);
  EXPECT_EQ(stream.state().status, StreamStatus::kOk);
  EXPECT_NEAR(stream.state().distance, kSpeed * stream.state().time, 0.011);  // a sample
}

TEST(OdometerSilence, OfAllIncrementalOnesIsOwnedUpTo) {
  auto parameters = fine_odometers(2);
  std::vector<BenchWheel> wheels(2);
  for (std::size_t i = 0; i < 2; ++i) {
    parameters.odometers[i].kind = OdometerKind::kIncrement;
    wheels[i].model = [before = 0.0](double, double distance) mutable {
      return distance - std::exchange(before, distance);
    };
    wheels[i].sends = [](double time) { return time < 50.0 || time > 60.0; };
  }
  OdometerStream stream(parameters);
  OdometerBench bench(stream, wheels, at_speed);
  bench.run_until(50.0);
  const double before = std::sqrt(stream.state().variance);
  bench.run_until(100.0);
  EXPECT_EQ(stream.state().windows_no_data, 1U);
  const double sigma = std::sqrt(stream.state().variance);
  EXPECT_LT(before, 0.02);
  EXPECT_GT(sigma, 10.0);  // any speed up to 5 m/s for 10 s
  EXPECT_LT(std::abs(stream.state().distance - 50.0), sigma);
}

TEST(OdometerConsensus, WithoutOneTheMedianGoesOnAndSaysSo) {
  OdometerStream stream(fine_odometers(3));
  std::vector<BenchWheel> wheels(3);
  for (std::size_t i = 1; i < 3; ++i) {
    const double ratio = 0.15 * static_cast<double>(i);
    wheels[i].model = [ratio](double, double distance) {
      return slipped(distance, 10.0, 20.0, ratio);
    };
  }
  OdometerBench bench(stream, wheels, at_speed);
  bench.run_until(39.0);
  EXPECT_EQ(stream.state().status, StreamStatus::kNoConsensus);
  EXPECT_EQ(stream.state().odometers[1].use, OdometerUse::kFallback);
  bench.run_until(80.0);
  EXPECT_EQ(stream.state().status, StreamStatus::kOk);
  const double error = std::abs(stream.state().distance - 40.0);
  EXPECT_GT(error, 1.0);  // half of the wheels' slip: nobody could know
  EXPECT_LT(error, 1.2 * std::sqrt(stream.state().variance));
  EXPECT_GE(stream.state().windows_no_consensus, 8U);
}

TEST(OdometerConsensus, OneOdometerAloneIsNotTrustedMuch) {
  OdometerStream stream(fine_odometers(2));
  std::vector<BenchWheel> wheels(2);
  wheels[1].sends = [](double time) { return time < 20.0; };
  OdometerBench bench(stream, wheels, at_speed);
  bench.run_until(60.0);
  EXPECT_EQ(stream.state().status, StreamStatus::kNoConsensus);
  EXPECT_NEAR(stream.state().distance, 30.0, 1e-6);
  EXPECT_NEAR(std::sqrt(stream.state().variance), 0.3 * 20.0, 0.5);
}

TEST(OdometerCounter, ResetsAndWrongValuesAreCountedNotTravelled) {
  OdometerStream stream(fine_odometers(3));
  std::vector<BenchWheel> wheels(3);
  wheels[0].model = [](double time, double distance) {
    return time < 40.0 ? distance : distance - 20.0;  // switched off and on
  };
  wheels[1].model = [](double time, double distance) {
    return std::abs(time - 60.0) < 0.005 ? 1e300 : distance;
  };
  OdometerBench bench(stream, wheels, at_speed);
  bench.run_until(100.0);
  EXPECT_EQ(count_of(stream, 0, SampleOutcome::kImplausible), 1U);
  EXPECT_EQ(count_of(stream, 1, SampleOutcome::kImplausible), 2U);  // there and back
  EXPECT_NEAR(stream.state().distance, 50.0, 1e-6);
  EXPECT_EQ(stream.state().status, StreamStatus::kOk);
  EXPECT_EQ(stream.state().consensus.fusion_set.to_ulong(), 0b111U);
}

TEST(OdometerCounter, ThatRestartsWhileAllAreSilentIsNotReverseTravel) {
  OdometerStream stream(fine_odometers(3));
  std::vector<BenchWheel> wheels(3);
  for (auto& wheel : wheels) {
    wheel.model = [](double time, double distance) {
      return time < 60.0 ? distance + 100.0 : distance - 90.0;
    };
    wheel.sends = [](double time) { return time < 50.0 || time > 180.0; };
  }
  OdometerBench bench(stream, wheels, at_speed);
  bench.run_until(200.0);
  EXPECT_GE(count_of(stream, 0, SampleOutcome::kImplausible), 1U);
  EXPECT_GT(stream.state().distance, 25.0);
  EXPECT_LT(std::abs(stream.state().distance - 100.0), std::sqrt(stream.state().variance));
}

TEST(OdometerSamples, NonsenseIsCountedByKind) {
  OdometerStream stream(fine_odometers(2));
  const auto outcome = [&](OdometerSample sample) { return stream.push(sample).outcome; };
  using enum SampleOutcome;
  EXPECT_EQ(outcome({.odometer = 0, .time = kNaN, .value = 0.0}), kBadStamp);
  EXPECT_EQ(outcome({.odometer = 0, .time = 1.0, .value = 0.0}), kAccepted);
  EXPECT_EQ(outcome({.odometer = 0, .time = 1.1, .value = 0.01}), kAccepted);
  EXPECT_EQ(outcome({.odometer = 0, .time = 1.1, .value = 0.01}), kDuplicateStamp);
  EXPECT_EQ(outcome({.odometer = 0, .time = 1.05, .value = 0.0}), kOutOfOrder);
  EXPECT_EQ(outcome({.odometer = 0, .time = 1.2, .value = kNaN}), kNotANumber);
  EXPECT_EQ(outcome({.odometer = 0, .time = 1.2, .value = 0.0, .valid = false}), kMarkedInvalid);
  EXPECT_EQ(outcome({.odometer = 0, .time = 1e9, .value = 0.0}), kStampLeap);
  EXPECT_EQ(outcome({.odometer = 0, .time = -1e300, .value = 0.0}), kStampLeap);
  EXPECT_EQ(outcome({.odometer = 0, .time = 1.2, .value = 500.0}), kImplausible);
  EXPECT_EQ(outcome({.odometer = 2, .time = 1.2, .value = 0.0}), kUnknownOdometer);
  for (const auto kind :
       {kBadStamp, kDuplicateStamp, kOutOfOrder, kNotANumber, kMarkedInvalid, kImplausible}) {
    EXPECT_EQ(count_of(stream, 0, kind), 1U) << to_string(kind);
  }
  EXPECT_EQ(count_of(stream, 0, kStampLeap), 2U);
  EXPECT_EQ(stream.state().unknown_odometer, 1U);
}

TEST(OdometerSamples, ManyBadValuesAreAHealthOfTheirOwn) {
  OdometerStream stream(fine_odometers(3));
  std::vector<BenchWheel> wheels(3);
  wheels[1].model = [](double time, double distance) {
    return time > 20.0 && time < 40.0 && std::fmod(time, 0.04) < 0.02 ? kNaN : distance;
  };
  OdometerBench bench(stream, wheels, at_speed);
  bench.run_until(19.0);
  EXPECT_EQ(health_of(stream, 1), OdometerHealth::kOk);
  bench.run_until(30.0);
  EXPECT_EQ(health_of(stream, 1), OdometerHealth::kBadValues);
  EXPECT_EQ(stream.state().odometers[1].use, OdometerUse::kFused);  // the others of them are good
  bench.run_until(50.0);
  EXPECT_EQ(health_of(stream, 1), OdometerHealth::kOk);
}

TEST(OdometerClock, ThatIsSetIsFollowedForwardAndBack) {
  for (const double leap : {3600.0, -3600.0}) {
    OdometerStream stream(fine_odometers(3));
    for (int k = 0; k < 5000; ++k) {
      const double time = 5000.0 + 0.02 * k + (k < 2500 ? 0.0 : leap);
      for (std::size_t i = 0; i < 3; ++i) {
        stream.push({.odometer = i, .time = time, .value = 0.01 * k});
      }
    }
    EXPECT_EQ(stream.state().leaps, 1U);
    EXPECT_NEAR(stream.state().distance, 0.01 * 4995.0, 0.011) << leap;
    EXPECT_NEAR(stream.state().time, 5000.0 + 0.02 * 4995.0 + leap, 0.2);
    EXPECT_EQ(stream.state().status, StreamStatus::kOk);
  }
}

TEST(OdometerClock, OfOneOdometerAloneIsNotFollowed) {
  OdometerStream stream(fine_odometers(3));
  for (int k = 0; k < 5000; ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      const double time = 0.02 * k + (i == 1 && k > 2000 ? 1e6 : 0.0);
      stream.push({.odometer = i, .time = time, .value = 0.01 * k});
    }
  }
  EXPECT_EQ(stream.state().leaps, 0U);
  EXPECT_EQ(health_of(stream, 1), OdometerHealth::kSilent);
  EXPECT_EQ(count_of(stream, 1, SampleOutcome::kStampLeap), 2999U);
  EXPECT_NEAR(stream.state().distance, 49.99, 0.06);
}

TEST(OdometerSigma, IsEstimatedFromResiduals) {
  auto parameters = fine_odometers(4);
  parameters.sigma_source = SigmaSource::kResiduals;
  parameters.residual_windows = 64;
  const std::array<double, 4> truth = {0.01, 0.01, 0.02, 0.03};
  OdometerStream stream(parameters);
  std::mt19937_64 engine(7);
  std::normal_distribution<double> normal;
  std::array<double, 4> shown{};
  std::array<double, 4> mean{};
  for (int k = 1; k <= 100000; ++k) {
    for (std::size_t i = 0; i < 4; ++i) {
      shown[i] += 0.01 + truth[i] * std::sqrt(0.01) * normal(engine);
      stream.push({.odometer = i, .time = 0.02 * k, .value = shown[i]});
      mean[i] += stream.state().odometers[i].sigma_per_sqrt_metre / 100000.0;
    }
  }
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(mean[i], truth[i], 0.25 * truth[i]) << i;
  }
}

}  // namespace
}  // namespace pipescout::odometry
