// SPDX-License-Identifier: Apache-2.0
#include "pipescout/driving/coverage_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "pipescout/validation/check.hpp"

namespace pipescout::navigation {
namespace {

constexpr double kLongestPipe = 1e6;  ///< m
constexpr double kRounding = 1e-9;    ///< cells

}  // namespace

CoverageMap::CoverageMap(double cell, double largest_blur)
    : cell_(cell), largest_blur_(largest_blur) {
  validation::check_within("cell", cell, 0.01, 10);
  validation::check_above("largest_blur", largest_blur, 0, 100);
}

bool CoverageMap::add(const PipeView& view) {
  if (!std::isfinite(view.from + view.to + view.time + view.blur) || view.from < 0 ||
      view.to < view.from || view.to > kLongestPipe || view.blur < 0) {
    return false;
  }
  const auto first = static_cast<std::size_t>(std::ceil(view.from / cell_ - kRounding));
  const auto last = static_cast<std::size_t>(std::floor(view.to / cell_ + kRounding));
  std::vector<Cell>& cells = pipes_[view.pipe];
  if (cells.size() < last) {
    cells.resize(last);
  }
  for (std::size_t i = first; i < last; ++i) {
    Cell& cell = cells[i];
    const bool unseen = cell.time == 0 && !cell.sharp;
    if (unseen || view.blur < cell.blur) {
      cell = {view.blur <= largest_blur_, view.blur, view.temperature, view.time};
    }
  }
  return true;
}

std::vector<CoverageMap::Gap> CoverageMap::gaps(std::int64_t pipe, double from, double to) const {
  std::vector<Gap> result;
  const auto found = pipes_.find(pipe);
  const std::size_t size = found == pipes_.end() ? 0 : found->second.size();
  const auto first = static_cast<std::size_t>(std::max(0.0, std::floor(from / cell_ + kRounding)));
  const auto last = static_cast<std::size_t>(std::max(0.0, std::ceil(to / cell_ - kRounding)));
  for (std::size_t i = first; i < last; ++i) {
    if (i < size && found->second[i].sharp) {
      continue;
    }
    const double begin = std::max(from, static_cast<double>(i) * cell_);
    const double end = std::min(to, static_cast<double>(i + 1) * cell_);
    if (!result.empty() && result.back().to >= begin - kRounding) {
      result.back().to = end;
    } else {
      result.push_back({begin, end});
    }
  }
  return result;
}

double CoverageMap::sharp_percent(std::int64_t pipe, double from, double to) const {
  if (!(to > from)) {
    return 0;
  }
  double missing = 0;
  for (const Gap& gap : gaps(pipe, from, to)) {
    missing += gap.to - gap.from;
  }
  return 100 * (1 - missing / (to - from));
}

}  // namespace pipescout::navigation
