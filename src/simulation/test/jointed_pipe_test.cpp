// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/jointed_pipe.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

namespace pipescout::simulation {
namespace {

double distance_between(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

TEST(JointedPipe, LengthsHaveTheStatedSpread) {
  const JointedPipe pipe({.joints = 20000, .joint_length = 12.0, .length_spread = 0.01}, 1);
  double sum = 0.0;
  double squares = 0.0;
  for (const Joint& joint : pipe.joints()) {
    sum += joint.length;
    squares += (joint.length - 12.0) * (joint.length - 12.0);
    EXPECT_LE(std::abs(joint.length - 12.0), 3.0 * 0.12 + 1e-12);
  }
  EXPECT_NEAR(sum / 20000.0, 12.0, 4.0 * 0.12 / std::sqrt(20000.0));
  // A normal distribution cut off at 3 sigma has 0.9866 of the standard deviation.
  EXPECT_NEAR(std::sqrt(squares / 20000.0), 0.9866 * 0.12, 0.0025);
  EXPECT_NEAR(pipe.length(), sum, 1e-6);
}

TEST(JointedPipe, IsLaidAsItsTallySays) {
  const std::vector<double> tally(2000, 11.5);
  const JointedPipe pipe({.tally_sigma = 0.02}, tally, 5);
  ASSERT_EQ(pipe.joints().size(), tally.size());
  ASSERT_EQ(pipe.tally().size(), tally.size());
  double squares = 0.0;
  for (std::size_t i = 0; i < tally.size(); ++i) {
    EXPECT_EQ(pipe.tally()[i].length, 11.5);
    EXPECT_EQ(pipe.tally()[i].joint, i);
    squares += std::pow(pipe.joints()[i].length - 11.5, 2);
  }
  EXPECT_NEAR(std::sqrt(squares / 2000.0), 0.02, 4.0 * 0.02 / std::sqrt(4000.0));
  EXPECT_THROW(JointedPipe({}, std::vector<double>{}, 1), std::invalid_argument);
  EXPECT_THROW(JointedPipe({}, std::vector<double>{12.0, -1.0}, 1), std::invalid_argument);
  EXPECT_THROW(JointedPipe({}, std::vector<double>{NAN}, 1), std::invalid_argument);
}

TEST(JointedPipe, WeldsFollowOneAnother) {
  const JointedPipe pipe({.joints = 500}, 2);
  for (std::size_t i = 1; i < 500; ++i) {
    const Joint& before = pipe.joints()[i - 1];
    const Joint& joint = pipe.joints()[i];
    EXPECT_DOUBLE_EQ(joint.begin, before.begin + before.length);
    EXPECT_LT(distance_between(joint.position, pipe.position(joint.begin - 1e-6)), 2e-6);
    EXPECT_EQ(pipe.joint_at(joint.begin), i);
    EXPECT_EQ(pipe.joint_at(joint.begin - 1e-6), i - 1);
  }
  EXPECT_EQ(pipe.joint_at(-5.0), 0U);
  EXPECT_EQ(pipe.joint_at(1e9), 499U);
}

TEST(JointedPipe, ChainageIsTheLengthOfTheCentreLine) {
  const JointedPipe pipe({.joints = 200, .bend_share = 0.4, .slope_share = 0.4}, 3);
  constexpr double kStep = 0.01;
  double length = 0.0;
  const int steps = static_cast<int>(pipe.length() / kStep);
  for (int k = 0; k < steps; ++k) {
    length += distance_between(pipe.position(kStep * k), pipe.position(kStep * (k + 1)));
  }
  EXPECT_NEAR(length, kStep * steps, 1e-4 * pipe.length());
}

TEST(JointedPipe, ABendIsAnArc) {
  const JointedPipe pipe(
      {.joints = 1, .bend_share = 1.0, .largest_bend = std::numbers::pi, .slope_share = 0.0}, 4);
  const Joint& bend = pipe.joints().front();
  ASSERT_NE(bend.heading_rate, 0.0);
  const double radius = 1.0 / std::abs(bend.heading_rate);
  const double angle = bend.heading_rate * bend.length;
  const auto end = pipe.position(bend.length);
  EXPECT_NEAR(distance_between(bend.position, end), 2.0 * radius * std::abs(std::sin(angle / 2.0)),
              1e-9);
  EXPECT_NEAR(pipe.heading(bend.length), angle, 1e-12);
  EXPECT_EQ(end[2], 0.0);
  // Straight on beyond the last weld.
  const auto beyond = pipe.position(bend.length + 2.0);
  EXPECT_NEAR(beyond[0], end[0] + 2.0 * std::cos(angle), 1e-9);
  EXPECT_NEAR(beyond[1], end[1] + 2.0 * std::sin(angle), 1e-9);
}

TEST(JointedPipe, ASlopeGoesUpByTheIntegralOfItsSine) {
  const JointedPipe pipe({.joints = 50, .bend_share = 0.0, .slope_share = 1.0}, 5);
  double height = 0.0;
  constexpr double kStep = 0.001;
  const int steps = static_cast<int>(pipe.length() / kStep);
  for (int k = 0; k < steps; ++k) {
    height += kStep * std::sin(pipe.pitch(kStep * (k + 0.5)));
    ASSERT_LE(std::abs(pipe.pitch(kStep * k)), 0.2618);
  }
  EXPECT_NEAR(pipe.position(kStep * steps)[2], height, 1e-5);
}

TEST(JointedPipe, TheTallyHasItsStatedErrors) {
  const JointedPipe pipe({.joints = 20000,
                          .tally_sigma = 0.005,
                          .tally_wrong = 0.02,
                          .tally_wrong_by = 1.0,
                          .tally_missing = 0.03,
                          .tally_extra = 0.01},
                         6);
  int wrong = 0;
  int extra = 0;
  double squares = 0.0;
  for (const TallyEntry& entry : pipe.tally()) {
    const double error = entry.length - pipe.joints()[entry.joint].length;
    switch (entry.error) {
      case TallyError::kNone:
        squares += error * error;
        break;
      case TallyError::kWrongLength:
        ++wrong;
        EXPECT_GT(std::abs(error), 0.47);
        EXPECT_LT(std::abs(error), 1.03);
        break;
      case TallyError::kExtra:
        ++extra;
    }
  }
  const auto missing = std::count_if(pipe.joints().begin(), pipe.joints().end(),
                                     [](const Joint& joint) { return !joint.in_tally; });
  EXPECT_NEAR(wrong, 0.97 * 400, 80);
  EXPECT_NEAR(extra, 200, 57);
  EXPECT_NEAR(static_cast<double>(missing), 600, 97);
  const auto right = static_cast<double>(pipe.tally().size()) - wrong - extra;
  EXPECT_NEAR(std::sqrt(squares / right), 0.005, 0.0002);
  EXPECT_EQ(pipe.tally().size(),
            20000U - static_cast<std::size_t>(missing) + static_cast<std::size_t>(extra));
}

TEST(JointedPipe, SeedsDecide) {
  const JointedPipe a({}, 7);
  const JointedPipe b({}, 7);
  const JointedPipe c({}, 8);
  EXPECT_EQ(a.length(), b.length());
  EXPECT_EQ(a.tally().front().length, b.tally().front().length);
  EXPECT_NE(a.length(), c.length());
}

TEST(JointedPipe, RefusesWhatIsOutOfRange) {
  const auto refusal = [](const JointedPipeParameters& parameters) -> std::string {
    try {
      JointedPipe(parameters, 1);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal({.joints = 0}), "joints: 0 is outside [1, 1e+06]");
  EXPECT_EQ(refusal({.joint_length = 0.0}), "joint_length: 0 is outside (0, inf]");
  EXPECT_EQ(refusal({.length_spread = 0.5}), "length_spread: 0.5 is outside [0, 0.3]");
  EXPECT_EQ(refusal({.tally_missing = std::nan("")}), "tally_missing: nan is outside [0, 1]");
}

}  // namespace
}  // namespace pipescout::simulation
