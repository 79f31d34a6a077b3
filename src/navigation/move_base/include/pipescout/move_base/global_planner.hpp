// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "pipescout/move_base/navigation_goal.hpp"
#include "pipescout/navigation_maps/footprint.hpp"
#include "pipescout/navigation_maps/hybrid_map.hpp"
#include "pipescout/planning/lattice_planner.hpp"

namespace pipescout::navigation {

struct GlobalPlannerParameters {
  /// m, (0, 1000]: larger than the vehicle's own, so that there is steering left to correct with.
  double turning_radius = 2.6;
  double spacing = 0.3;  ///< m, (0, turning_radius / 2]: of the lattice
  /// m, [0, 2]: around the footprint; where there is no path with it, another is planned without.
  /// Larger than the local planner's, by what the robot strays from its path.
  double margin = 0.35;
  double direct_distance = 50;  ///< m, [0, 1e4]: nearer poses are planned for without the graph
  double first_time = 2;  ///< s, (0, 60]: after which planning to a target without a path ends
  double improving_time = 0.1;  ///< s, [0, 60]: for which a first path is improved
  LatticeSettings lattice{.reverse_factor = 2, .cusp_cost = 2};

  /// Throws std::invalid_argument that names the field.
  void validate() const;
};

/// Plans over a hybrid map in two steps (Ibarguren and others, "Thermal Tracking in Mobile Robots
/// for Leak Inspection Activities", 2013, section 4.2): a route or tour over the graph, then
/// feasible paths over the grid, from target to target. Targets are the ends of rows, the nodes of
/// the goal, and the middle of each edge in between; of these last a blocked one is left out. Not
/// thread-safe.
class GlobalPlanner {
 public:
  /// s, from any instant on; read often. A count of its readings gives the same plans on every
  /// machine.
  using Clock = std::function<double()>;

  /// A map without nodes is one of poses only. Throws std::invalid_argument.
  GlobalPlanner(const HybridMap& map, const Footprint& footprint,
                const GlobalPlannerParameters& parameters);
  ~GlobalPlanner();
  GlobalPlanner(GlobalPlanner&&) noexcept;
  GlobalPlanner& operator=(GlobalPlanner&&) noexcept;

  [[nodiscard]] const RouteGraph& graph() const;
  [[nodiscard]] const OccupancyGrid& grid() const;
  /// Edges by their ids, in both directions. Ids that are not there are ignored.
  void close_edges(std::span<const std::int64_t> ids);
  void open_edges(std::span<const std::int64_t> ids);

  [[nodiscard]] NavigationPlan plan(const PlanRequest& request, const Clock& clock);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::navigation
