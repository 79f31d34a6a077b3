// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pipescout/move_base/global_planner.hpp"
#include "pipescout/move_base/move_base.hpp"
#include "pipescout/runtime/bound_parameters.hpp"
#include "pipescout/runtime/parameters.hpp"

namespace pipescout {

/// Configuration of the component.
struct NavigatorSettings {
  navigation::HybridMap map;
  std::vector<std::string> map_remarks;  ///< of read_grid and read_route_graph
  navigation::Footprint footprint;
  navigation::MoveBaseParameters base;
  navigation::GlobalPlannerParameters planner;
  std::string map_frame;
  std::string base_frame;
  navigation::Pose2d T_base_lidar;
  std::int64_t planning_readings = 0;
  double steering_speed = 0;  ///< m/s
  bool one_sided = false;     ///< the camera looks to one side only
};

/// The parameters of the component: docs/components/navigator.md.
class NavigatorParameters {
 public:
  /// Declares them.
  explicit NavigatorParameters(Parameters& parameters);

  /// Reads the files of the map. Throws std::invalid_argument naming the parameter, and what
  /// read_grid and read_route_graph throw.
  [[nodiscard]] NavigatorSettings read() const;
  /// Ids of edges that nothing drives along; may change at any time.
  [[nodiscard]] std::vector<std::int64_t> closed_edges() const { return closed_edges_.get(); }
  [[nodiscard]] const std::string& closed_edges_name() const { return closed_edges_.name(); }

 private:
  void declare_map(Parameters& parameters);
  void declare_vehicle();
  void declare_obstacles();
  void declare_inputs();
  void declare_inspection();
  void declare_planning();

  BoundParameters<navigation::MoveBaseParameters> base_;
  BoundParameters<navigation::GlobalPlannerParameters> planner_;
  Parameter<std::string> map_file_;
  Parameter<std::string> graph_file_;
  Parameter<std::string> map_frame_;
  Parameter<std::string> base_frame_;
  Parameter<std::vector<double>> footprint_;
  Parameter<std::vector<double>> lidar_pose_;
  Parameter<std::vector<std::int64_t>> closed_edges_;
  Parameter<std::int64_t> planning_readings_;
  Parameter<double> steering_speed_;
  Parameter<bool> one_sided_;
};

}  // namespace pipescout
