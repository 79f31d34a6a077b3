// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/rack_model.hpp"

/// The flight of Lippiello and Cacace's simulation (section V), with the way-points of the set-up
/// that its authors published.
namespace pipescout::rack_study {

inline constexpr double kFramePeriod = 0.04;  ///< s, 25 Hz

/// `count` >= 2 parallel pipes of 10 m, radii 6 and 8 inches by turns, gaps 0.1 m.
[[nodiscard]] rack_vision::RackModel parallel_rack(int count);

/// The first `count`, 2 to 5, pipes of the paper's rack (Figure 5): four parallel ones of radius
/// 0.15 to 0.20 m, the first of which grows from 0.15 to 0.20 m half-way, in a reducer of 0.3 m,
/// gaps 0.10 m, 10 m long; the fifth lies across, on top of them.
[[nodiscard]] rack_vision::RackModel paper_rack(int count = 5);

struct FlightSettings {
  bool gusts = true;
  double wind_at_20_feet = 5;  ///< W20 of MIL-F-8785C, m/s
};

/// The camera along the way-points (x, y, z, yaw): (W/2, 5, 3, 0), (W/2 + 1, 6, 3, 0.2), (W/2 + 1,
/// 4, 3, -0.2), (W/2 + 1, 4, 2.5, -0.2) and back, W being the summed diameters of the pipes along
/// y; at most 0.4 m/s of the 0.5 that the paper allows, so that there is room to fight the wind.
/// The optical axis points at (1, 5, 0) but for the tilt of the vehicle, which gusts shake. One
/// pose per frame, T_camera_rack; the same seed gives the same bits.
[[nodiscard]] std::vector<geometry::SE3> paper_flight(const rack_vision::RackModel& model,
                                                      const FlightSettings& settings,
                                                      std::uint64_t seed);

}  // namespace pipescout::rack_study
