// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/thermal/leak_detector.hpp"
#include "pipescout/thermal/temperature_table.hpp"

namespace pipescout::benchmarks {

/// Frames of a robot that drives along a row of collectors at 20 km/h, 25 a second, with a leak
/// that passes through the picture, joints and posts.
struct ThermalRecording {
  geometry::Camera camera{};
  thermal::TemperatureTable table{1.0, 0.0};
  struct Shot {
    std::vector<std::uint16_t> counts;
    geometry::SE3 T_map_camera{};
  };
  std::vector<Shot> shots;

  [[nodiscard]] thermal::CountView view(std::size_t shot) const;
  /// With poses that are 0.1 m and 0.5 degrees uncertain. Frames of later rounds through the
  /// recording follow each other in time.
  [[nodiscard]] leak_findings::Frame frame(std::size_t round, std::size_t shot) const;
};

/// 640x512, or 320x240. The same seed, the same bits.
[[nodiscard]] ThermalRecording thermal_recording(bool large, std::uint64_t seed);

[[nodiscard]] thermal::LeakDetectorParameters thermal_detector_parameters();
[[nodiscard]] leak_findings::LeakFindingsParameters thermal_findings_parameters();

}  // namespace pipescout::benchmarks
