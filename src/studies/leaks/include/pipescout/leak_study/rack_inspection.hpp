// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipescout/rack_vision/rack_model.hpp"
#include "pipescout/simulation/rack_thermal.hpp"

/// Thermal inspection of a pipe rack from the air: broken insulation and pipes that are too warm.
/// SI units, degrees Celsius; frame `rack` of rack_model.hpp.
namespace pipescout::leak_study {

struct RackInspectionSettings {
  std::size_t hot_spots = 3;  ///< [0, 8]
  double offset_deviation =
      0.012;                     ///< m, [0, 0.05]: of the pipes from where the rack file has them
  double wind_at_20_feet = 5.0;  ///< W20 of MIL-F-8785C, m/s, [0, 10]
  double longest = 120;          ///< s, [1, 600]: after which the flight ends in any case

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct RackInspectionScore {
  std::size_t hot_spots = 0;
  std::size_t found = 0;
  std::size_t false_findings = 0;         ///< raised without a hot spot, and duplicates
  std::vector<double> position_errors{};  ///< m, of those found
  std::vector<simulation::HotSpot> missed{};
  std::size_t covered = 0;    ///< of those found: truth inside the 95 % ellipsoid of the position
  std::size_t images = 0;     ///< of the camera that localises
  std::size_t with_pose = 0;  ///< of them: tracked
  std::size_t thermal_images = 0;
  std::size_t placed = 0;  ///< of them: with a pose of the estimator in the map
  bool complete = false;   ///< all way-points were reached
};

/// Broken insulation (12 to 30 K over 0.25 to 0.6 m, on the upper side) and pipes that are too warm
/// (9 to 15 K all round over 0.5 to 1 m) on the rack of rack_study::rack_on_beams, each within view
/// of the flight, not where the pipe across hides it, and at least 0.6 m from others on its pipe.
[[nodiscard]] std::vector<simulation::HotSpot> draw_hot_spots(const rack_vision::RackModel& model,
                                                              std::size_t count,
                                                              std::uint64_t seed);

/// From the middle of a hot spot to a point. All round the pipe, the middle is a ring: from its
/// nearest point.
[[nodiscard]] Eigen::Vector3d position_error(const simulation::HotSpot& spot,
                                             const rack_vision::RackModel& model,
                                             const Eigen::Vector3d& point);

/// One flight in gusts along the rack and back, of which all is simulated: images are rendered,
/// tracked and steer the UAV; their poses and the IMU go to the state estimator; what the detector
/// finds in thermal images is placed by the estimator's pose on the pipes of the rack file, moved
/// by the offsets that the tracker has found. A finding is of the hot spot whose middle is within
/// 0.5 m. The same arguments give the same bits. Throws as RackInspectionSettings::validate.
[[nodiscard]] RackInspectionScore inspect_rack(const RackInspectionSettings& settings,
                                               std::uint64_t seed);

}  // namespace pipescout::leak_study
