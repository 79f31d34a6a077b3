// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "pipescout/manipulation/arm_controller.hpp"
#include "pipescout/simulation/arm_dynamics.hpp"
#include "pipescout/simulation/ground_robot.hpp"
#include "pipescout/simulation/terrain.hpp"

/// A ground robot that drives along a straight collector over rough ground, its thermal camera on
/// an arm, to compare controllers of the arm that keep the collector in view. SI units and radians;
/// frames as in arm_model.hpp.
namespace pipescout::arm_study {

/// Error model of the tracker. Deviations are standard deviations. The paper's tracker has errors
/// of 1.4 px and 0.7 degrees (Table 1, best particle).
struct TrackErrors {
  double rate = 25;                ///< Hz, [1, 100]: of images
  double latency = 0.08;           ///< s, [0, 1]: from the image to the track
  double position_deviation = 2;   ///< px, [0, 100]: of u and v, white
  double angle_deviation = 0.013;  ///< rad, [0, 1]: 0.75 degrees, white
  double range_deviation = 0.05;   ///< [0, 1]: share of the range, one per drive
  double gap_spacing = 300;        ///< m, (0, 1e6]: mean way between gaps
  double gap_time = 0.8;           ///< s, [0, 10]: longest gap, in which the tracker coasts

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Error model of the estimator; varying errors are Gauss-Markov processes.
struct OdometryErrors {
  double rate = 100;                 ///< Hz, [10, 500]
  double latency = 0.02;             ///< s, [0, 0.1]
  double tilt_deviation = 0.003;     ///< rad, [0, 1]: of each axis of the attitude
  double tilt_time = 5;              ///< s, [0.1, 1e5]
  double velocity_deviation = 0.05;  ///< m/s, [0, 10]: of each axis
  double velocity_time = 5;          ///< s, [0.1, 1e5]
  double rate_deviation = 0.005;     ///< rad/s, [0, 1]: of each axis, white

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct DriveSettings {
  simulation::RoadClass road = simulation::RoadClass::kD;
  /// m, [0, 10]: standard deviation of the ground's slow waves, of 200 to 600 m: slopes of some 2
  /// %.
  double hill_height = 1;
  double length = 10000;      ///< m, [10, 1e5]
  double speed = 20 / 3.6;    ///< m/s, (0, 5.56]: 20 km/h
  double distance = 10;       ///< m, [2, 100]: distance of the path from the collector
  double pipe_height = 3;     ///< m, [0.5, 20]: above the mean ground
  double pipe_radius = 0.06;  ///< m, (0, 1]
  double settling = 20;       ///< s, [0, 1000]: excluded from the score
  simulation::GroundRobotParameters robot{.wheel_base = 1.6, .track = 1.2};
  TrackErrors track{};
  OdometryErrors odometry{};
  double arm_delay = 0.02;              ///< s, [0, 0.5]: of its driver
  double joint_zero_deviation = 0.005;  ///< rad, [0, 0.1]: of each joint's zero, one per drive

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// A controller of the camera.
struct ArmRule {
  std::string name;
  bool fixed = false;  ///< never moves: stays ready
  manipulation::ArmControllerParameters controller{};
};
/// A fixed camera; the paper's rule (moves only near the edge, by the image alone); always centred
/// by the image alone; always centred with the vehicle's motion fed forward.
[[nodiscard]] std::vector<ArmRule> arm_rules();

struct DriveScore {
  std::string rule;
  std::size_t samples = 0;  ///< one per cycle of the controller
  /// in which both edges of the pipe are in the image over its whole length
  std::size_t whole = 0;
  double centre_square =
      0;  ///< px^2, sum: of the axis from the middle, where the columns' middle is
  double angle_square = 0;           ///< rad^2, sum: of the axis from level
  double largest_centre = 0;         ///< px
  std::size_t limit_violations = 0;  ///< commands beyond a limit of position, rate, acceleration
                                     ///< or clearance
  double largest_rate_share = 0;     ///< of the limits, of what was commanded
  double largest_acceleration_share = 0;
  double least_clearance = 0;  ///< m
  double moving_percent = 0;   ///< of the cycles in which any joint was commanded to move

  [[nodiscard]] double in_view_percent() const;
  [[nodiscard]] double centre_rms() const;  ///< px
  [[nodiscard]] double angle_rms() const;   ///< rad
};

/// One drive for all rules: the same ground, robot and errors. The same arguments give the same
/// bits. Throws as DriveSettings::validate.
[[nodiscard]] std::vector<DriveScore> run_drive(const DriveSettings& settings,
                                                const std::vector<ArmRule>& rules,
                                                std::uint64_t seed);

}  // namespace pipescout::arm_study
