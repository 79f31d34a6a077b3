// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>
#include <vector>

/// One value for each seed, and what is made of them.
namespace pipescout::reproduce {

/// `value`, a member or a function, of each item.
template <class Item, class Function>
std::vector<double> each(const std::vector<Item>& items, Function value) {
  std::vector<double> values;
  values.reserve(items.size());
  for (const Item& item : items) {
    values.push_back(static_cast<double>(std::invoke(value, item)));
  }
  return values;
}

inline double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

/// Of at least one.
inline double mean(const std::vector<double>& values) {
  return sum(values) / static_cast<double>(values.size());
}

/// Of at least one.
inline double largest(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

/// To the decimals that rows show.
inline double rounded(double value) {
  constexpr double kScale = 1e4;
  return std::round(value * kScale) / kScale;
}

/// 0 of nothing.
inline double percent(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace pipescout::reproduce
