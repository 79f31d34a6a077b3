// SPDX-License-Identifier: Apache-2.0
#include "pipescout/planning/route_planner.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "pipescout/validation/check.hpp"

namespace pipescout::navigation {
namespace {

constexpr std::uint32_t kNothing = std::numeric_limits<std::uint32_t>::max();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMostLandmarks = 16;
constexpr int kActiveLandmarks = 4;
/// Stands for infinity in the tables of landmarks: differences of two are zero.
constexpr float kFar = 1e30F;
/// Two float distances and their difference are off by less than this share of the larger one.
constexpr float kRounding = 2e-7F;

/// Bits of x and y in turn (Morton, 1966): nodes that are near are near in memory.
std::uint64_t interleaved(std::uint32_t x, std::uint32_t y) {
  const auto spread = [](std::uint64_t value) {
    value = (value | (value << 16U)) & 0x0000ffff0000ffffU;
    value = (value | (value << 8U)) & 0x00ff00ff00ff00ffU;
    value = (value | (value << 4U)) & 0x0f0f0f0f0f0f0f0fU;
    value = (value | (value << 2U)) & 0x3333333333333333U;
    return (value | (value << 1U)) & 0x5555555555555555U;
  };
  return spread(x) | (spread(y) << 1U);
}

/// Nodes in the order of their places in memory.
std::vector<std::uint32_t> order_in_memory(const RouteGraph& graph) {
  Point2d low{kInfinity, kInfinity};
  double extent = 0;
  for (const RouteNode& node : graph.nodes()) {
    low = {std::min(low.x, node.position.x), std::min(low.y, node.position.y)};
  }
  for (const RouteNode& node : graph.nodes()) {
    extent = std::max({extent, node.position.x - low.x, node.position.y - low.y});
  }
  constexpr double kSteps = 65535;
  const double scale = extent > 0 ? kSteps / extent : 0;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
  keys.reserve(graph.nodes().size());
  for (const RouteNode& node : graph.nodes()) {
    keys.emplace_back(interleaved(static_cast<std::uint32_t>((node.position.x - low.x) * scale),
                                  static_cast<std::uint32_t>((node.position.y - low.y) * scale)),
                      static_cast<std::uint32_t>(keys.size()));
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> order(keys.size());
  std::transform(keys.begin(), keys.end(), order.begin(),
                 [](const auto& key) { return key.second; });
  return order;
}

struct Entry {
  double key;
  std::uint32_t node;
};

/// A heap with four children per entry, smallest first; entries that are outdated stay in it.
class Heap {
 public:
  void clear() { entries_.clear(); }
  [[nodiscard]] bool empty() const { return entries_.empty(); }
  [[nodiscard]] const Entry& top() const { return entries_.front(); }

  void push(const Entry& entry) {
    std::size_t at = entries_.size();
    entries_.push_back(entry);
    while (at > 0 && entries_[(at - 1) / 4].key > entry.key) {
      entries_[at] = entries_[(at - 1) / 4];
      at = (at - 1) / 4;
    }
    entries_[at] = entry;
  }

  void pop() {
    const Entry last = entries_.back();
    entries_.pop_back();
    if (entries_.empty()) {
      return;
    }
    const std::size_t count = entries_.size();
    std::size_t at = 0;
    while (4 * at + 1 < count) {
      const std::size_t first = 4 * at + 1;
      const std::size_t end = std::min(first + 4, count);
      std::size_t least = first;
      for (std::size_t child = first + 1; child < end; ++child) {
        least = entries_[child].key < entries_[least].key ? child : least;
      }
      if (entries_[least].key >= last.key) {
        break;
      }
      entries_[at] = entries_[least];
      at = least;
    }
    entries_[at] = last;
  }

 private:
  std::vector<Entry> entries_;
};

struct Arc {
  std::uint32_t to;
  std::uint32_t edge;  ///< position in the graph
  double cost;
};

/// Arcs of each node, one after the other.
struct Arcs {
  std::vector<std::uint32_t> first;
  std::vector<Arc> arcs;
};

struct Label {
  double cost = kInfinity;
  std::uint32_t arc = kNothing;  ///< that led here
  std::uint32_t query = 0;       ///< that wrote this
};

/// Distances from and to each landmark, at one node.
using LandmarkRow = std::array<std::array<float, 2>, kMostLandmarks>;

}  // namespace

class RoutePlanner::Search {
 public:
  Search(std::shared_ptr<const RouteGraph> graph, const EdgeCost& cost, int landmarks)
      : graph_(std::move(graph)) {
    if (!graph_) {
      validation::refuse("graph: none given");
    }
    validation::check_within("landmarks", landmarks, 0, kMostLandmarks);
    order_ = order_in_memory(*graph_);
    place_.resize(order_.size());
    for (std::uint32_t i = 0; i < order_.size(); ++i) {
      place_[order_[i]] = i;
    }
    costs_.resize(graph_->edges().size());
    for (std::uint32_t edge = 0; edge < costs_.size(); ++edge) {
      costs_[edge] = cost(*graph_, edge);
      if (!(costs_[edge] >= 0 && costs_[edge] < kInfinity)) {
        validation::refuse("edge ", graph_->edges()[edge].id, ": its cost is ", costs_[edge],
                           "; it must be finite and at least 0");
      }
    }
    forward_ = arcs_of(false);
    arc_of_edge_.resize(costs_.size());
    for (std::uint32_t i = 0; i < forward_.arcs.size(); ++i) {
      arc_of_edge_[forward_.arcs[i].edge] = i;
    }
    labels_.resize(order_.size());
    add_landmarks(landmarks);
    closed_.assign(costs_.size(), false);
    for (std::uint32_t edge = 0; edge < costs_.size(); ++edge) {
      if (graph_->edges()[edge].closed_until) {
        set_closed(edge, true);
      }
    }
  }

  void set_time(double time) {
    if (std::isnan(time)) {
      validation::refuse("time: NaN given");
    }
    for (std::uint32_t edge = 0; edge < closed_.size(); ++edge) {
      if (const auto until = graph_->edges()[edge].closed_until) {
        set_closed(edge, *until > time);
      }
    }
  }

  void set_closed(std::uint32_t edge, bool closed) {
    check_edge(edge);
    closed_[edge] = closed;
    forward_.arcs[arc_of_edge_[edge]].cost = closed ? kInfinity : costs_[edge];
  }

  [[nodiscard]] bool is_closed(std::uint32_t edge) const {
    check_edge(edge);
    return closed_[edge];
  }

  [[nodiscard]] double cost(std::uint32_t edge) const {
    check_edge(edge);
    return closed_[edge] ? kInfinity : costs_[edge];
  }

  Route find(std::uint32_t from, std::uint32_t to) {
    check_node(from);
    check_node(to);
    const std::uint32_t start = place_[from];
    const std::uint32_t goal = place_[to];
    choose_landmarks(start, goal);
    begin();
    set(start, 0, kNothing);
    heap_.push({bound(start), start});
    while (!heap_.empty()) {
      const Entry entry = heap_.top();
      if (entry.key >= cost_at(goal)) {  // also where no way leads: both are infinite
        break;
      }
      heap_.pop();
      const double cost = labels_[entry.node].cost;
      if (entry.key > cost + bound(entry.node)) {
        continue;  // a cheaper way was found since
      }
      ++expanded_;
      for (std::uint32_t i = forward_.first[entry.node]; i < forward_.first[entry.node + 1]; ++i) {
        const Arc& arc = forward_.arcs[i];
        const double reached = cost + arc.cost;
        if (reached < cost_at(arc.to)) {
          set(arc.to, reached, i);
          const double key = reached + bound(arc.to);
          if (key < cost_at(goal) || (arc.to == goal && key < kInfinity)) {
            heap_.push({key, arc.to});
          }
        }
      }
    }
    return route_to(goal);
  }

  std::vector<Route> alternatives(std::uint32_t from, std::uint32_t to, std::size_t count,
                                  const AlternativeLimits& limits) {
    constexpr double kLargestStretch = 100;
    validation::check_within("largest_stretch", limits.largest_stretch, 1, kLargestStretch);
    validation::check_within("largest_share", limits.largest_share, 0, 1);
    constexpr double kPenalty = 1.3;
    constexpr std::size_t kTriesEach = 5;
    std::vector<Route> routes;
    if (count == 0) {
      return routes;
    }
    routes.push_back(find(from, to));
    std::vector<std::uint32_t> raised;
    Route last = routes.front();
    for (std::size_t i = 0; i < count * kTriesEach && routes.size() < count && !last.edges.empty();
         ++i) {
      for (const std::uint32_t edge : last.edges) {
        forward_.arcs[arc_of_edge_[edge]].cost *= kPenalty;
        raised.push_back(edge);
      }
      last = find(from, to);
      last.cost =
          std::accumulate(last.edges.begin(), last.edges.end(), 0.0,
                          [&](double sum, std::uint32_t edge) { return sum + costs_[edge]; });
      if (last.cost <= limits.largest_stretch * routes.front().cost &&
          std::all_of(routes.begin(), routes.end(), [&](const Route& other) {
            return shared_cost(last, other) <= limits.largest_share * last.cost;
          })) {
        routes.push_back(last);
      }
    }
    for (const std::uint32_t edge : raised) {
      set_closed(edge, closed_[edge]);
    }
    std::sort(routes.begin(), routes.end(),
              [](const Route& a, const Route& b) { return a.cost < b.cost; });
    return routes;
  }

  std::vector<double> costs_from(std::uint32_t node) {
    check_node(node);
    run_dijkstra(place_[node], forward_);
    std::vector<double> costs(order_.size());
    for (std::uint32_t i = 0; i < costs.size(); ++i) {
      costs[order_[i]] = cost_at(i);
    }
    return costs;
  }

  [[nodiscard]] std::size_t expanded() const { return expanded_; }
  [[nodiscard]] const RouteGraph& graph() const { return *graph_; }

 private:
  void check_node(std::uint32_t node) const {
    if (node >= order_.size()) {
      validation::refuse("node: position ", node, " given in a graph of ", order_.size(), " nodes");
    }
  }

  void check_edge(std::uint32_t edge) const {
    if (edge >= costs_.size()) {
      validation::refuse("edge: position ", edge, " given in a graph of ", costs_.size(), " edges");
    }
  }

  [[nodiscard]] Arcs arcs_of(bool reversed) const {
    Arcs result;
    result.first.assign(order_.size() + 1, 0);
    const auto& edges = graph_->edges();
    for (const RouteEdge& edge : edges) {
      ++result.first[place_[reversed ? edge.to : edge.from] + 1];
    }
    std::partial_sum(result.first.begin(), result.first.end(), result.first.begin());
    std::vector<std::uint32_t> next(result.first.begin(), result.first.end() - 1);
    result.arcs.resize(edges.size());
    for (std::uint32_t i = 0; i < edges.size(); ++i) {
      const std::uint32_t from = place_[reversed ? edges[i].to : edges[i].from];
      const std::uint32_t to = place_[reversed ? edges[i].from : edges[i].to];
      result.arcs[next[from]++] = {to, i, costs_[i]};
    }
    return result;
  }

  void begin() {
    ++query_;
    heap_.clear();
    expanded_ = 0;
  }

  [[nodiscard]] double cost_at(std::uint32_t node) const {
    return labels_[node].query == query_ ? labels_[node].cost : kInfinity;
  }

  void set(std::uint32_t node, double cost, std::uint32_t arc) {
    labels_[node] = {cost, arc, query_};
  }

  void run_dijkstra(std::uint32_t start, const Arcs& arcs) {
    begin();
    set(start, 0, kNothing);
    heap_.push({0, start});
    while (!heap_.empty()) {
      const Entry entry = heap_.top();
      heap_.pop();
      if (entry.key > labels_[entry.node].cost) {
        continue;
      }
      for (std::uint32_t i = arcs.first[entry.node]; i < arcs.first[entry.node + 1]; ++i) {
        const double reached = entry.key + arcs.arcs[i].cost;
        if (reached < cost_at(arcs.arcs[i].to)) {
          set(arcs.arcs[i].to, reached, i);
          heap_.push({reached, arcs.arcs[i].to});
        }
      }
    }
  }

  /// Each new landmark is the node that is farthest from those before, within the largest strongly
  /// connected part: from a dead end of one-way roads nothing could be measured.
  void add_landmarks(int count) {
    if (count == 0 || order_.empty()) {
      return;
    }
    const Arcs backward = arcs_of(true);
    const std::vector<bool> candidates = largest_part();
    rows_.resize(order_.size());
    std::vector<double> nearest(order_.size(), kInfinity);
    const auto any = std::find(candidates.begin(), candidates.end(), true) - candidates.begin();
    auto landmark = static_cast<std::uint32_t>(any);
    for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k) {
      if (k == 0) {
        run_dijkstra(landmark, forward_);
        landmark = farthest(candidates, [&](std::uint32_t i) { return cost_at(i); });
      }
      run_dijkstra(landmark, backward);
      for (std::uint32_t i = 0; i < order_.size(); ++i) {
        rows_[i][k][1] = to_float(cost_at(i));
      }
      run_dijkstra(landmark, forward_);
      for (std::uint32_t i = 0; i < order_.size(); ++i) {
        rows_[i][k][0] = to_float(cost_at(i));
        nearest[i] = std::min(nearest[i], cost_at(i));
      }
      landmark = farthest(candidates, [&](std::uint32_t i) { return nearest[i]; });
    }
    landmarks_ = static_cast<std::size_t>(count);
  }

  /// Of each place, whether its node is in the largest strongly connected part.
  [[nodiscard]] std::vector<bool> largest_part() const {
    const std::vector<std::uint32_t> parts = graph_->strong_parts();
    std::vector<std::uint32_t> sizes(parts.size(), 0);
    for (const std::uint32_t part : parts) {
      ++sizes[part];
    }
    const auto largest =
        static_cast<std::uint32_t>(std::max_element(sizes.begin(), sizes.end()) - sizes.begin());
    std::vector<bool> result(parts.size());
    for (std::uint32_t i = 0; i < parts.size(); ++i) {
      result[i] = parts[order_[i]] == largest;
    }
    return result;
  }

  template <typename Distance>
  [[nodiscard]] std::uint32_t farthest(const std::vector<bool>& candidates,
                                       const Distance& distance_of) const {
    std::uint32_t best = 0;
    double most = -1;
    for (std::uint32_t i = 0; i < order_.size(); ++i) {
      const double away = distance_of(i);
      if (candidates[i] && away > most && away < kInfinity) {
        most = away;
        best = i;
      }
    }
    return best;
  }

  float to_float(double value) {
    if (value == kInfinity) {
      return kFar;
    }
    largest_ = std::max(largest_, static_cast<float>(value));
    return static_cast<float>(value);
  }

  /// Those that bound this query best.
  void choose_landmarks(std::uint32_t start, std::uint32_t goal) {
    std::array<std::pair<float, std::size_t>, kMostLandmarks> found;
    for (std::size_t k = 0; k < landmarks_; ++k) {
      const auto& at_start = rows_[start][k];
      const auto& at_goal = rows_[goal][k];
      found[k] = {std::max(at_goal[0] - at_start[0], at_start[1] - at_goal[1]), k};
    }
    std::sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(landmarks_),
              std::greater<>());
    active_ = std::min<std::size_t>(landmarks_, kActiveLandmarks);
    for (std::size_t i = 0; i < active_; ++i) {
      chosen_[i] = found[i].second;
      goal_row_[i] = rows_[goal][found[i].second];
    }
  }

  /// At most what it costs from a node to the goal: the triangle inequality of a landmark L gives
  /// d(v, t) >= d(L, t) - d(L, v) and d(v, t) >= d(v, L) - d(t, L).
  [[nodiscard]] double bound(std::uint32_t node) const {
    if (active_ == 0) {
      return 0;
    }
    const LandmarkRow& row = rows_[node];
    float best = 0;
    for (std::size_t i = 0; i < active_; ++i) {
      const auto& of_node = row[chosen_[i]];
      best = std::max({best, goal_row_[i][0] - of_node[0], of_node[1] - goal_row_[i][1]});
    }
    if (best > kFar / 2) {
      return kInfinity;  // a landmark reaches the node and not the goal, or the goal and not the
                         // node
    }
    return std::max(0.0F, best - kRounding * largest_);
  }

  [[nodiscard]] Route route_to(std::uint32_t goal) const {
    Route route;
    if (cost_at(goal) == kInfinity) {
      return route;
    }
    route.status = RouteStatus::kFound;
    route.cost = cost_at(goal);
    for (std::uint32_t at = goal; labels_[at].arc != kNothing;) {
      const std::uint32_t edge = forward_.arcs[labels_[at].arc].edge;
      route.edges.push_back(edge);
      at = place_[graph_->edges()[edge].from];
    }
    std::reverse(route.edges.begin(), route.edges.end());
    return route;
  }

  [[nodiscard]] double shared_cost(const Route& a, const Route& b) const {
    std::vector<std::uint32_t> sorted = b.edges;
    std::sort(sorted.begin(), sorted.end());
    double sum = 0;
    for (const std::uint32_t edge : a.edges) {
      sum += std::binary_search(sorted.begin(), sorted.end(), edge) ? costs_[edge] : 0;
    }
    return sum;
  }

  std::shared_ptr<const RouteGraph> graph_;
  std::vector<std::uint32_t> order_;  ///< node of the graph at each place in memory
  std::vector<std::uint32_t> place_;
  std::vector<double> costs_;
  std::vector<bool> closed_;
  Arcs forward_;  ///< with what is closed
  std::vector<std::uint32_t> arc_of_edge_;
  std::vector<Label> labels_;
  std::vector<LandmarkRow> rows_;
  std::size_t landmarks_ = 0;
  float largest_ = 0;
  std::size_t active_ = 0;
  std::array<std::size_t, kActiveLandmarks> chosen_{};
  std::array<std::array<float, 2>, kActiveLandmarks> goal_row_{};
  Heap heap_;
  std::uint32_t query_ = 0;
  std::size_t expanded_ = 0;
};

EdgeCost cost_of_file() {
  return [](const RouteGraph& graph, std::uint32_t edge) {
    return graph.edges()[edge].cost.value_or(graph.length(edge));
  };
}

EdgeCost length_cost() {
  return [](const RouteGraph& graph, std::uint32_t edge) { return graph.length(edge); };
}

EdgeCost time_cost(double speed) {
  constexpr double kLargestSpeed = 100;  // m/s
  validation::check_above("speed", speed, 0, kLargestSpeed);
  return [speed](const RouteGraph& graph, std::uint32_t edge) {
    return graph.length(edge) / graph.edges()[edge].speed.value_or(speed);
  };
}

RoutePlanner::RoutePlanner(std::shared_ptr<const RouteGraph> graph, const EdgeCost& cost,
                           int landmarks)
    : search_(std::make_unique<Search>(std::move(graph), cost, landmarks)) {}
RoutePlanner::~RoutePlanner() = default;
RoutePlanner::RoutePlanner(RoutePlanner&&) noexcept = default;
RoutePlanner& RoutePlanner::operator=(RoutePlanner&&) noexcept = default;

void RoutePlanner::set_time(double time) {
  search_->set_time(time);
}
void RoutePlanner::close(std::uint32_t edge) {
  search_->set_closed(edge, true);
}
void RoutePlanner::open(std::uint32_t edge) {
  search_->set_closed(edge, false);
}
bool RoutePlanner::is_closed(std::uint32_t edge) const {
  return search_->is_closed(edge);
}
double RoutePlanner::cost(std::uint32_t edge) const {
  return search_->cost(edge);
}
Route RoutePlanner::find(std::uint32_t from, std::uint32_t to) {
  return search_->find(from, to);
}
std::vector<Route> RoutePlanner::alternatives(std::uint32_t from, std::uint32_t to,
                                              std::size_t count, const AlternativeLimits& limits) {
  return search_->alternatives(from, to, count, limits);
}
std::vector<double> RoutePlanner::costs_from(std::uint32_t node) {
  return search_->costs_from(node);
}
std::size_t RoutePlanner::expanded() const {
  return search_->expanded();
}
const RouteGraph& RoutePlanner::graph() const {
  return search_->graph();
}

}  // namespace pipescout::navigation
