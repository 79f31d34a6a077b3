// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/thermal/radiometry.hpp"

namespace pipescout::simulation::internal {

/// What reaches the simulated camera, in its counts. Of package thermal only the plain structs of
/// parameters are used: no formula of what is tested is in the pictures that test it.
///
/// The sensor sees Planck's law at one wavelength, with a gain; the air follows Beer and Lambert,
/// with an extinction that grows with the water in it; the window absorbs at its own temperature.
class ThermalRadiation {
 public:
  ThermalRadiation(const thermal::CameraConstants& camera, const thermal::ObjectParameters& object);

  /// Counts of a black body before the lens, degC, and their derivative, 1/K. NaN at or below
  /// absolute zero.
  [[nodiscard]] double black_body(double temperature) const noexcept;
  [[nodiscard]] double slope(double temperature) const noexcept;
  /// Counts of the object with what it reflects, behind air and window.
  [[nodiscard]] double object(double temperature) const noexcept;

 private:
  double gain_ = 0;
  double wave_ = 0;  // K: second radiation constant over the wavelength
  double bias_ = 0;  // counts
  double shape_ = 1;
  double of_object_ = 1;  // share of the object's own radiation in what arrives
  double of_others_ = 0;  // counts of all others
};

}  // namespace pipescout::simulation::internal
