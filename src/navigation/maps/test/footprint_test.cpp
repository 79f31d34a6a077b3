// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigation_maps/footprint.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include "pipescout/navigation_maps/path.hpp"

namespace pipescout::navigation {
namespace {

OccupancyGrid free_grid(int side, double resolution = 0.1, const Pose2d& origin = {}) {
  return {{.resolution = resolution, .origin = origin, .width = side, .height = side},
          CellState::kFree};
}

TEST(Footprint, RadiiOfARectangle) {
  const Footprint footprint = Footprint::rectangle(0.8, 0.2, 0.6);
  EXPECT_NEAR(footprint.circumscribed_radius(), std::hypot(0.8, 0.3), 1e-12);
  EXPECT_NEAR(footprint.inscribed_radius(), 0.2, 1e-12);
  EXPECT_EQ(footprint.convex_parts().size(), 1U);
}

TEST(Footprint, RefusesWhatIsNoPolygon) {
  EXPECT_THROW(Footprint::rectangle(0.5, -0.5, 1), std::invalid_argument);
  EXPECT_THROW(Footprint::rectangle(0.5, NAN, 1), std::invalid_argument);
  EXPECT_THROW(Footprint::polygon({{0, 0}, {1, 0}}), std::invalid_argument);
  EXPECT_THROW(Footprint::polygon({{0, 0}, {1, 0}, {2, 0}}), std::invalid_argument);
  EXPECT_THROW(Footprint::polygon({{0, 0}, {2, 1}, {2, 0}, {0, 1.5}}), std::invalid_argument);
}

TEST(Footprint, TurnedRectangleSeesTheCornerCellOnly) {
  OccupancyGrid grid = free_grid(100);
  const Footprint footprint = Footprint::rectangle(1, 1, 0.5);
  const Pose2d pose{5, 5, std::numbers::pi / 4};
  EXPECT_FALSE(collides(footprint, grid, pose, UnknownCells::kBlocked));
  // The far corner is at 5 + (1 - 0.25) / sqrt(2) in x with a y that is higher.
  grid.set({56, 46}, CellState::kOccupied);  // outside the turned rectangle, inside its box
  EXPECT_FALSE(collides(footprint, grid, pose, UnknownCells::kBlocked));
  grid.set({56, 56}, CellState::kOccupied);
  EXPECT_TRUE(collides(footprint, grid, pose, UnknownCells::kBlocked));
}

TEST(Footprint, OutsideIsUnknown) {
  const OccupancyGrid grid = free_grid(10);
  const Footprint footprint = Footprint::rectangle(0.2, 0.2, 0.2);
  EXPECT_TRUE(collides(footprint, grid, {0.1, 0.5, 0}, UnknownCells::kBlocked));
  EXPECT_FALSE(collides(footprint, grid, {0.1, 0.5, 0}, UnknownCells::kFree));
  EXPECT_TRUE(collides(footprint, grid, {1e300, 0.5, 0}, UnknownCells::kBlocked));
  EXPECT_TRUE(collides(footprint, grid, {NAN, 0.5, 0}, UnknownCells::kFree));
}

TEST(Footprint, AgreesWithClosestPointOfEachCell) {
  // Each blocked cell as a footprint of its own, tested by separating axes.
  std::mt19937_64 engine(7);
  const auto draw = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(engine() >> 11U) * 0x1p-53;
  };
  const Footprint cell = Footprint::polygon({{0, 0}, {0.1, 0}, {0.1, 0.1}, {0, 0.1}});
  const Footprint angled = Footprint::polygon(
      {{-0.6, -0.3}, {0.7, -0.3}, {0.7, 0.3}, {0.2, 0.3}, {0.2, 0.05}, {-0.1, 0.05}, {-0.6, 0.3}});
  int blocked = 0;
  for (int round = 0; round < 2000; ++round) {
    OccupancyGrid grid = free_grid(40, 0.1, {-1, 2, draw(-3, 3)});
    const Cell at{static_cast<int>(draw(12, 28)), static_cast<int>(draw(12, 28))};
    grid.set(at, CellState::kOccupied);
    const Point2d middle = grid.centre({20, 20});
    const Pose2d pose{middle.x + draw(-0.3, 0.3), middle.y + draw(-0.3, 0.3), draw(-4, 4)};
    const Pose2d corner = compose(grid.geometry().origin, {at.column * 0.1, at.row * 0.1, 0});
    const bool expected = overlap(angled, pose, cell, corner);
    EXPECT_EQ(collides(angled, grid, pose, UnknownCells::kFree), expected) << round;
    blocked += expected ? 1 : 0;
  }
  EXPECT_GT(blocked, 200);
  EXPECT_LT(blocked, 1800);
}

TEST(Footprint, InflatedKeepsTheMargin) {
  const Footprint footprint = Footprint::rectangle(0.8, 0.2, 0.6).inflated(0.1);
  EXPECT_NEAR(footprint.inscribed_radius(), 0.3, 1e-12);
  EXPECT_NEAR(footprint.circumscribed_radius(), std::hypot(0.9, 0.4), 1e-12);
}

/// Of an L, which has two convex parts, and of a rectangle.
TEST(Footprint, ArcsSaidToBeFreeAreFreeAtEachPose) {
  std::mt19937 engine(7);
  const auto draw = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(engine()) / 4294967296.0;
  };
  const std::vector<Footprint> footprints{
      Footprint::rectangle(1.0, 0.4, 0.8),
      Footprint::polygon({{-0.4, -0.4}, {1, -0.4}, {1, 0}, {0.2, 0}, {0.2, 0.6}, {-0.4, 0.6}})};
  int free = 0;
  int collided = 0;
  for (int i = 0; i < 4000; ++i) {
    OccupancyGrid grid({.resolution = 0.1, .origin = {1, -1, 0.3}, .width = 60, .height = 60},
                       CellState::kFree);
    for (int k = 0; k < 12; ++k) {
      grid.set({static_cast<int>(draw(0, 60)), static_cast<int>(draw(0, 60))},
               CellState::kOccupied);
    }
    const Footprint& footprint = footprints[static_cast<std::size_t>(i % 2)];
    const Point2d middle = grid.centre({30, 30});
    const Pose2d pose{middle.x, middle.y, draw(-3, 3)};
    const double curvature = i % 5 == 0 ? 0 : draw(-1, 1);
    const double length = draw(-1, 1);
    bool hit = false;
    for (int part = 0; part <= 100; ++part) {
      hit = hit || collides(footprint, grid, drive_arc(pose, curvature, length * part / 100),
                            UnknownCells::kBlocked);
    }
    const bool may =
        may_collide_along(footprint, grid, pose, curvature, length, UnknownCells::kBlocked);
    EXPECT_TRUE(may || !hit) << i;
    free += may ? 0 : 1;
    collided += hit ? 1 : 0;
  }
  EXPECT_GT(free, 500);
  // No more than one in ten of the others is refused for nothing.
  EXPECT_GT(collided, 0.9 * (4000 - free));
}

}  // namespace
}  // namespace pipescout::navigation
