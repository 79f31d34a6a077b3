// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "pipescout/navigation_maps/path.hpp"
#include "pipescout/navigation_maps/pose2d.hpp"
#include "pipescout/navigation_maps/route_graph.hpp"

namespace pipescout::navigation {

/// A pose in the map, position and heading.
struct PoseGoal {
  Pose2d pose;
};
/// To the nodes of the route graph with these ids, one after the other.
struct RouteGoal {
  std::vector<std::int64_t> nodes;
};
/// Along the edges of the route graph with these ids, in the cheapest order.
struct TourGoal {
  std::vector<std::int64_t> rows;
  bool both_sides = false;  ///< each row there and back
  bool as_given = false;    ///< each in the direction of its edge; excludes `both_sides`
};
using NavigationGoal = std::variant<PoseGoal, RouteGoal, TourGoal>;

/// Why a goal was not reached. Closed: nothing else ends one without success.
enum class NavigationFailure {
  kNone,
  kGoalNotFinite,
  kGoalOutside,       ///< of the map
  kGoalInCollision,   ///< with the map
  kStartOutside,      ///< the robot is outside the map
  kStartInCollision,  ///< the robot stands in an obstacle, by the map and its localisation
  kUnknownNode,       ///< the route graph has no such node
  kUnknownEdge,       ///< or no such edge
  kNoGoals,           ///< a route without nodes, a tour without rows
  kNoRoute,           ///< no open edges lead there
  kUnreachable,       ///< proven: the robot cannot be moved there
  kNoPath,            ///< none was found in the time and effort allowed
  kBlocked,           ///< the path stayed blocked through all plans
  kGoalMissed,        ///< all attempts to come to its pose and heading failed
  kLocalisationLost,  ///< stale, missing or uncertain for too long
  kScanLost,          ///< stale, missing or frozen for too long
  kPreempted,         ///< by another goal
  kCanceled,
};
[[nodiscard]] const char* to_string(NavigationFailure failure);

/// Where on a path a row or a node of the goal is.
struct PlanMark {
  double begin = 0;  ///< m of arc length
  double end = 0;    ///< m; of a node: the same
  std::int64_t id = 0;
  PipeSide pipe_side = PipeSide::kNone;  ///< as the robot drives
  double length = 0;                     ///< m, of the row's edge
  bool backwards = false;                ///< from the end of that edge to its start
};

/// What the global planner has to find.
struct PlanRequest {
  std::uint64_t number = 0;        ///< the answer has the same
  Pose2d start;                    ///< where the robot stands
  NavigationGoal goal;             ///< what is left of it
  double time = 0;                 ///< s, of the plant: edges closed until then are open
  bool straight_approach = false;  ///< a pose is to be come to straight on: it was missed before
  std::vector<Point2d> obstacles;  ///< seen, m in the map: centres of cells that are not free
};

/// A path through all of the goal, or why there is none.
struct NavigationPlan {
  std::uint64_t number = 0;
  NavigationFailure failure = NavigationFailure::kNone;
  std::string text;  ///< says what failed where, for people
  Path path;
  std::vector<PlanMark> marks;         ///< in the order of driving
  std::vector<std::int64_t> left_out;  ///< rows that cannot be driven along
  double cost = 0;                     ///< of the route or tour over the graph
  double lower_bound = 0;              ///< no such tour costs less
};

}  // namespace pipescout::navigation
