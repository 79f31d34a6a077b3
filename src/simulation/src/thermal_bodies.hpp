// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/simulation/thermal_scene.hpp"
#include "thermal_band.hpp"
#include "thermal_radiation.hpp"
#include "thermal_tube.hpp"

namespace pipescout::simulation::internal {

/// What stands before the background: frames and image of the mirrors, hot bodies, pipes from
/// swivel joints, the tube, posts; those behind first.
class ThermalBodies {
 public:
  /// Both arguments must live as long. Throws std::invalid_argument where a temperature has no
  /// counts.
  ThermalBodies(const ThermalScene& scene, const ThermalRadiation& radiation, int height);

  void paint(const ThermalEye& eye, CountPlane& plane);

  [[nodiscard]] static bool is_seen(const ThermalDecoy& decoy, const ThermalEye& eye);
  [[nodiscard]] float counts_of(const ThermalDecoy& decoy) const;

 private:
  void paint_mirrors(const ThermalEye& eye, CountPlane& plane);
  void paint_behind(const ThermalEye& eye, CountPlane& plane);
  void paint_tube(const ThermalEye& eye, CountPlane& plane);
  void paint_posts(const ThermalEye& eye, CountPlane& plane);
  /// A straight cylinder that looks the same all along, from `from` on its axis to `to`.
  void paint_cylinder(const ThermalEye& eye, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                      double radius, float counts, CountPlane& plane);

  const ThermalScene& scene_;
  ThermalTube tube_;
  BandPainter painter_;
  float cold_post_;
  float seam_;
  float gap_;
};

}  // namespace pipescout::simulation::internal
