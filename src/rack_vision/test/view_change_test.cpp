// SPDX-License-Identifier: Apache-2.0
#include "view_change.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace pipescout::rack_vision {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;

constexpr double kHeight = 2.5;   // m: another view after 0.25 m
constexpr double kPeriod = 0.04;  // s

SE3 looking_down(const Vector3d& place, double turn = 0) {
  return {SO3::about_z(turn) * SO3::about_x(std::numbers::pi), place};
}

TEST(ViewChange, HoveringTellsOneViewAndLittleMore) {
  ViewChange view;
  view.begin(looking_down({0, 0, kHeight}), 0);
  for (int k = 1; k <= 250; ++k) {
    const double t = k * kPeriod;
    view.see(looking_down({0.01 * std::sin(t), 0.01 * std::cos(3 * t), kHeight}), t);
  }
  EXPECT_LT(view.views(), 0.7);  // 10 s of a view that is another one after 20, and 2 cm
  EXPECT_GT(view.views(), 0.5);
}

TEST(ViewChange, AWayTellsAsManyViewsAsItIsLong) {
  ViewChange view;
  view.begin(looking_down({0, 0, kHeight}), 0);
  double told = 0;
  for (int k = 1; k <= 250; ++k) {
    told += view.see(looking_down({0, 0.25 * k * kPeriod, kHeight}), k * kPeriod);
  }
  EXPECT_NEAR(view.views(), 2.5 / 0.25 + 10 / 20.0, 1);
  EXPECT_NEAR(view.views(), told, 1e-9);
}

TEST(ViewChange, ATurnIsAnotherViewAndNoImageTellsMoreThanOne) {
  ViewChange view;
  view.begin(looking_down({0, 0, kHeight}), 0);
  EXPECT_NEAR(view.see(looking_down({0, 0, kHeight}, 0.05), kPeriod), 0.5, 0.01);
  EXPECT_NEAR(view.see(looking_down({0, 0, kHeight}, 0.05), 2 * kPeriod), 0, 0.01);
  EXPECT_NEAR(view.see(looking_down({5, 5, kHeight}, 1), 3 * kPeriod), 0.5, 0.01);
  EXPECT_EQ(view.see(looking_down({9, 9, kHeight}), 4 * kPeriod), 1);
}

}  // namespace
}  // namespace pipescout::rack_vision
