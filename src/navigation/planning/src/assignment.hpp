// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace pipescout::navigation {

/// The least sum of one element of each row and column of a square matrix, rows one after the other
/// (Kuhn, "The Hungarian method for the assignment problem", 1955). O(size^3).
[[nodiscard]] double least_assignment(const std::vector<double>& costs, std::size_t size);

}  // namespace pipescout::navigation
