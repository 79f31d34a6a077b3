// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

namespace pipescout::navigation {

/// What a tour along rows is joined of. End 2 i and end 2 i + 1 are those of row i.
struct RowEnds {
  std::vector<double> along;  ///< of each row, at least 0
  std::vector<double> joins;  ///< from end to end, symmetric, rows one after the other
};

/// A lower bound of closed tours that drive each row from end to end: least spanning trees with one
/// more edge (1-trees) that contain all rows, with prices on the ends that draw their degrees to 2
/// (Held and Karp, "The traveling-salesman problem and minimum spanning trees", 1970 and 1971).
/// `cost` is that of a tour. At least 2 rows. O(rows^2) for each of some hundred rounds, fewer if
/// `should_stop`.
[[nodiscard]] double bound_by_spanning_trees(const RowEnds& ends, double cost,
                                             const std::function<bool()>& should_stop);

}  // namespace pipescout::navigation
