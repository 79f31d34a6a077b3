// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "pipescout/simulation/thermal_scene.hpp"
#include "thermal_band.hpp"
#include "thermal_radiation.hpp"

namespace pipescout::simulation::internal {

/// What the tube of a scene looks like along itself, in counts.
class ThermalTube {
 public:
  /// Throws std::invalid_argument where a temperature has no counts.
  ThermalTube(const ThermalScene& scene, const ThermalRadiation& radiation);

  /// The tube between two places, of a camera at `camera_place`, `distance` m from the tube, whose
  /// image moves by `blur` m along it.
  void sample(double least, double most, double blur, double camera_place, double distance,
              std::span<BandSample> samples) const noexcept;

  /// Counts of an object temperature.
  [[nodiscard]] float counts(double temperature) const noexcept;

 private:
  struct Spot {
    double from = 0;
    double to = 0;
    float counts = 0;
    float strength = 1;  // [0, 1]
  };
  static void put(const Spot& spot, double least, double step, double blur,
                  std::span<BandSample> samples) noexcept;
  [[nodiscard]] Spot joint_spot(const ThermalJoint& joint, double camera_place,
                                double distance) const noexcept;
  [[nodiscard]] Spot passing_spot(const ThermalDecoy& decoy, double camera_place) const noexcept;
  /// Integral of the counts from the beginning of the tube, counts m.
  [[nodiscard]] double integral(double place) const noexcept;

  const ThermalScene& scene_;
  double lowest_ = 0;              // degC, of the table
  std::vector<float> of_degrees_;  // counts by object temperature
  std::vector<double> integral_;   // at steps along the tube
};

}  // namespace pipescout::simulation::internal
