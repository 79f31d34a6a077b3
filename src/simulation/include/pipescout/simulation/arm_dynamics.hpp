// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <vector>

/// Joints of an arm with the position controllers of its driver. SI units and radians.
namespace pipescout::simulation {

struct ArmDynamicsParameters {
  /// Of each joint: hard stops, rad, lower < upper, and largest rate, rad/s, (0, 100].
  std::vector<double> lower{};
  std::vector<double> upper{};
  std::vector<double> largest_rate{};
  double largest_acceleration = 25;  ///< rad/s^2, (0, 1000]: of each joint
  double delay = 0.02;               ///< s, [0, 0.5]: latency of a command
  double frequency = 40;             ///< rad/s, [1, 500]: of the position loop, second order
  double damping = 0.9;              ///< [0.1, 2]: ratio
  double resolution = 1e-4;          ///< rad, [0, 0.1]: of the encoders; 0: exact

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Each joint follows its command with a second-order position loop and rate feed-forward, limited
/// in acceleration and rate, between its hard stops. The same commands give the same bits.
class ArmDynamics {
 public:
  /// At rest at `positions`, at time 0. Throws as ArmDynamicsParameters::validate, and
  /// std::invalid_argument when the number of positions is wrong, or one is outside its stops.
  ArmDynamics(const ArmDynamicsParameters& parameters, std::span<const double> positions);

  /// A point of a trajectory (trajectory_msgs/JointTrajectory): `positions`, rad, and `rates`,
  /// rad/s, at `time_from_start` from now. It replaces the previous point after its delay; after
  /// its time the joints hold the position. Throws std::invalid_argument when sizes differ, or a
  /// number is not finite.
  void command(std::span<const double> positions, std::span<const double> rates,
               double time_from_start);
  /// A step of 2 ms.
  void step();
  static constexpr double kStep = 0.002;  ///< s

  [[nodiscard]] double time() const noexcept;  ///< s
  [[nodiscard]] const std::vector<double>& positions() const noexcept { return positions_; }
  [[nodiscard]] const std::vector<double>& rates() const noexcept { return rates_; }
  /// Encoder readings, rad: overwrites `shown`, which has the number of joints.
  void encoders(std::span<double> shown) const;

 private:
  struct Point {
    double begin = 0;  ///< s
    double end = 0;    ///< s
    std::vector<double> positions{};
    std::vector<double> rates{};
  };

  ArmDynamicsParameters parameters_;
  std::vector<double> positions_;
  std::vector<double> rates_;
  std::deque<Point> points_;  ///< the first one is active, the others are delayed
  std::uint64_t steps_ = 0;
};

}  // namespace pipescout::simulation
