// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <random>

/// Random draws that are the same with every standard library, unlike the distributions of
/// <random>, from an engine that the caller seeds.
namespace pipescout::statistics {

using Engine = std::mt19937_64;

/// Engines of one seed that have nothing to do with each other, one for each `purpose`.
[[nodiscard]] inline Engine make_engine(std::uint64_t seed, std::uint64_t purpose) {
  std::seed_seq sequence{seed & 0xffffffffU, seed >> 32U, purpose};
  return Engine(sequence);
}

/// [0, 1)
inline double uniform(Engine& engine) {
  return static_cast<double>(engine() >> 11U) * 0x1p-53;
}

/// [low, high)
inline double uniform(Engine& engine, double low, double high) {
  return low + (high - low) * uniform(engine);
}

/// Mean 0, standard deviation 1 (Box and Muller, "A note on the generation of random normal
/// deviates", 1958; one of the pair is used).
inline double normal(Engine& engine) {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform(engine)));
  return radius * std::cos(2.0 * std::numbers::pi * uniform(engine));
}

/// N independent ones, drawn in order.
template <int N>
Eigen::Matrix<double, N, 1> normals(Engine& engine) {
  Eigen::Matrix<double, N, 1> result;
  for (double& element : result) {
    element = normal(engine);
  }
  return result;
}

/// Mean 1.
inline double exponential(Engine& engine) {
  return -std::log(1.0 - uniform(engine));
}

/// The same with its engine.
class Draw {
 public:
  explicit Draw(const Engine& engine) : engine_(engine) {}
  Draw(std::uint64_t seed, std::uint64_t purpose) : engine_(make_engine(seed, purpose)) {}

  double uniform(double low, double high) { return statistics::uniform(engine_, low, high); }
  /// 0 to count - 1; `count` is at least 1.
  std::size_t index(std::size_t count) {
    return static_cast<std::size_t>(uniform(0, static_cast<double>(count)));
  }
  /// With this probability.
  bool happens(double share) { return uniform(0, 1) < share; }
  double normal() { return statistics::normal(engine_); }
  double exponential() { return statistics::exponential(engine_); }
  Eigen::Vector3d normals() { return statistics::normals<3>(engine_); }
  /// Of length 1, all directions alike.
  Eigen::Vector3d direction() { return normals().normalized(); }
  std::uint64_t seed() { return engine_(); }

 private:
  Engine engine_;
};

}  // namespace pipescout::statistics
