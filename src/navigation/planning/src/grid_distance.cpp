// SPDX-License-Identifier: Apache-2.0
#include "grid_distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace pipescout::navigation {
namespace {

constexpr std::int32_t kUnseen = std::numeric_limits<std::int32_t>::max();
constexpr std::int32_t kStraight = 10;
constexpr std::int32_t kDiagonal = 14;
// Steps of 10 and 14 in 8 directions overstate a straight line by at most sqrt(1 + 0.4^2).
const double kOverstated = std::sqrt(1 + 0.4 * 0.4);
// A cell is closed by its centre only if the disc reaches its corners: half a diagonal of it.
constexpr double kCellPerDisc = 0.8;

}  // namespace

GridDistance::GridDistance(const OccupancyGrid& grid, const DistanceField& field,
                           double disc_radius)
    : grid_(grid), field_(field), disc_radius_(disc_radius) {
  scale_ = std::max(1, static_cast<int>(kCellPerDisc * disc_radius / grid.resolution()));
  width_ = (grid.width() + scale_ - 1) / scale_;
  height_ = (grid.height() + scale_ - 1) / scale_;
  buckets_.resize(kDiagonal + 1);
  costs_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  forget();
}

void GridDistance::forget() {
  open_.assign(costs_.size(), -1);
}

std::int64_t GridDistance::cell_of(const Point2d& position) const {
  const Point2d p = grid_.to_grid(position);
  const auto column = static_cast<int>(std::clamp(p.x / scale_, 0.0, width_ - 1.0));
  const auto row = static_cast<int>(std::clamp(p.y / scale_, 0.0, height_ - 1.0));
  return static_cast<std::int64_t>(row) * width_ + column;
}

void GridDistance::set_root(const Point2d& root) {
  std::fill(costs_.begin(), costs_.end(), kUnseen);
  for (auto& bucket : buckets_) {
    bucket.clear();
  }
  level_ = 0;
  exhausted_ = false;
  const std::int64_t cell = cell_of(root);
  costs_[static_cast<std::size_t>(cell)] = 0;
  buckets_[0].push_back(cell);
}

bool GridDistance::is_open(int column, int row) {
  std::int8_t& open = open_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                            static_cast<std::size_t>(column)];
  if (open < 0) {
    constexpr double kHalf = 0.5;
    const Point2d centre{(column + kHalf) * scale_, (row + kHalf) * scale_};
    const double corner = scale_ * grid_.resolution() * std::numbers::sqrt2 / 2;
    open = field_.bounds(centre).high + corner >= disc_radius_ ? 1 : 0;
  }
  return open == 1;
}

bool GridDistance::reach(const Point2d& position, const std::function<bool()>& should_stop,
                         bool& stopped) {
  constexpr std::array<std::array<int, 2>, 8> kNeighbours{
      {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}}};
  constexpr int kCellsPerQuestion = 4096;
  stopped = false;
  const auto target = static_cast<std::size_t>(cell_of(position));
  int since = 0;
  int empty = 0;
  while (!exhausted_ && costs_[target] > level_) {
    auto& bucket = buckets_[static_cast<std::size_t>(level_) % buckets_.size()];
    while (!bucket.empty()) {
      const std::int64_t cell = bucket.back();
      bucket.pop_back();
      if (costs_[static_cast<std::size_t>(cell)] != level_) {
        continue;
      }
      const int column = static_cast<int>(cell % width_);
      const int row = static_cast<int>(cell / width_);
      for (const auto& step : kNeighbours) {
        const int x = column + step[0];
        const int y = row + step[1];
        if (x < 0 || y < 0 || x >= width_ || y >= height_ || !is_open(x, y)) {
          continue;
        }
        const std::int32_t cost = level_ + (step[0] != 0 && step[1] != 0 ? kDiagonal : kStraight);
        const std::int64_t next = static_cast<std::int64_t>(y) * width_ + x;
        if (cost < costs_[static_cast<std::size_t>(next)]) {
          costs_[static_cast<std::size_t>(next)] = cost;
          buckets_[static_cast<std::size_t>(cost) % buckets_.size()].push_back(next);
        }
      }
      empty = 0;
      if (++since == kCellsPerQuestion) {
        since = 0;
        if (should_stop()) {
          bucket.push_back(cell);
          stopped = true;
          return false;
        }
      }
    }
    ++level_;
    exhausted_ = ++empty > kDiagonal + 1;
  }
  return costs_[target] != kUnseen;
}

double GridDistance::bound(const Point2d& position) const {
  const std::int32_t cost = std::min(costs_[static_cast<std::size_t>(cell_of(position))], level_);
  const double cell = scale_ * grid_.resolution();
  // The positions are not the centres of their cells: two half diagonals.
  return std::max(0.0, (cost * cell / kStraight) / kOverstated - cell * std::numbers::sqrt2);
}

}  // namespace pipescout::navigation
