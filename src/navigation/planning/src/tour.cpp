// SPDX-License-Identifier: Apache-2.0
#include "pipescout/planning/tour.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <random>

#include "assignment.hpp"
#include "pipescout/validation/check.hpp"
#include "tour_bound.hpp"

namespace pipescout::navigation {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Stands for what must not be chosen: the sum of an assignment must stay finite.
constexpr double kForbidden = 1e12;
constexpr std::size_t kMostRows = 1000;

/// Rows with the start as row 0, and what it costs to come from one to another.
class Problem {
 public:
  Problem(RoutePlanner& planner, std::uint32_t start, std::span<const TourRow> rows) {
    ends_.push_back({{{start, start}, {start, start}}});
    cost_of_row_.push_back({0, 0});
    for (const TourRow& row : rows) {
      const auto& edges = planner.graph().edges();
      const std::uint32_t back = row.opposite.value_or(row.edge);
      const double there = planner.cost(row.edge);  // refuses positions out of range
      const double back_cost = planner.cost(back);
      ends_.push_back(
          {{{edges[row.edge].from, edges[row.edge].to}, {edges[back].from, edges[back].to}}});
      cost_of_row_.push_back({there, back_cost});
    }
    std::map<std::uint32_t, std::vector<double>> from;
    for (const auto& row : ends_) {
      for (const auto& way : row) {
        from.try_emplace(way[1]);
      }
    }
    for (auto& [node, costs] : from) {
      costs = planner.costs_from(node);
    }
    costs_.resize(4 * count() * count());
    for (std::size_t a = 0; a < 2 * count(); ++a) {
      const auto& costs = from.at(ends_[a / 2][a % 2][1]);
      for (std::size_t b = 0; b < 2 * count(); ++b) {
        costs_[a * 2 * count() + b] = costs[ends_[b / 2][b % 2][0]];
      }
    }
  }

  [[nodiscard]] std::size_t count() const { return ends_.size(); }
  /// From the end of row a, driven in direction `in_a`, to the start of row b.
  [[nodiscard]] double between(std::size_t a, std::size_t in_a, std::size_t b,
                               std::size_t in_b) const {
    return costs_[(2 * a + in_a) * 2 * count() + 2 * b + in_b];
  }
  [[nodiscard]] double along(std::size_t row, std::size_t direction) const {
    return cost_of_row_[row][direction];
  }
  [[nodiscard]] std::uint32_t node(std::size_t row, std::size_t direction, std::size_t end) const {
    return ends_[row][direction][end];
  }
  [[nodiscard]] bool is_reachable(std::size_t row) const {
    for (std::size_t direction = 0; direction < 2; ++direction) {
      if (between(0, 0, row, direction) + along(row, direction) + between(row, direction, 0, 0) <
          kInfinity) {
        return true;
      }
    }
    return false;
  }

 private:
  std::vector<std::array<std::array<std::uint32_t, 2>, 2>> ends_;  ///< row, direction, end
  std::vector<std::array<double, 2>> cost_of_row_;
  std::vector<double> costs_;
};

using Order = std::vector<std::size_t>;

/// The cost of an order, which begins with row 0, with the best directions.
double cost_of(const Problem& problem, const Order& order, std::vector<std::size_t>* directions) {
  std::array<double, 2> best{0, kInfinity};
  std::vector<std::array<std::size_t, 2>> came_from(directions != nullptr ? order.size() : 0);
  for (std::size_t i = 1; i < order.size(); ++i) {
    std::array<double, 2> next{kInfinity, kInfinity};
    for (std::size_t to = 0; to < 2; ++to) {
      for (std::size_t from = 0; from < 2; ++from) {
        const double cost = best[from] + problem.between(order[i - 1], from, order[i], to) +
                            problem.along(order[i], to);
        if (cost < next[to]) {
          next[to] = cost;
          if (directions != nullptr) {
            came_from[i][to] = from;
          }
        }
      }
    }
    best = next;
  }
  for (std::size_t from = 0; from < 2; ++from) {
    best[from] += problem.between(order.back(), from, order.front(), 0);
  }
  const std::size_t last = best[0] <= best[1] ? 0 : 1;
  if (directions != nullptr) {
    directions->assign(order.size(), 0);
    std::size_t direction = last;
    for (std::size_t i = order.size() - 1; i > 0; --i) {
      (*directions)[i] = direction;
      direction = came_from[i][direction];
    }
  }
  return best[last];
}

/// Each row where it costs least.
Order inserted(const Problem& problem) {
  Order order{0};
  for (std::size_t row = 1; row < problem.count(); ++row) {
    double least = kInfinity;
    std::size_t place = order.size();
    for (std::size_t i = 1; i <= order.size(); ++i) {
      Order tried = order;
      tried.insert(tried.begin() + static_cast<std::ptrdiff_t>(i), row);
      const double cost = cost_of(problem, tried, nullptr);
      if (cost < least) {
        least = cost;
        place = i;
      }
    }
    order.insert(order.begin() + static_cast<std::ptrdiff_t>(place), row);
  }
  return order;
}

/// The best order of few rows by dynamic programming over sets of rows (Held and Karp, "A dynamic
/// programming approach to sequencing problems", 1962); nothing for too many rows, or when told to
/// stop.
std::optional<Order> best_of_all(const Problem& problem, const std::function<bool()>& should_stop) {
  constexpr std::size_t kMostExact = 14;
  const std::size_t rows = problem.count() - 1;
  if (rows == 0 || rows > kMostExact) {
    return std::nullopt;
  }
  // A way is row and direction: 2 (row - 1) + direction. What it costs to have driven a set of
  // rows, with that way last.
  const std::size_t ways = 2 * rows;
  const std::size_t sets = std::size_t{1} << rows;
  std::vector<double> costs(sets * ways, kInfinity);
  std::vector<std::uint8_t> before(sets * ways, 0);
  for (std::size_t set = 1; set < sets; ++set) {
    if (should_stop()) {
      return std::nullopt;
    }
    for (std::size_t way = 0; way < ways; ++way) {
      const std::size_t row = way / 2;
      if ((set >> row & 1U) == 0) {
        continue;
      }
      const std::size_t rest = set & ~(std::size_t{1} << row);
      double& least = costs[set * ways + way];
      if (rest == 0) {
        least = problem.between(0, 0, row + 1, way % 2);
      }
      for (std::size_t last = 0; last < ways && rest != 0; ++last) {
        const double cost =
            costs[rest * ways + last] + problem.between(last / 2 + 1, last % 2, row + 1, way % 2);
        if (cost < least) {
          least = cost;
          before[set * ways + way] = static_cast<std::uint8_t>(last);
        }
      }
      least += problem.along(row + 1, way % 2);
    }
  }
  std::size_t set = sets - 1;
  std::size_t last = 0;
  const auto closed = [&](std::size_t way) {
    return costs[set * ways + way] + problem.between(way / 2 + 1, way % 2, 0, 0);
  };
  for (std::size_t way = 1; way < ways; ++way) {
    last = closed(way) < closed(last) ? way : last;
  }
  Order order;
  while (set != 0) {
    order.push_back(last / 2 + 1);
    const std::size_t next = before[set * ways + last];
    set &= ~(std::size_t{1} << (last / 2));
    last = next;
  }
  order.push_back(0);
  std::reverse(order.begin(), order.end());
  return order;
}

constexpr double kNoGain = 1e-9;

/// Stretches turned round, and moved elsewhere, as long as that helps.
void improve(const Problem& problem, Order& order, double& cost,
             const std::function<bool()>& should_stop) {
  constexpr std::size_t kLongestMoved = 3;
  const auto try_order = [&](Order tried) {
    const double other = cost_of(problem, tried, nullptr);
    if (other < cost - kNoGain) {
      order = std::move(tried);
      cost = other;
      return true;
    }
    return false;
  };
  for (bool better = true; better && !should_stop();) {
    better = false;
    for (std::size_t i = 1; i < order.size() && !should_stop(); ++i) {
      for (std::size_t j = i + 1; j < order.size(); ++j) {
        Order tried = order;
        std::reverse(tried.begin() + static_cast<std::ptrdiff_t>(i),
                     tried.begin() + static_cast<std::ptrdiff_t>(j + 1));
        better = try_order(std::move(tried)) || better;
      }
      for (std::size_t length = 1; length <= kLongestMoved && i + length <= order.size();
           ++length) {
        for (std::size_t to = 1; to + length <= order.size(); ++to) {
          Order tried = order;
          const auto first = tried.begin() + static_cast<std::ptrdiff_t>(i);
          const Order moved(first, first + static_cast<std::ptrdiff_t>(length));
          tried.erase(first, first + static_cast<std::ptrdiff_t>(length));
          tried.insert(tried.begin() + static_cast<std::ptrdiff_t>(to), moved.begin(), moved.end());
          better = try_order(std::move(tried)) || better;
        }
      }
    }
  }
}

/// The four stretches between three drawn places, in another order (Martin, Otto and Felten, 1991).
Order perturbed(const Order& order, std::mt19937_64& engine) {
  std::array<std::size_t, 3> cuts{};
  for (std::size_t& place : cuts) {
    place = 1 + engine() % (order.size() - 1);
  }
  std::sort(cuts.begin(), cuts.end());
  const auto at = [&](std::size_t place) {
    return order.begin() + static_cast<std::ptrdiff_t>(place);
  };
  Order result(order.begin(), at(cuts[0]));
  result.insert(result.end(), at(cuts[1]), at(cuts[2]));
  result.insert(result.end(), at(cuts[0]), at(cuts[1]));
  result.insert(result.end(), at(cuts[2]), order.end());
  return result;
}

/// Each row is left once and entered once.
double bound_of_rows(const Problem& problem) {
  const std::size_t count = problem.count();
  std::vector<double> costs(count * count, kForbidden);
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = 0; b < count; ++b) {
      for (std::size_t way = 0; way < 4 && a != b; ++way) {
        costs[a * count + b] =
            std::min(costs[a * count + b], problem.between(a, way / 2, b, way % 2));
      }
    }
  }
  return least_assignment(costs, count);
}

/// What it costs to come from an end of a row to one of another, in the cheaper direction.
RowEnds ends_of(const Problem& problem) {
  const std::size_t size = 2 * problem.count();
  RowEnds ends{.along = {}, .joins = std::vector<double>(size * size, kForbidden)};
  for (std::size_t row = 0; row < problem.count(); ++row) {
    ends.along.push_back(std::min(problem.along(row, 0), problem.along(row, 1)));
  }
  // End 0 of a row is where direction 0 begins.
  const auto join = [&](std::size_t p, std::size_t q) {
    double least = kForbidden;
    for (std::size_t way = 0; way < 4; ++way) {
      const std::size_t in_p = way / 2;
      const std::size_t in_q = way % 2;
      if (problem.node(p / 2, in_p, 1) == problem.node(p / 2, 0, p % 2) &&
          problem.node(q / 2, in_q, 0) == problem.node(q / 2, 0, q % 2)) {
        least = std::min(least, problem.between(p / 2, in_p, q / 2, in_q));
      }
    }
    return least;
  };
  for (std::size_t p = 0; p < size; ++p) {
    for (std::size_t q = 0; q < size; ++q) {
      if (p / 2 != q / 2) {
        ends.joins[p * size + q] = std::min(join(p, q), join(q, p));
      }
    }
  }
  return ends;
}

double lower_bound_of(const Problem& problem, double cost,
                      const std::function<bool()>& should_stop) {
  if (problem.count() == 1) {
    return 0;
  }
  const RowEnds ends = ends_of(problem);
  double along = 0;
  for (const double row : ends.along) {
    along += row;
  }
  // Twice a matching of the ends is an assignment.
  const double by_assignment =
      along +
      std::max(bound_of_rows(problem), least_assignment(ends.joins, 2 * problem.count()) / 2);
  return std::max(by_assignment, bound_by_spanning_trees(ends, cost, should_stop));
}

void append_route(RoutePlanner& planner, std::uint32_t from, std::uint32_t to, Tour& tour) {
  const Route route = planner.find(from, to);
  tour.edges.insert(tour.edges.end(), route.edges.begin(), route.edges.end());
}

}  // namespace

std::vector<TourRow> tour_rows(const RouteGraph& graph, std::span<const std::uint32_t> edges,
                               RowSides sides) {
  std::vector<TourRow> rows;
  std::vector<bool> done(graph.edges().size(), false);
  for (const std::uint32_t edge : edges) {
    if (edge >= graph.edges().size()) {
      validation::refuse("row: position ", edge, " given in a graph of ", graph.edges().size(),
                         " edges");
    }
    const auto opposite = graph.opposite(edge);
    if (done[edge]) {
      continue;
    }
    done[edge] = true;
    if (sides == RowSides::kAsGiven) {
      rows.push_back({edge, std::nullopt});
      continue;
    }
    if (opposite) {
      done[*opposite] = true;
    }
    if (sides == RowSides::kOne) {
      rows.push_back({edge, opposite});
      continue;
    }
    rows.push_back({edge, std::nullopt});
    if (opposite) {
      rows.push_back({*opposite, std::nullopt});
    }
  }
  return rows;
}

Tour plan_tour(RoutePlanner& planner, std::uint32_t start, std::span<const TourRow> rows,
               const std::function<bool()>& should_stop) {
  constexpr std::uint64_t kSeed = 1;
  constexpr int kPatience = 20;  // perturbations in a row that win nothing
  if (rows.size() > kMostRows) {
    validation::refuse("rows: ", rows.size(), " given; at most ", kMostRows, " are planned");
  }
  const Problem problem(planner, start, rows);
  Tour tour;
  for (std::size_t row = 1; row < problem.count(); ++row) {
    if (!problem.is_reachable(row)) {
      tour.status = TourStatus::kRowUnreachable;
      tour.unreachable.push_back(rows[row - 1]);
    }
  }
  if (tour.status != TourStatus::kFound || rows.empty()) {
    return tour;
  }
  const std::optional<Order> best = best_of_all(problem, should_stop);
  Order order = best ? *best : inserted(problem);
  double cost = cost_of(problem, order, nullptr);
  if (!best) {
    improve(problem, order, cost, should_stop);
  }
  std::mt19937_64 engine(kSeed);
  for (int failures = 0; failures < kPatience && !best && !should_stop(); ++failures) {
    Order other = perturbed(order, engine);
    double other_cost = cost_of(problem, other, nullptr);
    improve(problem, other, other_cost, should_stop);
    if (other_cost < cost - kNoGain) {
      order = std::move(other);
      cost = other_cost;
      failures = -1;
    }
  }
  std::vector<std::size_t> directions;
  tour.cost = cost_of(problem, order, &directions);
  tour.lower_bound = best ? tour.cost : lower_bound_of(problem, tour.cost, should_stop);
  std::uint32_t at = start;
  for (std::size_t i = 1; i < order.size(); ++i) {
    append_route(planner, at, problem.node(order[i], directions[i], 0), tour);
    const TourRow& row = rows[order[i] - 1];
    tour.edges.push_back(directions[i] == 0 ? row.edge : row.opposite.value_or(row.edge));
    at = problem.node(order[i], directions[i], 1);
  }
  append_route(planner, at, start, tour);
  return tour;
}

}  // namespace pipescout::navigation
