// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace pipescout::statistics {

/// The middle one of at least one value in their order; of two middle ones the larger. Reorders the
/// values, and copies none. NaN must not be among them.
template <class T>
[[nodiscard]] T median_in_place(std::vector<T>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The same of a copy.
template <class T>
[[nodiscard]] T median(std::vector<T> values) {
  return median_in_place(values);
}

}  // namespace pipescout::statistics
