// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace pipescout::simulation::internal {

/// Radiance of a black body in the band of 8 to 14 um, W/(m^2 sr), by Planck's law, and back.
class BandRadiance {
 public:
  BandRadiance();
  /// `celsius` is clamped to -100 ... 700.
  [[nodiscard]] double of(double celsius) const noexcept;
  /// degC of the black body with that radiance, clamped likewise.
  [[nodiscard]] double temperature(double radiance) const noexcept;

 private:
  std::vector<double> table_;
};

}  // namespace pipescout::simulation::internal
