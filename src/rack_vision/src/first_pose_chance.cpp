// SPDX-License-Identifier: Apache-2.0
#include "first_pose_chance.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::rack_vision::internal {

double false_alarms(const Evidence& evidence, std::size_t lines, std::size_t pipes, double rms,
                    const geometry::Camera& camera) {
  constexpr double kPlausible = 0.02;  // share of assignments that put the camera over the rack
  const auto triples = [](std::size_t count) {
    const auto n = static_cast<double>(count);
    return n * (n - 1) * (n - 2) / 6;
  };
  const std::size_t others = std::max(evidence.visible_contours, evidence.contours) - 3;
  const std::size_t met = evidence.contours - 3;
  const double extent =
      std::sqrt(static_cast<double>(camera.parameters().width) * camera.parameters().height);
  const double chance =
      std::min(1 - 1e-9, static_cast<double>(lines) * 2 * std::max(0.5, 2 * rms) / extent);
  double tail = 0;
  double term = std::pow(1 - chance, static_cast<double>(others));
  for (std::size_t k = 0; k <= others; ++k) {
    tail += k >= met ? term : 0;
    term *= static_cast<double>(others - k) / static_cast<double>(k + 1) * chance / (1 - chance);
  }
  return kPlausible * triples(lines) * triples(2 * pipes) * tail;
}

}  // namespace pipescout::rack_vision::internal
