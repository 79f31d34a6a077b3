// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "pipescout/simulation/eddy_current_signal.hpp"
#include "pipescout/simulation/rack_image.hpp"

namespace pipescout::simulation {

struct RackLightParameters {
  RackLight mean{};            ///< mean light
  double sun_turn = 2e-3;      ///< rad/s, of the sun about rack z, [-1, 1]; the real one: 7e-5
  double cloud_period = 20;    ///< s, mean time from one cloud to the next, [1, 1e6]
  double cloud_depth = 0.7;    ///< share of the sun's light blocked by a cloud, [0, 1]
  double sky_change = 0.15;    ///< largest relative change of the light from the sky, [0, 0.9]
  double gain_change = 0.1;    ///< the same of the camera's gain, [0, 0.9]
  double offset_change = 2.0;  ///< grey levels, largest change of black, [0, 100]

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Varying light over a rack: the sun moves, clouds pass within a second or two, the sky and the
/// camera's gain and black level drift. A closed form of time, the same for a seed.
class ChangingRackLight {
 public:
  /// Throws as RackLightParameters::validate.
  ChangingRackLight(const RackLightParameters& parameters, std::uint64_t seed);

  /// `time`: s, any.
  [[nodiscard]] RackLight at(double time) const;

 private:
  RackLightParameters parameters_;
  Wander cloud_;
  Wander sky_;
  Wander gain_;
  Wander offset_;
};

}  // namespace pipescout::simulation
