// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry/odometer_calibration.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>
#include <vector>

namespace pipescout::odometry {
namespace {

using testing::DoubleNear;
using testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string refusal(const OdometerCalibrationParameters& parameters) {
  try {
    parameters.validate();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(OdometerCalibration, EqualsTheClosedFormOfLeastSquares) {
  // Prior and measurements as one weighted least-squares problem, solved at once.
  const OdometerCalibrationParameters parameters{.scale_drift = 0.0, .gate = 10.0};
  OdometerCalibration calibration(parameters, 2);
  const std::vector<std::pair<double, double>> seen = {{11.9, 12.03}, {5.2, 5.31}, {8.0, 8.11}};
  Eigen::Matrix2d information = Eigen::Vector2d(1.0 / 4e-4, 1.0 / 0.04).asDiagonal();
  Eigen::Vector2d right = information * Eigen::Vector2d(1.0, 0.0);
  for (const auto& [measured, length] : seen) {
    // The measured length's sigma is multiplied by the scale, so it is left at zero here.
    calibration.observe(0, {measured, 0.0, length, 0.02});
    const Eigen::Vector2d direction(measured, 1.0);
    information += direction * direction.transpose() / 4e-4;
    right += direction * length / 4e-4;
  }
  const Eigen::Vector2d expected = information.ldlt().solve(right);
  EXPECT_NEAR(calibration.correction(0).scale, expected(0), 1e-12);
  EXPECT_NEAR(calibration.correction(0).offset, expected(1), 1e-12);
  EXPECT_TRUE(calibration.correction(0).covariance.isApprox(information.inverse(), 1e-9));
}

TEST(OdometerCalibration, FindsThePaperSOffsetsFromStandardPipes) {
  // Section 4: 5.5 m pipes, offsets 0.18, 0.155 and 0.165 m, sigma 0.06, 0.055 and 0.056 m.
  const double offsets[] = {0.18, 0.155, 0.165};
  const double sigmas[] = {0.06, 0.055, 0.056};
  std::mt19937_64 engine(1001);
  std::normal_distribution<double> normal;
  OdometerCalibration calibration({.initial_scale_standard_deviation = 1e-4, .scale_drift = 0.0},
                                  3);
  for (int i = 0; i < 200; ++i) {
    for (std::size_t o = 0; o < 3; ++o) {
      calibration.observe(o, {5.5 - offsets[o] + sigmas[o] * normal(engine), sigmas[o], 5.5, 0.0});
    }
  }
  for (std::size_t o = 0; o < 3; ++o) {
    const auto& found = calibration.correction(o);
    const double sigma = std::sqrt(found.covariance(1, 1));
    EXPECT_LT(sigma, 0.006);
    EXPECT_THAT(found.offset, DoubleNear(offsets[o], 3.0 * sigma));
  }
}

TEST(OdometerCalibration, SaysThatEqualLengthsDoNotTellScaleFromOffset) {
  OdometerCalibration calibration({.scale_drift = 0.0}, 2);
  for (int i = 0; i < 1000; ++i) {
    calibration.observe(0, {12.0, 0.01, 12.1, 0.01});
  }
  const auto& found = calibration.correction(0);
  EXPECT_GT(std::sqrt(found.covariance(0, 0)), 0.01);
  EXPECT_GT(std::sqrt(found.covariance(1, 1)), 0.1);
  EXPECT_NEAR(found.scale * 12.0 + found.offset, 12.1, 1e-3);
  const Eigen::Vector2d direction(12.0, 1.0);
  EXPECT_LT(std::sqrt(direction.dot(found.covariance * direction)), 0.001);
}

TEST(OdometerCalibration, SlipHardlyCounts) {
  std::mt19937_64 engine(1002);
  std::uniform_real_distribution<double> length(9.0, 13.0);
  std::normal_distribution<double> normal(0.0, 0.02);
  OdometerCalibration calibration({.scale_drift = 0.0}, 2);
  for (int i = 0; i < 300; ++i) {
    const double truth = length(engine);
    const double slip = i % 10 == 0 ? 0.7 : 1.0;
    const auto outcome =
        calibration.observe(0, {truth / 0.99 * slip + normal(engine), 0.02, truth, 0.01});
    if (slip < 1.0) {
      EXPECT_EQ(outcome, CalibrationOutcome::kFarOff);
    }
  }
  EXPECT_NEAR(calibration.correction(0).scale, 0.99, 0.005);
  EXPECT_NEAR(calibration.correction(0).scale * 12.0 / 0.99 + calibration.correction(0).offset,
              12.0, 0.01);
  EXPECT_GE(calibration.counts(0).far_off, 30U);
  EXPECT_EQ(calibration.counts(0).changes, 0U);
}

TEST(OdometerCalibration, FollowsWear) {
  std::mt19937_64 engine(1003);
  std::normal_distribution<double> length(12.0, 0.12);
  std::normal_distribution<double> normal(0.0, 0.02);
  OdometerCalibration calibration({.initial_offset_standard_deviation = 0.0}, 2);
  int inside = 0;
  constexpr int kJoints = 833;
  for (int i = 0; i < kJoints; ++i) {
    const double truth = length(engine);
    const double scale = 1.0 / (1.0 + 0.02 * i / kJoints);
    calibration.observe(0, {truth / scale + normal(engine), 0.02, truth, 0.0});
    const double sigma = std::sqrt(calibration.correction(0).covariance(0, 0));
    inside += std::abs(calibration.correction(0).scale - scale) <= 1.96 * sigma ? 1 : 0;
  }
  EXPECT_NEAR(calibration.correction(0).scale, 1.0 / 1.02, 0.002);
  EXPECT_GE(inside, kJoints * 9 / 10);
}

TEST(OdometerCalibration, LearnsAnewAfterAChange) {
  OdometerCalibration calibration({.change_after = 4}, 2);
  for (int i = 0; i < 50; ++i) {
    calibration.observe(1, {12.0, 0.02, 12.0, 0.01});
  }
  std::vector<CalibrationOutcome> outcomes;
  for (int i = 0; i < 12; ++i) {  // another wheel was fitted
    outcomes.push_back(calibration.observe(1, {11.0, 0.02, 12.0, 0.01}));
  }
  EXPECT_EQ(outcomes[3], CalibrationOutcome::kChanged);
  EXPECT_EQ(calibration.counts(1).changes, 1U);
  EXPECT_NEAR(calibration.correction(1).scale * 11.0 + calibration.correction(1).offset, 12.0,
              0.03);
}

TEST(OdometerCalibration, OdometersDoNotTouchEachOther) {
  OdometerCalibration calibration({}, 3);
  calibration.observe(1, {11.8, 0.02, 12.0, 0.01});
  EXPECT_EQ(calibration.correction(0).scale, 1.0);
  EXPECT_NE(calibration.correction(1).scale, 1.0);
  EXPECT_EQ(calibration.correction(2).scale, 1.0);
}

TEST(OdometerCalibration, BadValuesAreCountedAndChangeNothing) {
  OdometerCalibration calibration({}, 2);
  const WeldSpacing good{12.0, 0.02, 12.0, 0.01};
  std::vector<WeldSpacing> bad;
  for (const double value : {kNaN, kInfinity, -kInfinity, -1.0}) {
    bad.insert(bad.end(), 4, good);
    auto* const last = &bad[bad.size() - 4];
    last[0].measured = last[1].measured_standard_deviation = value;
    last[2].length = last[3].length_standard_deviation = value;
  }
  bad.push_back({0.0, 0.02, 12.0, 0.01});
  bad.push_back({12.0, 0.02, 0.0, 0.01});
  bad.push_back({12.0, 0.0, 12.0, 0.0});
  for (const auto& spacing : bad) {
    EXPECT_EQ(calibration.observe(0, spacing), CalibrationOutcome::kBadValue);
  }
  EXPECT_EQ(calibration.counts(0).bad_values, bad.size());
  EXPECT_EQ(calibration.correction(0).scale, 1.0);
  EXPECT_EQ(calibration.correction(0).covariance(0, 0), 0.02 * 0.02);
}

TEST(OdometerCalibration, CorrectionsAreAlwaysValid) {
  std::mt19937_64 engine(1004);
  std::lognormal_distribution<double> anything(0.0, 3.0);
  OdometerCalibration calibration({}, 2);
  for (int i = 0; i < 10'000; ++i) {
    calibration.observe(0,
                        {anything(engine), anything(engine), anything(engine), anything(engine)});
    ASSERT_NO_THROW(calibration.correction(0).validate()) << "after " << i;
  }
}

TEST(OdometerCalibration, RefusesParametersByName) {
  EXPECT_EQ(refusal({}), "");
  EXPECT_THAT(refusal({.initial_scale = 3.0}), HasSubstr("initial_scale: 3 is outside [0.5, 2]"));
  EXPECT_THAT(refusal({.initial_scale_standard_deviation = 0.0}),
              HasSubstr("initial_scale_standard_deviation: 0 is outside (0, 0.5]"));
  EXPECT_THAT(refusal({.initial_offset = kNaN}), HasSubstr("initial_offset: nan"));
  EXPECT_THAT(refusal({.initial_offset_standard_deviation = -1.0}),
              HasSubstr("initial_offset_standard_deviation: -1"));
  EXPECT_THAT(refusal({.scale_drift = 1.0}), HasSubstr("scale_drift: 1"));
  EXPECT_THAT(refusal({.gate = 0.5}), HasSubstr("gate: 0.5 is outside [1, 10]"));
  EXPECT_THAT(refusal({.change_after = 1}), HasSubstr("change_after: 1 is outside [2, inf)"));
  EXPECT_THROW(OdometerCalibration({}, 1), std::invalid_argument);
  EXPECT_THROW(OdometerCalibration({}, 17), std::invalid_argument);
  OdometerCalibration calibration({}, 2);
  EXPECT_THROW(calibration.observe(2, {}), std::out_of_range);
  EXPECT_THROW(static_cast<void>(calibration.correction(2)), std::out_of_range);
  EXPECT_THROW(static_cast<void>(calibration.counts(2)), std::out_of_range);
}

}  // namespace
}  // namespace pipescout::odometry
