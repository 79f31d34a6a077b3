// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigation_maps/distance_field.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace pipescout::navigation {
namespace {

OccupancyGrid random_grid(std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  OccupancyGrid grid({.resolution = 0.5, .width = 37, .height = 29}, CellState::kFree);
  for (int i = 0; i < 12; ++i) {
    grid.set({static_cast<int>(engine() % 37), static_cast<int>(engine() % 29)},
             CellState::kOccupied);
  }
  return grid;
}

double brute_force(const OccupancyGrid& grid, Cell at, double largest) {
  double best = largest;
  for (int row = 0; row < grid.height(); ++row) {
    for (int column = 0; column < grid.width(); ++column) {
      if (grid.at({column, row}) == CellState::kOccupied) {
        const double x = std::max(0.0, std::abs(column - at.column) - 0.5);
        const double y = std::max(0.0, std::abs(row - at.row) - 0.5);
        best = std::min(best, std::hypot(x, y) * grid.resolution());
      }
    }
  }
  return best;
}

TEST(DistanceField, EqualsBruteForceAlsoAfterAnUpdate) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    OccupancyGrid grid = random_grid(seed);
    DistanceField field(grid, UnknownCells::kFree, 4);
    for (const bool updated : {false, true}) {
      if (updated) {
        grid.set({20, 10}, CellState::kOccupied);
        grid.set({21, 10}, CellState::kFree);
        field.update(grid, {{20, 10}, {21, 10}});
      }
      for (int row = 0; row < grid.height(); ++row) {
        for (int column = 0; column < grid.width(); ++column) {
          ASSERT_NEAR(field.at({column, row}), brute_force(grid, {column, row}, 4), 1e-5)
              << seed << ": " << column << ", " << row;
        }
      }
    }
  }
}

TEST(DistanceField, TheEdgeOfTheGridBlocksWhereUnknownDoes) {
  const OccupancyGrid grid({.resolution = 0.5, .width = 20, .height = 20}, CellState::kFree);
  const DistanceField field(grid, UnknownCells::kBlocked, 4);
  EXPECT_NEAR(field.at({0, 10}), 0.25, 1e-6);
  EXPECT_NEAR(field.at({10, 17}), 1.25, 1e-6);
  EXPECT_EQ(field.at({-1, 10}), 0);
}

}  // namespace
}  // namespace pipescout::navigation
