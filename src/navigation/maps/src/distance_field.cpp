// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigation_maps/distance_field.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/validation/check.hpp"

namespace pipescout::navigation {
namespace {

constexpr double kLargestField = 100;  // m
constexpr double kLargestReach = 200;  // cells

/// From the centre of a cell to the nearest edge of one that is `cells` away along an axis.
float gap(int cells) {
  constexpr float kHalf = 0.5F;
  return cells == 0 ? 0 : static_cast<float>(cells) - kHalf;
}

bool blocks(CellState state, UnknownCells unknown) {
  return state == CellState::kOccupied ||
         (state == CellState::kUnknown && unknown == UnknownCells::kBlocked);
}

}  // namespace

DistanceField::DistanceField(const OccupancyGrid& grid, UnknownCells unknown, double largest)
    : geometry_(grid.geometry()), unknown_(unknown), largest_(largest) {
  validation::check_within("largest", largest, geometry_.resolution, kLargestField);
  validation::check_within("largest / resolution", largest / geometry_.resolution, 1,
                           kLargestReach);
  reach_ = static_cast<int>(std::ceil(largest / geometry_.resolution)) + 1;
  cells_.resize(grid.cells().size());
  compute(grid, {{0, 0}, {geometry_.width - 1, geometry_.height - 1}});
}

double DistanceField::at(Cell cell) const {
  if (cell.column < 0 || cell.row < 0 || cell.column >= geometry_.width ||
      cell.row >= geometry_.height) {
    return unknown_ == UnknownCells::kBlocked ? 0 : largest_;
  }
  const auto index =
      static_cast<std::size_t>(cell.row) * static_cast<std::size_t>(geometry_.width) +
      static_cast<std::size_t>(cell.column);
  return std::min(largest_, static_cast<double>(cells_[index]) * geometry_.resolution);
}

DistanceField::Bounds DistanceField::bounds(const Point2d& p_grid) const {
  constexpr double kHalf = 0.5;
  const double column = std::floor(std::clamp(p_grid.x, -1.0, geometry_.width + 0.0));
  const double row = std::floor(std::clamp(p_grid.y, -1.0, geometry_.height + 0.0));
  const double of_centre = at({static_cast<int>(column), static_cast<int>(row)});
  const double x = p_grid.x - column - kHalf;
  const double y = p_grid.y - row - kHalf;
  const double off = std::sqrt(x * x + y * y) * geometry_.resolution;
  return {of_centre - off, of_centre + off};
}

void DistanceField::update(const OccupancyGrid& grid, const CellBox& box) {
  if (!(grid.geometry() == geometry_)) {
    validation::refuse("grid: its geometry is not the one that the distance field was made for");
  }
  compute(grid, {{std::max(0, box.low.column - reach_), std::max(0, box.low.row - reach_)},
                 {std::min(geometry_.width - 1, box.high.column + reach_),
                  std::min(geometry_.height - 1, box.high.row + reach_)}});
}

void DistanceField::compute(const OccupancyGrid& grid, const CellBox& box) {
  const int first = std::max(0, box.low.column - reach_);
  const int last = std::min(geometry_.width - 1, box.high.column + reach_);
  if (first > last || box.low.row > box.high.row) {
    return;
  }
  const auto columns = static_cast<std::size_t>(last - first + 1);
  const bool outside_blocks = unknown_ == UnknownCells::kBlocked;
  const int none = reach_ + 1;
  // Distances along the columns, in cells: downwards first, then upwards.
  const int bottom = std::max(0, box.low.row - reach_);
  const int top = std::min(geometry_.height - 1, box.high.row + reach_);
  const auto rows = static_cast<std::size_t>(top - bottom + 1);
  std::vector<std::int16_t> vertical(rows * columns);
  std::vector<int> since(columns);
  const auto sweep = [&](bool upwards) {
    const int edge = upwards ? bottom == 0 : top == geometry_.height - 1;
    std::fill(since.begin(), since.end(), edge != 0 && outside_blocks ? 0 : none);
    for (std::size_t i = 0; i < rows; ++i) {
      const std::size_t row = upwards ? i : rows - 1 - i;
      const std::size_t start = grid.index({first, bottom + static_cast<int>(row)});
      for (std::size_t x = 0; x < columns; ++x) {
        since[x] = blocks(grid.cells()[start + x], unknown_) ? 0 : std::min(none, since[x] + 1);
        std::int16_t& value = vertical[row * columns + x];
        value = static_cast<std::int16_t>(upwards ? since[x] : std::min<int>(value, since[x]));
      }
    }
  };
  sweep(true);
  sweep(false);
  // Then along the rows: the smallest of all offsets, as vectors.
  const auto reach = static_cast<std::size_t>(reach_);
  const float far = gap(none) * gap(none);
  std::vector<float> padded(columns + 2 * reach);
  std::vector<float> best(columns);
  for (int row = box.low.row; row <= box.high.row; ++row) {
    const std::size_t start = static_cast<std::size_t>(row - bottom) * columns;
    std::fill(padded.begin(), padded.end(), far);
    for (std::size_t x = 0; x < columns; ++x) {
      const float squared = gap(vertical[start + x]);
      padded[reach + x] = squared * squared;
    }
    if (outside_blocks) {
      if (first == 0) {
        std::fill_n(padded.begin(), reach, 0.0F);
      }
      if (last == geometry_.width - 1) {
        std::fill_n(padded.end() - reach_, reach, 0.0F);
      }
    }
    std::copy_n(padded.begin() + reach_, columns, best.begin());
    for (std::size_t offset = 1; offset <= reach; ++offset) {
      const float along = gap(static_cast<int>(offset)) * gap(static_cast<int>(offset));
      const float* left = padded.data() + reach - offset;
      const float* right = padded.data() + reach + offset;
      for (std::size_t x = 0; x < columns; ++x) {
        const float nearer = left[x] < right[x] ? left[x] : right[x];
        best[x] = std::min(best[x], nearer + along);
      }
    }
    for (int column = box.low.column; column <= box.high.column; ++column) {
      cells_[grid.index({column, row})] = std::sqrt(best[static_cast<std::size_t>(column - first)]);
    }
  }
}

}  // namespace pipescout::navigation
