// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string_view>

#include "pipescout/navigation_maps/footprint.hpp"
#include "pipescout/navigation_maps/occupancy_grid.hpp"
#include "pipescout/navigation_maps/path.hpp"
#include "pipescout/planning/motion_primitives.hpp"

namespace pipescout::navigation {

struct LatticeSettings {
  double reverse_factor = 1.5;  ///< cost of a metre in reverse, in metres forwards, [1, 100]
  double cusp_cost = 1;         ///< m, for each change of direction, [0, 1000]
  double steering_cost = 0.05;  ///< m, for each change of the curvature, [0, 1000]
  double nearness_factor = 1;   ///< added to the cost of a metre at an obstacle, [0, 100]
  double near = 0.5;            ///< m, clearance of the origin beyond its inscribed radius from
                                ///< which on nearness costs nothing, (0, 10]
  UnknownCells unknown = UnknownCells::kBlocked;
  double step = 0.05;                     ///< m between poses of the path, (0, 1]
  std::size_t most_expansions = 200'000;  ///< of one search

  /// Throws std::invalid_argument that names the field.
  void validate() const;
};

enum class PlanStatus {
  kFound,
  kStartNotFinite,
  kGoalNotFinite,
  kStartOutside,  ///< of the grid
  kGoalOutside,
  kStartInCollision,
  kGoalInCollision,
  kUnreachable,  ///< proven: no disc within the footprint can be moved there
  kNotFound,     ///< the lattice holds no path, or none within `most_expansions`
  kStopped,      ///< told to stop before there was a path
};

/// In words, for a log.
[[nodiscard]] std::string_view text_of(PlanStatus status);

struct Plan {
  PlanStatus status = PlanStatus::kNotFound;
  Path path;               ///< from start to goal, both exactly; empty unless kFound
  double cost = 0;         ///< m, as LatticeSettings weighs it
  double lower_bound = 0;  ///< m; no path that the robot can drive costs less
  /// cost / lower_bound, at least 1: the best path costs at least cost / suboptimality.
  double suboptimality = 1;
  std::size_t expansions = 0;
  bool reused = false;  ///< (part of) the last plan was used
};

struct CellChange {
  Cell cell;
  CellState state = CellState::kUnknown;
};

/// Asked often, about every 0.1 ms and at least every 1 ms: true ends the planning with the best
/// path so far.
using ShouldStop = std::function<bool()>;
/// Told of each better path as it is found.
using OnPath = std::function<void(const Path&, double cost)>;

/// Paths over x, y and heading for an Ackermann robot: forwards, in reverse and with cusps, from a
/// start to a goal that are met exactly, also in heading. Weighted A* over a state lattice
/// (Pivtoraiko, Knepper and Kelly, "Differentially constrained mobile robot motion planning in
/// state lattices", 2009) that lies in the frame of the start; analytic expansion by Reeds-Shepp
/// paths to the goal (Dolgov and others, "Path planning for autonomous vehicles in unknown
/// semi-structured environments", 2010). The first path is then shortened, and searched for anew
/// with smaller weights (after Likhachev and others, "ARA*", 2003), until told to stop or nothing
/// is left.
///
/// Heuristics: the Reeds-Shepp length, and the distance over a grid on which a disc inside the
/// footprint moves. Both bound the length of any path from below, which is proven
/// (docs/decisions/lower-bound-by-a-lipschitz-function.md); costs are at least lengths. Paths stay
/// in the grid.
/// Not thread-safe.
class LatticePlanner {
 public:
  /// Throws std::invalid_argument for primitives or settings that are not valid.
  LatticePlanner(OccupancyGrid grid, Footprint footprint, LatticePrimitives primitives,
                 const LatticeSettings& settings = {});
  ~LatticePlanner();
  LatticePlanner(LatticePlanner&&) noexcept;
  LatticePlanner& operator=(LatticePlanner&&) noexcept;

  [[nodiscard]] const OccupancyGrid& grid() const;
  /// What sensors have seen since. Costs as much as the area changed. Throws std::invalid_argument
  /// for a cell outside; then nothing is changed.
  void change(std::span<const CellChange> cells);

  /// Both poses are T_map_robot.
  [[nodiscard]] Plan plan(const Pose2d& start, const Pose2d& goal, const ShouldStop& should_stop,
                          const OnPath& on_path = {});
  /// To the goal of the last plan, from wherever the robot is now: the rest of the last path where
  /// it is still free, led around what blocks it, or planned anew. Returns the first path it finds,
  /// and kNotFound if there was no plan.
  [[nodiscard]] Plan replan(const Pose2d& start, const ShouldStop& should_stop);

  /// Whether the footprint is free all along the path, between its poses too. What comes within a
  /// micrometre of an obstacle may be said to collide.
  [[nodiscard]] bool is_free(const Path& path) const;

 private:
  class Search;
  std::unique_ptr<Search> search_;
};

}  // namespace pipescout::navigation
