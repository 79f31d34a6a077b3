// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/gravity.hpp"

#include <cmath>
#include <numbers>

#include "pipescout/validation/check.hpp"

namespace pipescout::estimation {

Earth Earth::at_latitude(double latitude) {
  constexpr double kSemiMajorAxis = 6378137.0;  // m
  constexpr double kEccentricitySquared = 6.69437999014e-3;
  constexpr double kRate = 7.292115e-5;  // rad/s
  validation::check_within("latitude", latitude, -90, 90);
  const double angle = latitude * std::numbers::pi / 180;
  const double sine = std::sin(angle);
  const double part = 1 - kEccentricitySquared * sine * sine;
  const double prime_vertical = kSemiMajorAxis / std::sqrt(part);
  return {.radii = {prime_vertical, prime_vertical * (1 - kEccentricitySquared) / part},
          .rate = kRate * Eigen::Vector3d(0, std::cos(angle), sine)};
}

void Earth::validate() const {
  constexpr double kLeastRadius = 6e6;
  constexpr double kLargestRadius = 7e6;
  constexpr double kLargestRate = 1e-4;
  if (!radii.isZero(0)) {
    for (const double radius : radii) {
      validation::check_within("earth.radii", radius, kLeastRadius, kLargestRadius);
    }
  }
  for (const double part : rate) {
    validation::check_within("earth.rate", part, -kLargestRate, kLargestRate);
  }
}

}  // namespace pipescout::estimation
