// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

#include "pipescout/simulation/body_motion.hpp"
#include "pipescout/simulation/pipe_route.hpp"

/// Deviation of a vehicle in a pipe from the centre line. Metres and radians.
///
/// Its offsets to the left and upwards, and its crab angles, are independent processes of chainage
/// with a flat spectrum from 0 to that of the shortest wavelength L: their autocorrelation is
/// sin(x) / x with x = 2 pi s / L, and positions L / 2 apart are uncorrelated. Each is a sum of
/// waves along the line (Shinozuka and Deodatis, Simulation of stochastic processes by spectral
/// representation, 1991) with amplitudes and phases drawn at random, and a wave number at random in
/// each of `kWaves` equal parts of the spectrum. So each single pipe has the whole spectrum:
/// averages over up to `kWaves` L / 4 of distance are as normal as sums of independent draws.
namespace pipescout::simulation {

struct PipeWeaveParameters {
  double deviation = 0.007;        ///< m, of each offset; [0, 0.1]
  double crab_deviation = 0.01;    ///< rad, of each angle; [0, 0.2]
  double shortest_wavelength = 1;  ///< m; [0.1, 100]

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

class PipeWeave {
 public:
  /// {left, up} in m and {yaw to the left, pitch upwards} in rad, and derivatives by chainage.
  struct Offset {
    Eigen::Vector4d value = Eigen::Vector4d::Zero();
    Eigen::Vector4d first = Eigen::Vector4d::Zero();
    Eigen::Vector4d second = Eigen::Vector4d::Zero();
    Eigen::Vector4d third = Eigen::Vector4d::Zero();
  };

  /// The same parameters and seed give the same bits. Throws as PipeWeaveParameters::validate.
  PipeWeave(const PipeWeaveParameters& parameters, std::uint64_t seed);

  [[nodiscard]] Offset offset(double chainage) const noexcept;

  /// Motion of a vehicle at its offset from the line, level, with its x axis along the path of the
  /// offset except for the crab angles. `speed` and `acceleration` are those of the chainage, m/s
  /// and m/s^2; `time` of the result is 0. Velocity and acceleration are exact. Without crab the x
  /// axis is off the direction of travel by offset / radius in a bend, and by half the slope
  /// upwards times the square of that sideways, some 1e-5 rad.
  [[nodiscard]] BodyMotion motion(const PipeRoute& route, double chainage, double speed,
                                  double acceleration) const;

  static constexpr std::size_t kWaves = 64;

 private:
  struct Wave {
    Eigen::Vector4d cosine = Eigen::Vector4d::Zero();
    Eigen::Vector4d sine = Eigen::Vector4d::Zero();
    double number = 0;  ///< rad/m
  };
  std::array<Wave, kWaves> waves_{};
};

}  // namespace pipescout::simulation
