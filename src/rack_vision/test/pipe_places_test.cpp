// SPDX-License-Identifier: Apache-2.0
#include "pipe_places.hpp"

#include <gtest/gtest.h>

#include "drawn_rack.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr double kTolerance = 0.01;  // m

/// Best combinations of places of the four pipes of `drawn_rack`, 0.1 m from each other.
std::vector<PlacedPipes> place(const std::vector<std::vector<PipePlace>>& places,
                               std::size_t most = 3) {
  std::vector<PlacedPipes> placed;
  place_pipes(test::drawn_rack(), places, kTolerance, most, placed);
  return placed;
}

TEST(PipePlaces, TheBestOfEachPipeIsTakenWhereTheyDoNotIntersect) {
  const auto placed = place({{{0, 0}}, {{0.05, 3}, {-0.05, 5}}, {{0.02, 7}, {0, 6}}, {{0.1, 1}}});
  ASSERT_EQ(placed.size(), 3U);
  EXPECT_EQ(placed[0].offsets[1], -0.05);
  EXPECT_EQ(placed[0].offsets[2], 0.02);
  EXPECT_EQ(placed[0].offsets[3], 0.1);
  EXPECT_DOUBLE_EQ(placed[0].score, 13);
  EXPECT_DOUBLE_EQ(placed[1].score, 12);
  EXPECT_EQ(placed[1].offsets[2], 0);
  EXPECT_DOUBLE_EQ(placed[2].score, 11);
}

TEST(PipePlaces, OnePlaceIsNotThatOfTwoPipes) {
  // The best place of the third pipe is that of the second one.
  const auto placed = place({{{0, 0}}, {{0, 9}}, {{-0.4, 9}, {0.03, 4}}, {{0, 5}}});
  ASSERT_FALSE(placed.empty());
  EXPECT_EQ(placed[0].offsets[2], 0.03);
}

TEST(PipePlaces, PipesMayTouchEachOther) {
  const auto placed = place({{{0, 0}}, {{0, 1}}, {{-0.105, 9}, {0, 1}}, {{0, 1}}});
  EXPECT_EQ(placed[0].offsets[2], -0.105);
  const auto deeper = place({{{0, 0}}, {{0, 1}}, {{-0.115, 9}, {0, 1}}, {{0, 1}}});
  EXPECT_EQ(deeper[0].offsets[2], 0);
}

TEST(PipePlaces, PipesDoNotChangeSides) {
  const auto placed = place({{{0, 0}}, {{0.9, 9}, {0, 1}}, {{0, 1}}, {{0.7, 1}}});
  EXPECT_EQ(placed[0].offsets[1], 0);
}

TEST(PipePlaces, APipeThatIsNotSeenIsInNobodysWay) {
  const auto placed = place({{{0, 0}}, {}, {{-0.4, 2}}, {{0, 1}}});
  ASSERT_EQ(placed.size(), 1U);
  EXPECT_EQ(placed[0].offsets[2], -0.4);
  EXPECT_EQ(placed[0].offsets[1], 0);
}

TEST(PipePlaces, WithoutACombinationThereIsNone) {
  EXPECT_TRUE(place({{{0, 0}}, {{-0.3, 1}}, {{0, 1}}, {{0, 1}}}).empty());
}

}  // namespace
}  // namespace pipescout::rack_vision
