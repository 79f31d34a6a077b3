// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigation_maps/pose2d.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <numbers>

namespace pipescout::navigation {
namespace {

TEST(Pose2d, WrapsToHalfOpenInterval) {
  EXPECT_EQ(wrap_angle(std::numbers::pi), -std::numbers::pi);
  EXPECT_EQ(wrap_angle(-std::numbers::pi), -std::numbers::pi);
  EXPECT_NEAR(wrap_angle(7), 7 - 2 * std::numbers::pi, 1e-15);
  EXPECT_TRUE(std::isnan(wrap_angle(INFINITY)));
}

RC_GTEST_PROP(Pose2d, RelativeUndoesCompose, (int a, int b, int c, int d, int e, int f)) {
  const Pose2d T_A_B{a * 1e-6, b * 1e-6, wrap_angle(c * 1e-3)};
  const Pose2d T_B_C{d * 1e-6, e * 1e-6, wrap_angle(f * 1e-3)};
  const Pose2d back = relative(T_A_B, compose(T_A_B, T_B_C));
  RC_ASSERT(distance(back, T_B_C) < 1e-9);
  RC_ASSERT(std::abs(wrap_angle(back.heading - T_B_C.heading)) < 1e-9);
}

}  // namespace
}  // namespace pipescout::navigation
