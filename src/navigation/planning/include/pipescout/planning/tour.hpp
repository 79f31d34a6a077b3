// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "pipescout/planning/route_planner.hpp"

namespace pipescout::navigation {

/// A row of collectors that a tour must drive along once.
struct TourRow {
  std::uint32_t edge = 0;                 ///< position in RouteGraph::edges()
  std::optional<std::uint32_t> opposite;  ///< may be driven along in place of `edge`
};

/// How a camera at one side of the robot sees rows.
enum class RowSides {
  kOne,     ///< driven along once, in either direction where there is an edge back
  kBoth,    ///< driven along there and back; once where there is no edge back
  kAsGiven  ///< in the direction of the edge: an edge and its opposite are two rows
};

/// Rows of edges; an edge and its opposite count once, but for kAsGiven.
[[nodiscard]] std::vector<TourRow> tour_rows(const RouteGraph& graph,
                                             std::span<const std::uint32_t> edges, RowSides sides);

enum class TourStatus {
  kFound,
  kRowUnreachable,  ///< no way leads there and back with what is open
};

struct Tour {
  TourStatus status = TourStatus::kFound;
  std::vector<std::uint32_t> edges;  ///< from the start along all rows and back to the start
  std::vector<TourRow> unreachable;
  double cost = 0;
  double lower_bound = 0;  ///< no tour costs less
};

/// A closed tour that drives along all rows (the rural postman problem; Corberan and Laporte, "Arc
/// Routing", 2014). Up to 14 rows: the best there is, by dynamic programming; it is its own bound.
/// More: insertion, then 2-opt and Or-opt with the best direction of each row, perturbed again and
/// again until nothing is won or `should_stop`. The lower bound then is the larger of an assignment
/// of the ends of rows to each other (Kuhn, 1955), in which a tour would have to be one piece, and
/// of 1-trees with prices on the ends (Held and Karp, 1971). O(rows^3). Rows out of range throw
/// std::invalid_argument. At most 1000 rows.
[[nodiscard]] Tour plan_tour(RoutePlanner& planner, std::uint32_t start,
                             std::span<const TourRow> rows,
                             const std::function<bool()>& should_stop);

}  // namespace pipescout::navigation
