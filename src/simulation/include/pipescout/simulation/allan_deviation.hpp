// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// Allan deviation of a recorded signal with its confidence, to identify the noise of an inertial
/// sensor. W. J. Riley, "Handbook of Frequency Stability Analysis", NIST Special Publication 1065,
/// 2008.
namespace pipescout::simulation {

/// Dominant noise at one averaging time.
enum class AllanNoise : std::uint8_t {
  kWhite,       ///< slope -1/2
  kFlicker,     ///< slope 0
  kRandomWalk,  ///< slope +1/2
};

/// Overlapping Allan deviation, of averages over `cluster` samples (equation 9 there): square root
/// of half the mean squared difference of neighbouring averages; in the unit of the samples.
/// Throws std::invalid_argument unless 1 <= cluster and 2 * cluster <= samples.
[[nodiscard]] double allan_deviation(std::span<const double> samples, std::size_t cluster);

/// Equivalent degrees of freedom of the square of the above (table 5 there): degrees * deviation^2
/// / true variance is approximately chi-square distributed with this number. Throws as above.
[[nodiscard]] double allan_degrees_of_freedom(AllanNoise noise, std::size_t samples,
                                              std::size_t cluster);

}  // namespace pipescout::simulation
