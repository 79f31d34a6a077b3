// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

/// Draws that are the same with every standard library, unlike the distributions of <random>.
namespace pipescout::simulation::internal {

/// [0, 1)
inline double uniform(std::mt19937_64& engine) {
  return static_cast<double>(engine() >> 11U) * 0x1p-53;
}

inline double uniform(std::mt19937_64& engine, double low, double high) {
  return low + (high - low) * uniform(engine);
}

/// Mean 0, standard deviation 1 (Box and Muller; one of the pair is used).
inline double normal(std::mt19937_64& engine) {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform(engine)));
  return radius * std::cos(2.0 * std::numbers::pi * uniform(engine));
}

/// Mean 1.
inline double exponential(std::mt19937_64& engine) {
  return -std::log(1.0 - uniform(engine));
}

/// Engines of one seed that have nothing to do with each other.
inline std::mt19937_64 make_engine(std::uint64_t seed, std::uint64_t purpose) {
  std::seed_seq sequence{seed & 0xffffffffU, seed >> 32U, purpose};
  return std::mt19937_64(sequence);
}

}  // namespace pipescout::simulation::internal
