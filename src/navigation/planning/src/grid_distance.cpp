// SPDX-License-Identifier: Apache-2.0
#include "grid_distance.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>

namespace pipescout::navigation {
namespace {

constexpr std::int32_t kUnseen = std::numeric_limits<std::int32_t>::max();
constexpr std::int32_t kSide = 10;
constexpr std::int32_t kDiagonal = 14;
/// By how much distances in these steps may overstate a length.
const double kOverstated = std::sqrt(1 + 0.4 * 0.4);
// A cell is closed by its centre only if the disc reaches its corners: half a diagonal of it.
constexpr double kCellPerDisc = 0.8;
// A step changes cost plus estimate by twice its cost at most.
constexpr std::size_t kBuckets = 32;

std::int32_t steps_between(int columns, int rows) {
  const int a = std::abs(columns);
  const int b = std::abs(rows);
  return kSide * std::max(a, b) + (kDiagonal - kSide) * std::min(a, b);
}

}  // namespace

GridDistance::GridDistance(const OccupancyGrid& grid, const DistanceField& field,
                           double disc_radius, Use use)
    : grid_(grid),
      field_(field),
      disc_radius_(std::min(disc_radius, field.largest())),
      needed_(disc_radius_ -
              (use == Use::kProof ? grid.resolution() * std::numbers::sqrt2 / 2 : 0)),
      scale_(std::max(1, static_cast<int>(kCellPerDisc * disc_radius_ / grid.resolution()))),
      cell_(scale_ * grid.resolution()),
      columns_((grid.width() + scale_ - 1) / scale_),
      rows_((grid.height() + scale_ - 1) / scale_),
      open_(static_cast<std::size_t>(columns_ + 2) * static_cast<std::size_t>(rows_ + 2), 0),
      reached_(static_cast<std::size_t>(columns_ + 1) * static_cast<std::size_t>(rows_ + 1),
               {kUnseen, 0}),
      buckets_(kBuckets) {
  forget({{0, 0}, {grid.width() - 1, grid.height() - 1}});
}

std::int8_t& GridDistance::state_of_cell(int column, int row) {
  return open_[static_cast<std::size_t>(row + 1) * static_cast<std::size_t>(columns_ + 2) +
               static_cast<std::size_t>(column + 1)];
}

void GridDistance::forget(const CellBox& box) {
  const int first = std::max(0, box.low.column / scale_);
  const int last = std::min(columns_ - 1, box.high.column / scale_);
  for (int row = std::max(0, box.low.row / scale_);
       row <= std::min(rows_ - 1, box.high.row / scale_); ++row) {
    std::fill_n(&state_of_cell(first, row), std::max(0, last - first + 1), std::int8_t{-1});
  }
}

GridDistance::Corner GridDistance::nearest(const Point2d& p_grid) const {
  // Of the cell that the position is in.
  const auto along = [&](double value, int cells) {
    return static_cast<int>(std::lround(std::clamp(value / scale_, 0.0, cells + 0.0)));
  };
  return {along(p_grid.x, columns_), along(p_grid.y, rows_)};
}

void GridDistance::set_root(const Point2d& root, const Point2d& robot) {
  for (auto& bucket : buckets_) {
    bucket.clear();
  }
  if (++query_ == 0) {
    std::fill(reached_.begin(), reached_.end(), Reached{kUnseen, 0});
    query_ = 1;
  }
  const Point2d p_root = grid_.to_grid(root);
  root_ = nearest(p_root);
  robot_ = nearest(grid_.to_grid(robot));
  root_off_ =
      std::hypot(p_root.x - root_.x * scale_, p_root.y - root_.y * scale_) * grid_.resolution();
  level_ = steps_between(root_.x - robot_.x, root_.y - robot_.y);
  reached_[index(root_)] = {0, query_};
  buckets_[static_cast<std::size_t>(level_) % kBuckets].push_back(root_);
}

bool GridDistance::is_open(int column, int row) {
  std::int8_t& open = state_of_cell(column, row);
  if (open < 0) {
    open = 0;
    const int last_row = std::min((row + 1) * scale_, grid_.height());
    const int last_column = std::min((column + 1) * scale_, grid_.width());
    for (int y = row * scale_; y < last_row && open == 0; ++y) {
      for (int x = column * scale_; x < last_column && open == 0; ++x) {
        open = field_.at({x, y}) >= needed_ ? 1 : 0;
      }
    }
  }
  return open == 1;
}

void GridDistance::step(Corner from, int x, int y, std::int32_t cost) {
  const Corner to{from.x + x, from.y + y};
  Reached& reached = reached_[index(to)];
  if (reached.query != query_ || cost < reached.cost) {
    reached = {cost, query_};
    const std::int32_t estimate = cost + steps_between(to.x - robot_.x, to.y - robot_.y);
    buckets_[static_cast<std::size_t>(estimate) % kBuckets].push_back(to);
  }
}

void GridDistance::take_up(Corner corner) {
  const std::int32_t cost = reached_[index(corner)].cost;
  // The four cells around it.
  const bool north_east = is_open(corner.x, corner.y);
  const bool north_west = is_open(corner.x - 1, corner.y);
  const bool south_west = is_open(corner.x - 1, corner.y - 1);
  const bool south_east = is_open(corner.x, corner.y - 1);
  const auto try_step = [&](bool open, int x, int y, std::int32_t length) {
    if (open) {
      step(corner, x, y, cost + length);
    }
  };
  try_step(north_east || south_east, 1, 0, kSide);
  try_step(north_west || south_west, -1, 0, kSide);
  try_step(north_east || north_west, 0, 1, kSide);
  try_step(south_east || south_west, 0, -1, kSide);
  try_step(north_east, 1, 1, kDiagonal);
  try_step(north_west, -1, 1, kDiagonal);
  try_step(south_west, -1, -1, kDiagonal);
  try_step(south_east, 1, -1, kDiagonal);
}

bool GridDistance::reach(const std::function<bool()>& should_stop, bool& stopped) {
  constexpr int kCornersPerQuestion = 2048;
  // Detours up to this are known exactly.
  constexpr double kDetourShare = 0.1;
  constexpr double kDetour = 3;  // m
  stopped = false;
  const Reached& robot = reached_[index(robot_)];
  std::int32_t last = kUnseen;
  int since = 0;
  int empty = 0;
  for (; level_ <= last && empty < static_cast<int>(kBuckets); ++level_) {
    auto& bucket = buckets_[static_cast<std::size_t>(level_) % kBuckets];
    empty = bucket.empty() ? empty + 1 : 0;
    while (!bucket.empty()) {
      const Corner corner = bucket.back();
      bucket.pop_back();
      if (reached_[index(corner)].cost + steps_between(corner.x - robot_.x, corner.y - robot_.y) !=
          level_) {
        continue;  // a shorter way there was found since
      }
      take_up(corner);
      if (++since == kCornersPerQuestion) {
        since = 0;
        if (should_stop()) {
          stopped = true;
          return false;
        }
      }
    }
    if (last == kUnseen && robot.query == query_ && robot.cost <= level_) {
      last = level_ + static_cast<std::int32_t>(kDetourShare * level_ + kDetour / cell_ * kSide);
    }
  }
  return robot.query == query_;
}

double GridDistance::bound_in_grid(const Point2d& p_grid) const {
  const Corner corner = nearest(p_grid);
  const std::int32_t to_robot = steps_between(corner.x - robot_.x, corner.y - robot_.y);
  const std::int32_t to_root = steps_between(corner.x - root_.x, corner.y - root_.y);
  const Reached& reached = reached_[index(corner)];
  std::int32_t cost = std::max(to_root, level_ - to_robot);
  if (reached.query == query_ && reached.cost + to_robot < level_) {
    cost = reached.cost;
  }
  const double x = p_grid.x - corner.x * scale_;
  const double y = p_grid.y - corner.y * scale_;
  const double off = std::sqrt(x * x + y * y);
  return std::max(0.0, cost * (cell_ / kSide / kOverstated) - off * grid_.resolution() - root_off_);
}

}  // namespace pipescout::navigation
