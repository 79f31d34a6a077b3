// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/tracked_section.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <stdexcept>

namespace pipescout {
namespace {

using Eigen::Vector4d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(TrackedSectionTest, ComesBackAsItWas) {
  const Vector4d section(159.5, 119.5, 320, -0.1);
  EXPECT_EQ(from_message(section_message(section)), section);
}

TEST(TrackedSectionTest, WhatIsNoSectionIsRefused) {
  EXPECT_THROW((void)from_message(section_message({kNaN, 0, 1, 0})), std::invalid_argument);
  EXPECT_THROW((void)from_message(section_message({0, 0, -1, 0})), std::invalid_argument);
}

TEST(TrackedSectionTest, ThePictureCutsAPipeLengthwiseWhereAnEdgeLeavesIt) {
  const auto whole = [](double v, double angle) {
    return whole_width_in_view({159.5, v, 320, angle}, 4, 320, 240);
  };
  EXPECT_TRUE(whole(119.5, 0));
  EXPECT_TRUE(whole(4, 0)) << "just touches the upper border";
  EXPECT_FALSE(whole(3.9, 0));
  EXPECT_FALSE(whole(235.1, 0));
  EXPECT_FALSE(whole(10, 0.1)) << "its upper end is outside";
  EXPECT_FALSE(whole(kNaN, 0));
}

TEST(TrackedSectionTest, AnUprightPipeIsCutAtTheSides) {
  const auto whole = [](double u, double angle) {
    return whole_width_in_view({u, 119.5, 240, angle}, 4, 320, 240);
  };
  EXPECT_TRUE(whole(160, std::numbers::pi / 2));
  EXPECT_TRUE(whole(160, -std::numbers::pi / 2 + 0.01));
  EXPECT_FALSE(whole(3, std::numbers::pi / 2));
  EXPECT_FALSE(whole(317, std::numbers::pi / 2));
}

}  // namespace
}  // namespace pipescout
