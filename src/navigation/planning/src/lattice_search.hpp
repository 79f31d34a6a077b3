// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "arc_list.hpp"
#include "footprint_sweep.hpp"
#include "grid_distance.hpp"
#include "state_set.hpp"

namespace pipescout::navigation {

/// One weighted A* search over the lattice in the frame of its start. Edges are checked for
/// collisions only when they are taken up (Cohen and others, "Planning single-arm manipulations
/// with n-arm robots", 2015, lazy weighted A*).
class LatticeSearch {
 public:
  LatticeSearch(LatticePrimitives primitives, const LatticeSettings& settings,
                const FootprintSweep& sweep);

  struct Query {
    Pose2d start;
    Pose2d goal;
    const GridDistance* to_goal;  ///< null: the straight line alone
    double weight;
    std::size_t most_expansions;
    double below;    ///< only paths that cost less are of use
    bool backwards;  ///< the path is driven from goal to start in the end
  };
  struct Result {
    std::optional<ArcList> arcs;  ///< the first found
    std::size_t expansions = 0;
    bool stopped = false;
    bool exhausted = false;  ///< there is none in the lattice
  };
  [[nodiscard]] Result search(const Query& query, const ShouldStop& should_stop);

  [[nodiscard]] double cost(const Pose2d& start, const ArcList& arcs) const;
  [[nodiscard]] double radius() const { return radius_; }

 private:
  struct Motion {
    int columns;
    int rows;
    int end_heading;
    bool reverse;
    int first_turn;  ///< sign of the curvature where it begins
    int last_turn;
    double length;
    ArcList arcs;
  };
  /// Taken up, with the way it was reached.
  struct Node {
    int column;
    int row;
    int heading;
    std::int32_t parent;  ///< -1: the start
    const Motion* motion;
    double cost;
    double rest;  ///< bound of the way on
  };
  /// Waits to be taken up.
  struct Candidate {
    double key;
    double cost;
    double rest;
    std::int32_t parent;
    bool refined;  ///< the rest accounts for the headings
    const Motion* motion;
  };

  void lay_out(const Pose2d& start);
  [[nodiscard]] Pose2d pose_of(int column, int row, int heading) const;
  [[nodiscard]] static double bound_of_position(const Query& query, const Pose2d& pose);
  [[nodiscard]] double bound_of_pose(const Query& query, const Pose2d& pose, double bound) const;
  [[nodiscard]] std::optional<ArcList> expand_analytically(const Query& query, const Node& node,
                                                           std::size_t expansions,
                                                           const ShouldStop& should_stop) const;
  [[nodiscard]] double step_cost(const Query& query, const Node& from, const Motion& motion) const;
  [[nodiscard]] ArcList arcs_to(std::int32_t node) const;
  void push(const Query& query, const Candidate& candidate);
  void add_neighbours(const Query& query, std::int32_t index);
  /// The best candidate that can be driven to becomes a node; nothing if none is left, or stopped.
  [[nodiscard]] std::optional<std::int32_t> take_up_best(const Query& query,
                                                         const ShouldStop& should_stop,
                                                         bool& stopped);

  std::vector<double> headings_;
  std::vector<std::vector<Motion>> motions_;  ///< of each heading
  double radius_;
  double spacing_;
  LatticeSettings settings_;
  const FootprintSweep& sweep_;
  // Where the lattice of the query lies.
  Pose2d origin_;
  Point2d column_step_;  ///< m
  std::vector<double> headings_in_map_;
  std::vector<Node> nodes_;
  std::vector<Candidate> open_;
  StateSet seen_;  ///< states that were taken up
};

}  // namespace pipescout::navigation
