// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pipescout/simulation/thermal_camera.hpp"
#include "thermal_band.hpp"
#include "thermal_radiation.hpp"

namespace pipescout::simulation::internal {

/// A square of pixels that show at least so much.
struct HotSquare {
  int x = 0;
  int y = 0;
  int size = 0;
  float counts = 0;
};

/// From counts before the sensor to what it says: noise, dead pixels, saturation, 16 bits.
class ThermalSensor {
 public:
  ThermalSensor(const ThermalCameraParameters& parameters, const ThermalRadiation& radiation,
                float highest);

  void read(CountPlane& plane, std::uint64_t frame, std::span<const HotSquare> hot,
            std::span<std::uint16_t> counts) const noexcept;

 private:
  struct DeadPixel {
    std::size_t index = 0;
    std::uint16_t counts = 0;
  };
  std::uint64_t seed_;
  float highest_;
  float deviation_;             // counts
  std::vector<float> pattern_;  // counts, of each pixel
  std::vector<float> normals_;
  std::vector<DeadPixel> dead_;
};

}  // namespace pipescout::simulation::internal
