// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "pipescout/statistics/draw.hpp"

namespace pipescout::simulation {

struct LocalisationErrorParameters {
  double position_sigma = 0.02;  ///< m, [0, 10]: of each axis
  double heading_sigma = 0.005;  ///< rad, [0, 1]
  double correlation_time = 20;  ///< s, (0, 1e4]
  double white_share = 0.1;      ///< [0, 10]: uncorrelated noise, as a share of the sigmas

  /// Throws std::invalid_argument that names the field.
  void validate() const;
};

/// Errors of the pose that a localisation gives: a Gauss-Markov process of first order with white
/// noise on top (Gelb, "Applied optimal estimation", 1974, section 2.2).
class LocalisationErrors {
 public:
  struct Error {
    double x = 0;  ///< m, in the map
    double y = 0;
    double heading = 0;  ///< rad
  };

  /// Throws std::invalid_argument.
  LocalisationErrors(const LocalisationErrorParameters& parameters, std::uint64_t seed);

  /// After `dt` s, at least 0.
  Error next(double dt);

 private:
  LocalisationErrorParameters parameters_;
  statistics::Draw draw_;
  std::array<double, 3> drift_{};  ///< of x, y and heading, in sigmas
};

}  // namespace pipescout::simulation
