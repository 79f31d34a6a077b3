// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <pipescout/plant_world/plant_drive.hpp>
#include <pipescout/simulation/thermal_patrol.hpp>
#include <string>
#include <vector>

#include "pipescout/runtime/bound_parameters.hpp"
#include "pipescout/runtime/parameters.hpp"

namespace pipescout {

/// Parameters of a patrol that a navigator drives through a plant of several rows.
class PlantParameters {
 public:
  /// Declares them.
  explicit PlantParameters(Parameters& parameters);

  /// Whether there is a plant; otherwise the robot drives by itself along one row.
  [[nodiscard]] bool given() const { return rows_.get() > 0; }
  /// Throws std::invalid_argument naming the parameter.
  [[nodiscard]] simulation::PlantDriveParameters drive(std::uint64_t seed, double row_length) const;
  /// Sets up the rows of the plant like `patrol.scene`, with the leaks on theirs, and the robot as
  /// a vehicle with Ackermann steering at the start. The collectors at both sides of every second
  /// aisle face each other across it. Throws std::invalid_argument naming the parameter.
  void lay_out(const simulation::PlantDriveParameters& plant,
               const std::vector<simulation::ThermalLeak>& leaks,
               simulation::ThermalPatrolParameters& patrol) const;
  [[nodiscard]] std::string map_folder() const { return map_folder_.get(); }
  /// Edges of the route graph.
  [[nodiscard]] std::vector<std::int64_t> tour() const { return tour_.get(); }
  [[nodiscard]] bool with_tour() const { return with_tour_.get(); }
  [[nodiscard]] double time_limit() const { return time_limit_.get(); }  ///< of it; s, simulated
  /// s, simulated, of a patrol that no tour ends; 0: until it is stopped.
  [[nodiscard]] double duration() const { return duration_.get(); }

 private:
  BoundParameters<simulation::PlantDriveParameters> declared_;
  Parameter<std::int64_t> rows_;
  Parameter<std::vector<double>> obstacles_;
  Parameter<std::vector<double>> start_;
  Parameter<std::vector<std::int64_t>> leak_rows_;
  Parameter<std::string> map_folder_;
  Parameter<std::vector<std::int64_t>> tour_;
  Parameter<bool> with_tour_;
  Parameter<double> time_limit_;
  Parameter<double> duration_;
};

}  // namespace pipescout
