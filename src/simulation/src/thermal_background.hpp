// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "pipescout/simulation/thermal_scene.hpp"
#include "thermal_band.hpp"
#include "thermal_radiation.hpp"

namespace pipescout::simulation::internal {

/// Mirrors of parabolic troughs, in the row: they face the tube.
inline constexpr double kMirrorBehind = 1.7;      // m, behind the tube
inline constexpr double kMirrorHalfHeight = 2.9;  // m, above and below the tube

/// Sky, ground and the mirrors, which go on beyond the ends of the tube. Their grain is that of a
/// table that moves with what is 10 m away, by whole pixels.
class ThermalBackground {
 public:
  ThermalBackground(const ThermalSceneParameters& scene, const ThermalRadiation& radiation,
                    int width);
  void paint(const ThermalEye& eye, CountPlane& plane) const noexcept;

 private:
  double tube_height_;
  float sky_;
  float horizon_;  // sky where it meets the ground
  float ground_;
  float mirror_;
  float mirror_change_;
  int grain_columns_;  // that repeat; a row holds `width` more
  std::vector<float> grain_;
};

}  // namespace pipescout::simulation::internal
