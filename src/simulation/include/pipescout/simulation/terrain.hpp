// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

/// Ground as a height over the plane: a slope, slow hills, and roughness by ISO 8608. Metres.
namespace pipescout::simulation {

enum class RoadClass : std::uint8_t { kA, kB, kC, kD, kE };

/// Displacement spectral density at 0.1 cycles/m, m^3: the geometric mean of the class in ISO 8608,
/// 16e-6 (A) and 4 times as much from class to class.
[[nodiscard]] double iso_8608_density(RoadClass road) noexcept;

struct TerrainParameters {
  double roughness = iso_8608_density(RoadClass::kC);  ///< m^3, [0, 0.1]: density at 0.1 cycles/m
  double longest = 100;    ///< m, (shortest, 1e4]: wave of the roughness
  double shortest = 0.35;  ///< m, [0.01, longest)
  std::size_t waves = 96;  ///< [1, 10000]: of the roughness
  double hill_height = 0;  ///< m, [0, 1000]: standard deviation of the hills
  double hill_length =
      200;  ///< m, [10, 1e5]: shortest wave of the hills; the longest is 3 times it
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();  ///< dh/dx, dh/dy, each [-1, 1]

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// A sum of plane waves of all directions with seeded phases: a closed form, the same everywhere
/// and in every direction. The same seed gives the same ground.
class Terrain {
 public:
  /// Throws what `TerrainParameters::validate` throws.
  Terrain(const TerrainParameters& parameters, std::uint64_t seed);

  struct Place {
    double height = 0;                                   ///< m
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();  ///< dh/dx, dh/dy
  };
  [[nodiscard]] Place at(const Eigen::Vector2d& place) const noexcept;

  /// One-sided spectral density of the roughness along any straight line, m^3, at a wave number n,
  /// cycles/m: ISO 8608's G_d(n) = G_d(0.1) (0.1 / n)^2, times sqrt(1 - (n shortest)^2), because no
  /// shorter waves cross the line at an angle. From 1 / longest to 1 / shortest; 0 elsewhere (a
  /// small part below 1 / longest is neglected).
  [[nodiscard]] double spectrum(double wave_number) const noexcept;

 private:
  struct Wave {
    Eigen::Vector2d number = Eigen::Vector2d::Zero();  ///< rad/m
    double amplitude = 0;                              ///< m
    double phase = 0;                                  ///< rad
  };
  TerrainParameters parameters_;
  std::vector<Wave> waves_;
};

}  // namespace pipescout::simulation
