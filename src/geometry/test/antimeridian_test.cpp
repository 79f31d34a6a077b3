// SPDX-License-Identifier: Apache-2.0
#include "pipescout/geometry/antimeridian.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <stdexcept>

namespace pipescout::geometry {
namespace {

using Line = std::vector<GeodeticPosition>;

TEST(Antimeridian, ALineElsewhereStaysWhole) {
  const Line line{{10, 170, 1}, {11, -9.9, 2}, {12, -170, 3}};
  const auto pieces = cut_at_antimeridian(line);
  ASSERT_EQ(pieces.size(), 1U);
  EXPECT_EQ(pieces[0].size(), 3U);
  EXPECT_TRUE(cut_at_antimeridian(Line{}).empty());
  EXPECT_TRUE(cut_at_antimeridian(Line{{1, 2, 3}}).empty());
}

TEST(Antimeridian, ACrossingLineEndsThereOnBothSides) {
  const Line line{{-16, 179.9, 0}, {-17, -179.7, 8}, {-18, 179.9, 0}};
  const auto pieces = cut_at_antimeridian(line);
  ASSERT_EQ(pieces.size(), 3U);
  EXPECT_DOUBLE_EQ(pieces[0][1].longitude, 180);
  EXPECT_NEAR(pieces[0][1].latitude, -16.25, 1e-9);
  EXPECT_NEAR(pieces[0][1].altitude, 2, 1e-9);
  EXPECT_DOUBLE_EQ(pieces[1][0].longitude, -180);
  EXPECT_NEAR(pieces[1][0].latitude, -16.25, 1e-9);
  EXPECT_EQ(pieces[1].size(), 3U);
  EXPECT_DOUBLE_EQ(pieces[2][0].longitude, 180);
}

TEST(Antimeridian, APointOnItIsNotDoubled) {
  const auto pieces = cut_at_antimeridian(Line{{1, 179, 0}, {2, 180, 0}, {3, -179, 0}});
  ASSERT_EQ(pieces.size(), 2U);
  EXPECT_EQ(pieces[0].size(), 2U);
  EXPECT_EQ(pieces[1].size(), 2U);
  const auto other = cut_at_antimeridian(Line{{1, 179, 0}, {2, -180, 0}, {3, -179, 0}});
  ASSERT_EQ(other.size(), 2U);
  EXPECT_EQ(other[1].size(), 2U);
}

TEST(Antimeridian, LongitudesBeyondAreTurnedBack) {
  const auto pieces = cut_at_antimeridian(Line{{0, 179.5, 0}, {0, 180.5, 0}});
  ASSERT_EQ(pieces.size(), 2U);
  EXPECT_DOUBLE_EQ(pieces[1][1].longitude, -179.5);
  EXPECT_THROW((void)cut_at_antimeridian(Line{{91, 0, 0}}), std::invalid_argument);
}

RC_GTEST_PROP(Antimeridian, NoStepIsMoreThanHalfATurn, (const std::vector<int>& degrees)) {
  Line line;
  for (const int degree : degrees) {
    line.push_back({static_cast<double>(degree % 90), static_cast<double>(degree % 181), 0});
  }
  for (const Line& piece : cut_at_antimeridian(line)) {
    for (std::size_t i = 1; i < piece.size(); ++i) {
      RC_ASSERT(std::abs(piece[i].longitude - piece[i - 1].longitude) <= 180.0);
    }
  }
}

}  // namespace
}  // namespace pipescout::geometry
