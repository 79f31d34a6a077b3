// SPDX-License-Identifier: Apache-2.0
#include "pipescout/driving/local_costmap.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "pipescout/validation/check.hpp"

namespace pipescout::navigation {
namespace {

long modulo(long value, long size) {
  const long rest = value % size;
  return rest < 0 ? rest + size : rest;
}

}  // namespace

void LocalCostmapParameters::validate() const {
  validation::check_within("resolution", resolution, 0.02, 1);
  validation::check_within("size", size, 20, 2000);
  validation::check_above("forget_after", forget_after, 0, 3600);
  validation::check_within("clearing_scans", clearing_scans, 1, 100);
}

LocalCostmap::LocalCostmap(const LocalCostmapParameters& parameters) : parameters_(parameters) {
  parameters_.validate();
  cells_.resize(static_cast<std::size_t>(parameters_.size) *
                static_cast<std::size_t>(parameters_.size));
}

void LocalCostmap::clear() {
  std::fill(cells_.begin(), cells_.end(), CellValue{});
  placed_ = false;
}

LocalCostmap::CellValue& LocalCostmap::cell(long column, long row) {
  return cells_[static_cast<std::size_t>(modulo(row, parameters_.size) * parameters_.size +
                                         modulo(column, parameters_.size))];
}

const LocalCostmap::CellValue& LocalCostmap::cell(long column, long row) const {
  return cells_[static_cast<std::size_t>(modulo(row, parameters_.size) * parameters_.size +
                                         modulo(column, parameters_.size))];
}

bool LocalCostmap::covers(long column, long row) const {
  return column >= first_column_ && row >= first_row_ &&
         column < first_column_ + parameters_.size && row < first_row_ + parameters_.size;
}

void LocalCostmap::roll_to(const Point2d& centre) {
  const long size = parameters_.size;
  const long column = std::lround(centre.x / parameters_.resolution) - size / 2;
  const long row = std::lround(centre.y / parameters_.resolution) - size / 2;
  if (!placed_ || std::abs(column - first_column_) >= size || std::abs(row - first_row_) >= size) {
    std::fill(cells_.begin(), cells_.end(), CellValue{});
    placed_ = true;
  } else {
    const auto clear_column = [&](long c) {
      for (long r = 0; r < size; ++r) {
        cell(c, r) = {};
      }
    };
    const auto clear_row = [&](long r) {
      for (long c = 0; c < size; ++c) {
        cell(c, r) = {};
      }
    };
    for (long c = first_column_; c < column; ++c) {
      clear_column(c);
    }
    for (long c = column + size; c < first_column_ + size; ++c) {
      clear_column(c);
    }
    for (long r = first_row_; r < row; ++r) {
      clear_row(r);
    }
    for (long r = row + size; r < first_row_ + size; ++r) {
      clear_row(r);
    }
  }
  first_column_ = column;
  first_row_ = row;
}

void LocalCostmap::miss(CellValue& cell, double time) const {
  // Several beams of one scan pass the same cell.
  if (cell.state != State::kOccupied || cell.missed_at == time) {
    return;
  }
  cell.missed_at = time;
  if (++cell.missed >= parameters_.clearing_scans) {
    cell = {.state = State::kFree, .seen = time};
  }
}

void LocalCostmap::add(const ScanView& scan, const Pose2d& T_map_lidar) {
  roll_to(T_map_lidar.position());
  const double step = parameters_.resolution;
  const double half = 0.5 * parameters_.size * step;
  const auto each_beam = [&](auto work) {
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      const auto range = static_cast<double>(scan.ranges[i]);
      if (std::isnan(range) || range < scan.range_min) {
        continue;
      }
      const double angle =
          T_map_lidar.heading + scan.angle_min + static_cast<double>(i) * scan.angle_increment;
      work(range, std::cos(angle) / step, std::sin(angle) / step);
    }
  };
  const double x0 = T_map_lidar.x / step;
  const double y0 = T_map_lidar.y / step;
  each_beam([&](double range, double dx, double dy) {
    const bool echo = range < scan.range_max;
    const double end = std::min(echo ? range - step : scan.range_max, half);
    for (double r = 0; r < end; r += step) {
      const auto column = static_cast<long>(std::floor(x0 + r * dx));
      const auto row = static_cast<long>(std::floor(y0 + r * dy));
      if (!covers(column, row)) {
        continue;
      }
      if (echo) {
        cell(column, row) = {.state = State::kFree, .seen = scan.time};
      } else {
        miss(cell(column, row), scan.time);
      }
    }
  });
  each_beam([&](double range, double dx, double dy) {
    const auto column = static_cast<long>(std::floor(x0 + range * dx));
    const auto row = static_cast<long>(std::floor(y0 + range * dy));
    if (range < scan.range_max && covers(column, row)) {
      cell(column, row) = {.state = State::kOccupied, .seen = scan.time};
    }
  });
}

std::optional<Point2d> LocalCostmap::origin() const {
  if (!placed_) {
    return std::nullopt;
  }
  return Point2d{static_cast<double>(first_column_) * parameters_.resolution,
                 static_cast<double>(first_row_) * parameters_.resolution};
}

LocalCostmap::State LocalCostmap::at(int column, int row) const {
  return placed_ && covers(first_column_ + column, first_row_ + row)
             ? cell(first_column_ + column, first_row_ + row).state
             : State::kUnknown;
}

bool LocalCostmap::occupied_near(const Point2d& centre, double radius, double now,
                                 std::vector<Point2d>& cells) const {
  const double step = parameters_.resolution;
  const auto low = [&](double v, long first) {
    return std::max(first, static_cast<long>(std::floor((v - radius) / step)));
  };
  const auto high = [&](double v, long first) {
    return std::min(first + parameters_.size, static_cast<long>(std::ceil((v + radius) / step)));
  };
  for (long row = low(centre.y, first_row_); row < high(centre.y, first_row_); ++row) {
    for (long column = low(centre.x, first_column_); column < high(centre.x, first_column_);
         ++column) {
      const CellValue& value = cell(column, row);
      if (value.state != State::kOccupied || now - value.seen > parameters_.forget_after) {
        continue;
      }
      const Point2d point{(static_cast<double>(column) + 0.5) * step,
                          (static_cast<double>(row) + 0.5) * step};
      if (distance(point, centre) > radius) {
        continue;
      }
      if (cells.size() == cells.capacity()) {
        return false;
      }
      cells.push_back(point);
    }
  }
  return true;
}

}  // namespace pipescout::navigation
