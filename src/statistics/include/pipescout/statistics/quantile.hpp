// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace pipescout::statistics {

/// The one of at least one value that lies at `share`, in [0, 1], of the way from the smallest to
/// the largest in their order; between two the smaller. Reorders the values, and copies none. NaN
/// must not be among them.
template <class T>
[[nodiscard]] T quantile_in_place(std::vector<T>& values, double share) {
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

}  // namespace pipescout::statistics
