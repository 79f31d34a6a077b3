// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "pipescout/estimation/factors.hpp"

namespace pipescout::estimation {

/// The centre line of a pipe as a polyline in the map, m. Chainage is the length along it from its
/// first point, plus that of the first point.
class PipeCentreLine {
 public:
  /// Throws std::invalid_argument when there are fewer than 2 points, one is not finite, two
  /// neighbours are nearer than 1e-6 m, or `first_chainage` is not finite.
  explicit PipeCentreLine(std::vector<Eigen::Vector3d> points, double first_chainage = 0);

  struct Place {
    Eigen::Vector3d position;
    Eigen::Vector3d direction;  ///< unit, towards greater chainage
  };
  /// Nothing beyond the ends and for NaN. At a vertex the direction is that of the later segment.
  [[nodiscard]] std::optional<Place> at(double chainage) const noexcept;

  /// Chainage of the point of the line nearest to a position, m in the map, searched from an
  /// approximate chainage (within a metre or two in bends). Within the ends; NaN for a position
  /// that is not finite.
  [[nodiscard]] double chainage_of(const Eigen::Vector3d& position, double nearby) const noexcept;

  /// The sensor at `sensor` (m, in the body) passed the weld at `chainage` at `time`. The standard
  /// deviations are those of the chainage and of the sensor's distance from the centre line, m.
  /// Nothing as for `at`.
  [[nodiscard]] std::optional<WeldMeasurement> weld(double time, double chainage,
                                                    double along_deviation, double across_deviation,
                                                    const Eigen::Vector3d& sensor) const noexcept;

  [[nodiscard]] double first_chainage() const noexcept { return chainages_.front(); }
  [[nodiscard]] double last_chainage() const noexcept { return chainages_.back(); }

 private:
  std::vector<Eigen::Vector3d> points_;
  std::vector<double> chainages_;
};

}  // namespace pipescout::estimation
