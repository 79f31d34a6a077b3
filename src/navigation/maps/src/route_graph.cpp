// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigation_maps/route_graph.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <string_view>
#include <utility>

#include "pipescout/validation/check.hpp"

namespace pipescout::navigation {
namespace {

using Ids = std::vector<std::pair<std::int64_t, std::uint32_t>>;

constexpr double kLargestSpeed = 100;   // m/s
constexpr double kLargestWidth = 1000;  // m

template <typename Items>
Ids sorted_ids(const Items& items) {
  Ids ids;
  ids.reserve(items.size());
  for (const auto& item : items) {
    ids.emplace_back(item.id, static_cast<std::uint32_t>(ids.size()));
  }
  std::sort(ids.begin(), ids.end());
  return ids;
}

void check_nodes_unique(const Ids& ids) {
  const auto twice = std::adjacent_find(
      ids.begin(), ids.end(), [](const auto& a, const auto& b) { return a.first == b.first; });
  if (twice != ids.end()) {
    validation::refuse("node ", twice->first, ": its id occurs twice");
  }
}

/// Edges of one id that run between the same places are one road; others are a mistake.
void check_edges_unique(const Ids& ids, const std::vector<RouteEdge>& edges,
                        const std::vector<RouteNode>& nodes) {
  for (std::size_t k = 1; k < ids.size(); ++k) {
    const RouteEdge& one = edges[ids[k - 1].second];
    const RouteEdge& other = edges[ids[k].second];
    if (one.id == other.id && (nodes[one.from].position != nodes[other.from].position ||
                               nodes[one.to].position != nodes[other.to].position)) {
      validation::refuse("edge ", one.id, ": two edges have this id, from node ",
                         nodes[one.from].id, " to node ", nodes[one.to].id, " and from node ",
                         nodes[other.from].id, " to node ", nodes[other.to].id);
    }
  }
}

std::optional<std::uint32_t> find_id(const Ids& ids, std::int64_t id) {
  const auto found = std::lower_bound(ids.begin(), ids.end(), std::pair{id, std::uint32_t{0}});
  const auto next = found == ids.end() ? found : std::next(found);
  if (found == ids.end() || found->first != id || (next != ids.end() && next->first == id)) {
    return std::nullopt;  // not there, or ambiguous
  }
  return found->second;
}

bool is_point(const Point2d& point) {
  return std::isfinite(point.x) && std::isfinite(point.y);
}

void check_range(const RouteEdge& edge, std::string_view field, std::optional<double> value,
                 double largest, bool may_be_zero) {
  const double infinity = std::numeric_limits<double>::infinity();
  if (value &&
      (!(*value >= 0 && *value <= largest && *value < infinity) || (*value == 0 && !may_be_zero))) {
    validation::refuse("edge ", edge.id, ": ", field, " is ", *value, "; it must be within ",
                       may_be_zero ? "[" : "(", "0, ", largest, "]");
  }
}

void check_edge(const RouteEdge& edge, const std::vector<RouteNode>& nodes) {
  if (edge.from >= nodes.size() || edge.to >= nodes.size()) {
    validation::refuse("edge ", edge.id, ": a node that it joins is not there");
  }
  if (edge.from == edge.to) {
    validation::refuse("edge ", edge.id, ": it leads from node ", nodes[edge.from].id,
                       " to itself");
  }
  if (edge.line.size() == 1 || !std::all_of(edge.line.begin(), edge.line.end(), is_point)) {
    validation::refuse("edge ", edge.id,
                       ": its line has one point only, or one that is not finite");
  }
  check_range(edge, "cost", edge.cost, std::numeric_limits<double>::max(), true);
  check_range(edge, "speed", edge.speed, kLargestSpeed, false);
  check_range(edge, "width", edge.width, kLargestWidth, false);
  if (edge.closed_until && std::isnan(*edge.closed_until)) {
    validation::refuse("edge ", edge.id, ": closed_until is NaN; it must be a time in s");
  }
}

double line_length(const RouteEdge& edge, const std::vector<RouteNode>& nodes) {
  if (edge.line.empty()) {
    return distance(nodes[edge.from].position, nodes[edge.to].position);
  }
  double length = 0;
  for (std::size_t i = 1; i < edge.line.size(); ++i) {
    length += distance(edge.line[i - 1], edge.line[i]);
  }
  return length;
}

}  // namespace

RouteGraph::RouteGraph(std::vector<RouteNode> nodes, std::vector<RouteEdge> edges)
    : nodes_(std::move(nodes)), edges_(std::move(edges)) {
  node_ids_ = sorted_ids(nodes_);
  check_nodes_unique(node_ids_);
  edge_ids_ = sorted_ids(edges_);
  for (const RouteNode& node : nodes_) {
    if (!is_point(node.position)) {
      validation::refuse("node ", node.id, ": its position is not finite");
    }
    if (node.frame != nodes_.front().frame) {
      validation::refuse("node ", node.id, ": frame is '", node.frame, "', and '",
                         nodes_.front().frame, "' at node ", nodes_.front().id);
    }
  }
  first_.assign(nodes_.size() + 1, 0);
  lengths_.reserve(edges_.size());
  for (const RouteEdge& edge : edges_) {
    check_edge(edge, nodes_);
    lengths_.push_back(line_length(edge, nodes_));
    ++first_[edge.from + 1];
  }
  check_edges_unique(edge_ids_, edges_, nodes_);
  for (std::size_t i = 1; i < first_.size(); ++i) {
    first_[i] += first_[i - 1];
  }
  outgoing_.resize(edges_.size());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t i = 0; i < edges_.size(); ++i) {
    outgoing_[next[edges_[i].from]++] = i;
  }
}

std::optional<std::uint32_t> RouteGraph::node_of_id(std::int64_t id) const {
  return find_id(node_ids_, id);
}

std::optional<std::uint32_t> RouteGraph::edge_of_id(std::int64_t id) const {
  return find_id(edge_ids_, id);
}

std::optional<std::uint32_t> RouteGraph::opposite(std::uint32_t edge) const {
  const RouteEdge& way = edges_.at(edge);
  std::optional<std::uint32_t> best;
  for (const std::uint32_t back : outgoing(way.to)) {
    // Of parallel roads the one that is as long.
    if (edges_[back].to == way.from && (!best || std::abs(lengths_[back] - lengths_[edge]) <
                                                     std::abs(lengths_[*best] - lengths_[edge]))) {
      best = back;
    }
  }
  return best;
}

std::optional<std::uint32_t> RouteGraph::nearest_node(const Point2d& position) const {
  std::optional<std::uint32_t> best;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    const double away = distance(nodes_[i].position, position);
    if (away < nearest) {
      nearest = away;
      best = i;
    }
  }
  return best;
}

std::vector<std::uint32_t> RouteGraph::strong_parts() const {
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  const auto count = static_cast<std::uint32_t>(nodes_.size());
  std::vector<std::uint32_t> order(count, kNone);
  std::vector<std::uint32_t> low(count, 0);
  std::vector<std::uint32_t> part(count, kNone);
  std::vector<std::uint32_t> open;
  struct Visit {
    std::uint32_t node;
    std::size_t next_edge;
  };
  std::vector<Visit> stack;
  std::uint32_t visited = 0;
  std::uint32_t parts = 0;
  for (std::uint32_t root = 0; root < count; ++root) {
    if (order[root] == kNone) {
      stack.push_back({root, 0});
    }
    while (!stack.empty()) {
      Visit& visit = stack.back();
      const std::uint32_t node = visit.node;
      if (visit.next_edge == 0 && order[node] == kNone) {
        order[node] = low[node] = visited++;
        open.push_back(node);
      }
      const auto edges = outgoing(node);
      if (visit.next_edge < edges.size()) {
        const std::uint32_t to = edges_[edges[visit.next_edge++]].to;
        if (order[to] == kNone) {
          stack.push_back({to, 0});
        } else if (part[to] == kNone) {
          low[node] = std::min(low[node], order[to]);
        }
        continue;
      }
      stack.pop_back();
      if (!stack.empty()) {
        low[stack.back().node] = std::min(low[stack.back().node], low[node]);
      }
      if (low[node] == order[node]) {
        std::uint32_t member = kNone;
        while (member != node) {
          member = open.back();
          open.pop_back();
          part[member] = parts;
        }
        ++parts;
      }
    }
  }
  // Numbered by their first nodes.
  std::vector<std::uint32_t> renamed(parts, kNone);
  std::uint32_t next = 0;
  for (std::uint32_t& number : part) {
    if (renamed[number] == kNone) {
      renamed[number] = next++;
    }
    number = renamed[number];
  }
  return part;
}

}  // namespace pipescout::navigation
