// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace pipescout::leak_study::internal {

/// Draws that are the same with every standard library; those of one purpose have nothing to do
/// with those of another.
class Draw {
 public:
  Draw(std::uint64_t seed, std::uint64_t purpose) {
    std::seed_seq sequence{seed & 0xffffffffU, seed >> 32U, purpose};
    engine_.seed(sequence);
  }
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11U) * 0x1p-53;
  }
  /// 0 to count - 1; `count` is at least 1.
  std::size_t index(std::size_t count) {
    return static_cast<std::size_t>(uniform(0, static_cast<double>(count)));
  }
  double normal() {
    const double radius = std::sqrt(-2 * std::log(1 - uniform(0, 1)));
    return radius * std::cos(uniform(0, 2 * std::numbers::pi));
  }
  Eigen::Vector3d normals() {
    const double x = normal();
    const double y = normal();
    return {x, y, normal()};
  }
  std::uint64_t seed() { return engine_(); }

 private:
  std::mt19937_64 engine_;
};

}  // namespace pipescout::leak_study::internal
