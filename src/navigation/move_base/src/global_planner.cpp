// SPDX-License-Identifier: Apache-2.0
#include "pipescout/move_base/global_planner.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/planning/route_planner.hpp"
#include "pipescout/planning/tour.hpp"
#include "pipescout/validation/check.hpp"
#include "pipescout/validation/number_text.hpp"

namespace pipescout::navigation {
namespace {

constexpr double kEntrySlack = 5;      ///< m, that such a node may be farther than the nearest
constexpr std::size_t kEntries = 3;    ///< nodes that are tried as first and as last of a route
constexpr double kApproach = 3;        ///< m, straight before a pose that was missed
constexpr double kShortEdge = 4;       ///< m; shorter ones need no target in their middle
constexpr double kBodyCells = 0.1;     ///< m around the body, within which nothing can be seen
constexpr double kRowDetour = 1.2;     ///< of its length; a longer way round does not see the row
constexpr double kRowDetourSpare = 3;  ///< m

/// A pose to drive through.
struct Target {
  Pose2d pose;
  bool required = true;              ///< otherwise it only leads the way
  std::optional<std::int64_t> node;  ///< of the goal
  std::optional<std::uint32_t> row;  ///< edge that is driven along to get here
  std::int64_t row_id = 0;
};

/// How a pose is come to.
enum class PoseWay {
  kDirect,
  kOverGraph,
  kAlongEdge,  ///< over the graph to an edge that leads its way, and along it
};

NavigationFailure failure_of(PlanStatus status) {
  switch (status) {
    case PlanStatus::kFound:
      return NavigationFailure::kNone;
    case PlanStatus::kStartNotFinite:
    case PlanStatus::kStartOutside:
      return NavigationFailure::kStartOutside;
    case PlanStatus::kGoalNotFinite:
      return NavigationFailure::kGoalNotFinite;
    case PlanStatus::kGoalOutside:
      return NavigationFailure::kGoalOutside;
    case PlanStatus::kStartInCollision:
      return NavigationFailure::kStartInCollision;
    case PlanStatus::kGoalInCollision:
      return NavigationFailure::kGoalInCollision;
    case PlanStatus::kUnreachable:
      return NavigationFailure::kUnreachable;
    case PlanStatus::kNotFound:
    case PlanStatus::kStopped:
      break;
  }
  return NavigationFailure::kNoPath;
}

PipeSide mirrored(PipeSide side) {
  return side == PipeSide::kLeft ? PipeSide::kRight
                                 : (side == PipeSide::kRight ? PipeSide::kLeft : side);
}

std::string place(const Pose2d& pose) {
  return "(" + validation::number_text(pose.x) + ", " + validation::number_text(pose.y) + ")";
}

std::vector<Point2d> line_of(const RouteGraph& graph, std::uint32_t edge) {
  const RouteEdge& e = graph.edges()[edge];
  if (!e.line.empty()) {
    return e.line;
  }
  return {graph.nodes()[e.from].position, graph.nodes()[e.to].position};
}

/// At `length` m along an edge, headed along it.
Pose2d along(const RouteGraph& graph, std::uint32_t edge, double length) {
  const std::vector<Point2d> line = line_of(graph, edge);
  Pose2d pose;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Point2d& a = line[i - 1];
    const Point2d& b = line[i];
    const double piece = distance(a, b);
    if (piece <= 0) {
      continue;
    }
    const double at = std::clamp(length, 0.0, piece);
    pose = {a.x + (b.x - a.x) * at / piece, a.y + (b.y - a.y) * at / piece,
            std::atan2(b.y - a.y, b.x - a.x)};
    length -= piece;
    if (length <= 0) {
      break;
    }
  }
  return pose;
}

/// The edge nearest to a pose that leads its way; nothing without any.
std::optional<std::uint32_t> edge_to(const RouteGraph& graph, const Pose2d& pose) {
  constexpr double kStep = 0.5;  // m
  std::optional<std::uint32_t> result;
  double least = std::numeric_limits<double>::infinity();
  for (std::uint32_t edge = 0; edge < graph.edges().size(); ++edge) {
    const double length = graph.length(edge);
    const Point2d& from = graph.nodes()[graph.edges()[edge].from].position;
    if (distance(from, pose.position()) - length > least) {
      continue;
    }
    for (double at = 0; at <= length; at += kStep) {
      const Pose2d there = along(graph, edge, at);
      const double apart = distance(there.position(), pose.position());
      if (apart < least && std::cos(there.heading - pose.heading) > 0.5) {
        least = apart;
        result = edge;
      }
    }
  }
  return result;
}

std::vector<std::uint32_t> nearest_nodes(const RouteGraph& graph, const Point2d& position) {
  std::vector<std::uint32_t> nodes(graph.nodes().size());
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    nodes[i] = i;
  }
  const std::size_t count = std::min(kEntries, nodes.size());
  std::partial_sort(nodes.begin(), nodes.begin() + static_cast<std::ptrdiff_t>(count), nodes.end(),
                    [&](std::uint32_t a, std::uint32_t b) {
                      return distance(graph.nodes()[a].position, position) <
                             distance(graph.nodes()[b].position, position);
                    });
  nodes.resize(count);
  // The way there is not on the graph: what is closed must not be passed by it.
  const auto away = [&](std::uint32_t node) {
    return distance(graph.nodes()[node].position, position);
  };
  std::erase_if(nodes, [&, nearest = count > 0 ? away(nodes.front()) : 0](std::uint32_t node) {
    return away(node) > nearest + kEntrySlack;
  });
  return nodes;
}

}  // namespace

const char* to_string(NavigationFailure failure) {
  switch (failure) {
    case NavigationFailure::kNone:
      return "none";
    case NavigationFailure::kGoalNotFinite:
      return "goal not finite";
    case NavigationFailure::kGoalOutside:
      return "goal outside the map";
    case NavigationFailure::kGoalInCollision:
      return "goal in collision";
    case NavigationFailure::kStartOutside:
      return "robot outside the map";
    case NavigationFailure::kStartInCollision:
      return "robot in collision";
    case NavigationFailure::kUnknownNode:
      return "unknown node";
    case NavigationFailure::kUnknownEdge:
      return "unknown edge";
    case NavigationFailure::kNoGoals:
      return "nothing to drive to";
    case NavigationFailure::kNoRoute:
      return "no route";
    case NavigationFailure::kUnreachable:
      return "unreachable";
    case NavigationFailure::kNoPath:
      return "no path found";
    case NavigationFailure::kBlocked:
      return "path blocked";
    case NavigationFailure::kGoalMissed:
      return "goal missed";
    case NavigationFailure::kLocalisationLost:
      return "localisation lost";
    case NavigationFailure::kScanLost:
      return "scan lost";
    case NavigationFailure::kPreempted:
      return "preempted";
    case NavigationFailure::kCanceled:
      return "canceled";
  }
  return "unknown";
}

void GlobalPlannerParameters::validate() const {
  validation::check_above("turning_radius", turning_radius, 0, 1000);
  validation::require("spacing", spacing, spacing > 0 && spacing <= turning_radius / 2,
                      "(0, turning_radius / 2]");
  validation::check_within("margin", margin, 0, 2);
  validation::check_within("direct_distance", direct_distance, 0, 1e4);
  validation::check_above("first_time", first_time, 0, 60);
  validation::check_within("improving_time", improving_time, 0, 60);
  lattice.validate();
}

class GlobalPlanner::Implementation {
 public:
  Implementation(const HybridMap& map, const Footprint& footprint,
                 const GlobalPlannerParameters& parameters)
      : parameters_(parameters),
        graph_(std::make_shared<const RouteGraph>(map.graph)),
        grid_(map.grid),
        footprint_(footprint),
        wide_(map.grid, footprint.inflated(parameters.margin),
              generate_primitives(parameters.turning_radius, parameters.spacing),
              parameters.lattice),
        tight_(map.grid, footprint,
               generate_primitives(parameters.turning_radius, parameters.spacing),
               parameters.lattice),
        routes_(graph_, cost_of_file()) {}

  NavigationPlan plan(const PlanRequest& request, const Clock& clock);
  void set_closed(std::span<const std::int64_t> ids, bool closed);

  [[nodiscard]] const RouteGraph& graph() const { return *graph_; }
  [[nodiscard]] const OccupancyGrid& grid() const { return grid_; }

 private:
  void see(const std::vector<Point2d>& obstacles, const Pose2d& start);
  [[nodiscard]] Plan plan_leg(const Pose2d& from, const Pose2d& to, const Clock& clock);
  std::vector<Target> targets(const PlanRequest& request, const PoseGoal& goal, PoseWay way,
                              NavigationPlan& plan);
  void plan_to_pose(const PlanRequest& request, const PoseGoal& goal, const Clock& clock,
                    NavigationPlan& plan);
  std::vector<Target> targets(const PlanRequest& request, const RouteGoal& goal,
                              NavigationPlan& plan);
  std::vector<Target> targets(const PlanRequest& request, const TourGoal& goal,
                              NavigationPlan& plan, const Clock& clock);
  void add_middle(std::uint32_t edge, std::vector<Target>& targets) const;
  /// The cheapest of those from any of some nodes to any of others, straight ways to them included.
  Route best_route(const Pose2d& start, const std::vector<std::uint32_t>& to,
                   const std::optional<Pose2d>& goal, std::uint32_t& last);
  void drive_through(const Pose2d& start, const std::vector<Target>& targets, const Clock& clock,
                     NavigationPlan& plan);

  GlobalPlannerParameters parameters_;
  std::shared_ptr<const RouteGraph> graph_;
  OccupancyGrid grid_;
  Footprint footprint_;
  LatticePlanner wide_;
  LatticePlanner tight_;
  RoutePlanner routes_;
  std::vector<Cell> seen_;  ///< cells that are not as in the map
  std::vector<std::uint32_t> closed_;
};

void GlobalPlanner::Implementation::set_closed(std::span<const std::int64_t> ids, bool closed) {
  for (std::uint32_t edge = 0; edge < graph_->edges().size(); ++edge) {
    if (std::find(ids.begin(), ids.end(), graph_->edges()[edge].id) == ids.end()) {
      continue;
    }
    const auto set = [&](std::uint32_t each) {
      std::erase(closed_, each);
      if (closed) {
        closed_.push_back(each);
        routes_.close(each);
      } else {
        routes_.open(each);
      }
    };
    set(edge);
    if (const auto opposite = graph_->opposite(edge)) {
      set(*opposite);
    }
  }
}

void GlobalPlanner::Implementation::see(const std::vector<Point2d>& obstacles,
                                        const Pose2d& start) {
  std::vector<CellChange> changes;
  for (const Cell& cell : seen_) {
    changes.push_back({cell, grid_.at(cell)});
  }
  wide_.change(changes);
  tight_.change(changes);
  changes.clear();
  seen_.clear();
  Point2d low;
  Point2d high;
  for (const Point2d& corner : footprint_.corners()) {
    low = {std::min(low.x, corner.x), std::min(low.y, corner.y)};
    high = {std::max(high.x, corner.x), std::max(high.y, corner.y)};
  }
  for (const Point2d& point : obstacles) {
    const Point2d body = relative(start, {point.x, point.y, 0}).position();
    const bool inside = body.x > low.x - kBodyCells && body.x < high.x + kBodyCells &&
                        body.y > low.y - kBodyCells && body.y < high.y + kBodyCells;
    const auto cell = grid_.cell_at(point);
    if (!inside && cell && grid_.at(*cell) != CellState::kOccupied) {
      changes.push_back({*cell, CellState::kOccupied});
      seen_.push_back(*cell);
    }
  }
  wide_.change(changes);
  tight_.change(changes);
}

Plan GlobalPlanner::Implementation::plan_leg(const Pose2d& from, const Pose2d& to,
                                             const Clock& clock) {
  const auto by = [&](LatticePlanner& planner) {
    const double begin = clock();
    double found = std::numeric_limits<double>::infinity();
    return planner.plan(
        from, to,
        [&] {
          const double now = clock();
          return now - found >= parameters_.improving_time || now - begin >= parameters_.first_time;
        },
        [&](const Path&, double) {
          if (std::isinf(found)) {
            found = clock();
          }
        });
  };
  Plan plan = by(wide_);
  return plan.status == PlanStatus::kFound ? plan : by(tight_);
}

void GlobalPlanner::Implementation::add_middle(std::uint32_t edge,
                                               std::vector<Target>& targets) const {
  if (graph_->length(edge) >= kShortEdge) {
    targets.push_back({.pose = along(*graph_, edge, graph_->length(edge) / 2), .required = false});
  }
}

Route GlobalPlanner::Implementation::best_route(const Pose2d& start,
                                                const std::vector<std::uint32_t>& to,
                                                const std::optional<Pose2d>& goal,
                                                std::uint32_t& last) {
  Route best;
  double least = std::numeric_limits<double>::infinity();
  for (const std::uint32_t from : nearest_nodes(*graph_, start.position())) {
    for (const std::uint32_t end : to) {
      Route route = routes_.find(from, end);
      if (route.status != RouteStatus::kFound) {
        continue;
      }
      const double cost = distance(graph_->nodes()[from].position, start.position()) + route.cost +
                          (goal ? distance(graph_->nodes()[end].position, goal->position()) : 0);
      if (cost < least) {
        least = cost;
        best = std::move(route);
        last = end;
      }
    }
  }
  return best;
}

std::vector<Target> GlobalPlanner::Implementation::targets(const PlanRequest& request,
                                                           const PoseGoal& goal, PoseWay way,
                                                           NavigationPlan& plan) {
  std::vector<Target> result;
  if (way != PoseWay::kDirect) {
    std::uint32_t last = 0;
    const auto edge = way == PoseWay::kAlongEdge ? edge_to(*graph_, goal.pose) : std::nullopt;
    const Route route =
        edge ? best_route(request.start, {graph_->edges()[*edge].from}, std::nullopt, last)
             : best_route(request.start, nearest_nodes(*graph_, goal.pose.position()), goal.pose,
                          last);
    if (route.status != RouteStatus::kFound) {
      plan.failure = NavigationFailure::kNoRoute;
      plan.text = "no open edges lead to the goal";
      return result;
    }
    plan.cost = route.cost;
    for (const std::uint32_t each : route.edges) {
      add_middle(each, result);
    }
    if (edge) {
      result.push_back({.pose = along(*graph_, *edge, 0), .required = false});
    }
  }
  if (request.straight_approach) {
    // From behind, or else in reverse from before it.
    for (const double before : {-kApproach, kApproach}) {
      const Pose2d from = compose(goal.pose, {before, 0, 0});
      if (!collides(footprint_, wide_.grid(), from, parameters_.lattice.unknown)) {
        result.push_back({.pose = from, .required = false});
        break;
      }
    }
  }
  result.push_back({.pose = goal.pose});
  return result;
}

std::vector<Target> GlobalPlanner::Implementation::targets(const PlanRequest& request,
                                                           const RouteGoal& goal,
                                                           NavigationPlan& plan) {
  std::vector<Target> result;
  if (goal.nodes.empty()) {
    plan.failure = NavigationFailure::kNoGoals;
    return result;
  }
  std::optional<std::uint32_t> at;
  Pose2d before = request.start;
  for (const std::int64_t id : goal.nodes) {
    const auto node = graph_->node_of_id(id);
    if (!node) {
      plan.failure = NavigationFailure::kUnknownNode;
      plan.text = "node " + std::to_string(id);
      return {};
    }
    std::uint32_t last = *node;
    const Route route =
        at ? routes_.find(*at, *node) : best_route(request.start, {*node}, std::nullopt, last);
    if (route.status != RouteStatus::kFound) {
      plan.failure = NavigationFailure::kNoRoute;
      plan.text = "no open edges lead to node " + std::to_string(id);
      return {};
    }
    plan.cost += route.cost;
    for (const std::uint32_t edge : route.edges) {
      add_middle(edge, result);
    }
    const Point2d position = graph_->nodes()[*node].position;
    const double apart = distance(before.position(), position);
    const double heading =
        !route.edges.empty()
            ? along(*graph_, route.edges.back(), graph_->length(route.edges.back())).heading
            : (apart > parameters_.turning_radius
                   ? std::atan2(position.y - before.y, position.x - before.x)
                   : before.heading);
    before = {position.x, position.y, heading};
    result.push_back({.pose = before, .node = id});
    at = node;
  }
  return result;
}

std::vector<Target> GlobalPlanner::Implementation::targets(const PlanRequest& request,
                                                           const TourGoal& goal,
                                                           NavigationPlan& plan,
                                                           const Clock& clock) {
  if (goal.rows.empty()) {
    plan.failure = NavigationFailure::kNoGoals;
    return {};
  }
  std::vector<std::uint32_t> edges;
  for (const std::int64_t id : goal.rows) {
    const auto edge = graph_->edge_of_id(id);
    if (!edge) {
      plan.failure = NavigationFailure::kUnknownEdge;
      plan.text = "edge " + std::to_string(id);
      return {};
    }
    edges.push_back(*edge);
  }
  std::vector<TourRow> rows = tour_rows(*graph_, edges,
                                        goal.as_given     ? RowSides::kAsGiven
                                        : goal.both_sides ? RowSides::kBoth
                                                          : RowSides::kOne);
  const auto id_of = [&](const TourRow& row) { return graph_->edges()[row.edge].id; };
  const auto start = graph_->nearest_node(request.start.position());
  const double begin = clock();
  const auto late = [&] { return clock() - begin >= parameters_.improving_time; };
  Tour tour = plan_tour(routes_, start.value_or(0), rows, late);
  if (tour.status == TourStatus::kRowUnreachable) {
    for (const TourRow& row : tour.unreachable) {
      plan.left_out.push_back(id_of(row));
      std::erase_if(rows, [&](const TourRow& each) { return each.edge == row.edge; });
    }
    tour = plan_tour(routes_, start.value_or(0), rows, late);
  }
  if (rows.empty() || tour.status != TourStatus::kFound) {
    plan.failure = NavigationFailure::kNoRoute;
    plan.text = "no open edges lead along the rows";
    return {};
  }
  plan.cost = tour.cost;
  plan.lower_bound = tour.lower_bound;
  std::vector<Target> result;
  for (const std::uint32_t edge : tour.edges) {
    const auto row = std::find_if(rows.begin(), rows.end(), [&](const TourRow& each) {
      return each.edge == edge || each.opposite == edge;
    });
    if (row == rows.end()) {
      add_middle(edge, result);
      continue;
    }
    result.push_back({.pose = along(*graph_, edge, 0), .required = false});
    result.push_back({.pose = along(*graph_, edge, graph_->length(edge)),
                      .required = false,
                      .row = edge,
                      .row_id = id_of(*row)});
    rows.erase(row);
  }
  // What is behind the last row only leads back to the beginning.
  while (!result.empty() && !result.back().row) {
    result.pop_back();
  }
  return result;
}

void GlobalPlanner::Implementation::drive_through(const Pose2d& start,
                                                  const std::vector<Target>& targets,
                                                  const Clock& clock, NavigationPlan& plan) {
  Pose2d at = start;
  for (const Target& target : targets) {
    const Plan leg = plan_leg(at, target.pose, clock);
    const bool along_row =
        !target.row ||
        leg.path.length() <= kRowDetour * graph_->length(*target.row) + kRowDetourSpare;
    if (leg.status == PlanStatus::kFound && along_row) {
      const double begin = plan.path.length();
      plan.path.append(leg.path);
      const double end = plan.path.length();
      at = target.pose;
      if (target.row) {
        const RouteEdge& row = graph_->edges()[graph_->edge_of_id(target.row_id).value()];
        const bool backwards = graph_->edges()[*target.row].id != target.row_id;
        plan.marks.push_back({.begin = begin,
                              .end = end,
                              .id = target.row_id,
                              .pipe_side = backwards ? mirrored(row.pipe_side) : row.pipe_side,
                              .length = graph_->length(*target.row),
                              .backwards = backwards});
      } else if (target.node) {
        plan.marks.push_back({.begin = end, .end = end, .id = *target.node});
      }
      continue;
    }
    plan.failure =
        leg.status == PlanStatus::kFound ? NavigationFailure::kUnreachable : failure_of(leg.status);
    plan.text = "to " + place(target.pose) + ": " + std::string(text_of(leg.status));
    if (target.required || plan.failure == NavigationFailure::kStartInCollision ||
        plan.failure == NavigationFailure::kStartOutside) {
      plan.path = {};
      return;
    }
    if (target.row) {
      plan.left_out.push_back(target.row_id);
    }
  }
  if (!plan.path.empty()) {
    plan.failure = NavigationFailure::kNone;
    plan.text.clear();
  }
}

/// Near poses directly, others over the graph. Where there is no such path in time, so that the
/// robot comes along an edge that leads the goal's way, and need not turn round beside it.
void GlobalPlanner::Implementation::plan_to_pose(const PlanRequest& request, const PoseGoal& goal,
                                                 const Clock& clock, NavigationPlan& plan) {
  if (!is_finite(goal.pose)) {
    plan.failure = NavigationFailure::kGoalNotFinite;
    return;
  }
  const bool has_graph = !graph_->nodes().empty();
  if (!has_graph || distance(request.start, goal.pose) <= parameters_.direct_distance) {
    drive_through(request.start, targets(request, goal, PoseWay::kDirect, plan), clock, plan);
  } else {
    const auto list = targets(request, goal, PoseWay::kOverGraph, plan);
    if (plan.failure == NavigationFailure::kNone) {
      drive_through(request.start, list, clock, plan);
    }
  }
  if (plan.failure != NavigationFailure::kNoPath || !has_graph) {
    return;
  }
  NavigationPlan along_edge{.number = request.number};
  const auto list = targets(request, goal, PoseWay::kAlongEdge, along_edge);
  if (along_edge.failure == NavigationFailure::kNone) {
    drive_through(request.start, list, clock, along_edge);
  }
  if (along_edge.failure == NavigationFailure::kNone) {
    plan = std::move(along_edge);
  }
}

NavigationPlan GlobalPlanner::Implementation::plan(const PlanRequest& request, const Clock& clock) {
  NavigationPlan plan{.number = request.number};
  if (!is_finite(request.start)) {
    plan.failure = NavigationFailure::kStartOutside;
    return plan;
  }
  see(request.obstacles, request.start);
  routes_.set_time(request.time);
  for (const std::uint32_t edge : closed_) {
    routes_.close(edge);
  }
  if (const auto* pose = std::get_if<PoseGoal>(&request.goal)) {
    plan_to_pose(request, *pose, clock, plan);
    return plan;
  }
  std::vector<Target> list;
  if (const auto* route = std::get_if<RouteGoal>(&request.goal)) {
    list = targets(request, *route, plan);
  } else {
    list = targets(request, std::get<TourGoal>(request.goal), plan, clock);
  }
  if (plan.failure == NavigationFailure::kNone) {
    drive_through(request.start, list, clock, plan);
  }
  return plan;
}

GlobalPlanner::GlobalPlanner(const HybridMap& map, const Footprint& footprint,
                             const GlobalPlannerParameters& parameters) {
  parameters.validate();
  implementation_ = std::make_unique<Implementation>(map, footprint, parameters);
}
GlobalPlanner::~GlobalPlanner() = default;
GlobalPlanner::GlobalPlanner(GlobalPlanner&&) noexcept = default;
GlobalPlanner& GlobalPlanner::operator=(GlobalPlanner&&) noexcept = default;

const RouteGraph& GlobalPlanner::graph() const {
  return implementation_->graph();
}
const OccupancyGrid& GlobalPlanner::grid() const {
  return implementation_->grid();
}
void GlobalPlanner::close_edges(std::span<const std::int64_t> ids) {
  implementation_->set_closed(ids, true);
}
void GlobalPlanner::open_edges(std::span<const std::int64_t> ids) {
  implementation_->set_closed(ids, false);
}
NavigationPlan GlobalPlanner::plan(const PlanRequest& request, const Clock& clock) {
  return implementation_->plan(request, clock);
}

}  // namespace pipescout::navigation
