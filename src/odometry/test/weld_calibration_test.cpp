// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry/weld_calibration.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "odometer_bench.hpp"

namespace pipescout::odometry {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kSpeed = 0.5;  // m/s
constexpr double kJoint = 12.0;

/// Three wheels that show `scales` of the distance, along a pipe of equal joints.
class WeldCalibrationTest : public ::testing::Test {
 protected:
  void drive(const std::vector<test::WheelModel>& wheels, int joints,
             WeldCalibrationParameters parameters = {}) {
    std::vector<test::BenchWheel> bench_wheels;
    for (const auto& wheel : wheels) {
      bench_wheels.push_back({.model = wheel});
    }
    calibration_.emplace(parameters, wheels.size());
    test::OdometerBench bench(stream_, bench_wheels, [](double time) { return kSpeed * time; });
    std::uint64_t tick = 0;
    bench.observe = [&] {
      if (stream_.state().tick != tick) {
        tick = stream_.state().tick;
        calibration_->record(stream_.state());
      }
    };
    for (int joint = 0; joint < joints; ++joint) {
      const double from = kJoint * joint / kSpeed;
      const double to = kJoint * (joint + 1) / kSpeed;
      // The weld is reported a metre after it was passed.
      bench.run_until(to + 2.0);
      outcomes_.push_back(calibration_->observe({.from = std::max(from, 0.2),
                                                 .to = to,
                                                 .length = kJoint - (joint == 0 ? 0.1 : 0.0),
                                                 .standard_deviation = 0.01},
                                                stream_));
    }
  }

  static test::WheelModel scaled(double scale) {
    return [scale](double, double distance) { return distance / scale; };
  }

  OdometerStream stream_{test::fine_odometers(3)};
  std::optional<WeldCalibration> calibration_;
  std::vector<SpacingOutcome> outcomes_;
};

TEST_F(WeldCalibrationTest, FindsTheScalesAndPutsThemIntoEffect) {
  drive({scaled(1.01), scaled(1.013), scaled(1.007)}, 20);
  EXPECT_THAT(outcomes_, ::testing::Each(SpacingOutcome::kUsed));
  const double scales[] = {1.01, 1.013, 1.007};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(calibration_->correction(i).scale, scales[i], 5e-4) << i;
    EXPECT_NEAR(stream_.state().odometers[i].correction.scale, scales[i], 8e-4) << i;
    EXPECT_LT(std::sqrt(calibration_->correction(i).covariance(0, 0)), 1e-3) << i;
    EXPECT_FALSE(calibration_->is_worn(i)) << i;
  }
}

TEST_F(WeldCalibrationTest, TellsAWornWheel) {
  // The third loses 3 % of its radius between 120 m and 420 m.
  const auto worn = [](double, double distance) {
    const double path = std::clamp(distance - 120.0, 0.0, 300.0);
    return distance + 0.5e-4 * path * path + (distance > 420.0 ? 0.03 * (distance - 420.0) : 0.0);
  };
  drive({scaled(1.0), scaled(1.0), worn}, 60,
        {.calibration = {.initial_offset_standard_deviation = 0.0, .scale_drift = 1e-6}});
  EXPECT_TRUE(calibration_->is_worn(2));
  EXPECT_FALSE(calibration_->is_worn(0));
  EXPECT_NEAR(calibration_->correction(2).scale, 1.0 / 1.03, 3e-3);
}

TEST_F(WeldCalibrationTest, LearnsNothingFromAWheelThatSlips) {
  // 10 % lost between 100 m and 130 m: rejected there, so the joints it was rejected in do not
  // count.
  const auto slips = [](double, double distance) {
    return distance - 0.1 * std::clamp(distance - 100.0, 0.0, 30.0);
  };
  drive({scaled(1.0), scaled(1.0), slips}, 15);
  EXPECT_NEAR(calibration_->correction(2).scale, 1.0, 2e-3);
}

TEST_F(WeldCalibrationTest, SaysWhatItCannotUse) {
  drive({scaled(1.0), scaled(1.0), scaled(1.0)}, 3, {.history = 200});
  const auto outcome = [&](const KnownSpacing& spacing) {
    return calibration_->observe(spacing, stream_);
  };
  const double now = stream_.state().time;
  const KnownSpacing good{.from = now - 12.0, .to = now, .length = 6.0, .standard_deviation = 0.01};
  EXPECT_EQ(outcome(good), SpacingOutcome::kUsed);
  const auto spoiled = [&](auto member, double value) {
    KnownSpacing spacing = good;
    spacing.*member = value;
    return outcome(spacing);
  };
  for (const double bad : {kNan, std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(spoiled(&KnownSpacing::from, bad), SpacingOutcome::kBadValue);
    EXPECT_EQ(spoiled(&KnownSpacing::to, bad), SpacingOutcome::kBadValue);
    EXPECT_EQ(spoiled(&KnownSpacing::length, bad), SpacingOutcome::kBadValue);
    EXPECT_EQ(spoiled(&KnownSpacing::standard_deviation, bad), SpacingOutcome::kBadValue);
  }
  EXPECT_EQ(spoiled(&KnownSpacing::length, 0.0), SpacingOutcome::kBadValue);
  EXPECT_EQ(spoiled(&KnownSpacing::standard_deviation, -0.1), SpacingOutcome::kBadValue);
  EXPECT_EQ(spoiled(&KnownSpacing::from, now), SpacingOutcome::kBadValue);
  EXPECT_EQ(spoiled(&KnownSpacing::from, now - 30.0), SpacingOutcome::kTooOld);
  EXPECT_EQ(spoiled(&KnownSpacing::to, now + 1.0), SpacingOutcome::kTooOld);
}

TEST_F(WeldCalibrationTest, WithOffsetsOnlySingleJointsCount) {
  drive({scaled(1.0), scaled(1.0), scaled(1.0)}, 2,
        {.calibration = {.initial_offset_standard_deviation = 0.2}});
  const double now = stream_.state().time;
  EXPECT_EQ(
      calibration_->observe(
          {.from = now - 20.0, .to = now, .length = 10.0, .standard_deviation = 0.01, .joints = 2},
          stream_),
      SpacingOutcome::kSeveralJoints);
}

TEST_F(WeldCalibrationTest, ForgetsWhatWasBeforeALeapOfTheClocks) {
  WeldCalibration calibration({}, 2);
  FusedStream state;
  for (const double time : {100.0, 101.0, 102.0, 50.0, 51.0}) {
    state.time = time;
    calibration.record(state);
  }
  EXPECT_EQ(calibration.observe({100.0, 101.0, 1.0, 0.01}, stream_), SpacingOutcome::kTooOld);
}

TEST(WeldCalibrationParameters, AreChecked) {
  EXPECT_THROW((WeldCalibrationParameters{.history = 1}.validate()), std::invalid_argument);
  EXPECT_THROW((WeldCalibrationParameters{.least_change = kNan}.validate()), std::invalid_argument);
  EXPECT_THROW((WeldCalibrationParameters{.worn_tolerance = 0.0}.validate()),
               std::invalid_argument);
  EXPECT_THROW((WeldCalibrationParameters{.worn_release = 1.0}.validate()), std::invalid_argument);
  EXPECT_THROW((WeldCalibration({}, 1)), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::odometry
