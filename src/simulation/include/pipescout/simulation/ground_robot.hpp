// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "pipescout/simulation/body_motion.hpp"
#include "pipescout/simulation/terrain.hpp"

/// A four-wheeled robot on rough ground, with ground truth. SI units and radians.
///
/// Its body (x forward, y left, z up) follows the ground under the four wheels through a suspension
/// of second order for each of heave, pitch and roll, rolls outwards in turns, and slips sideways
/// in proportion to the lateral force. Wheels slip under traction and in bursts. Order of the
/// wheels: front left, front right, rear left, rear right.
namespace pipescout::simulation {

inline constexpr std::size_t kWheels = 4;

struct GroundRobotParameters {
  double wheel_base = 0.9;  ///< m, [0.1, 10]
  double track = 0.7;       ///< m, [0.1, 10]
  /// m, [-5, 5]: of the point half-way between the wheels before the origin, which moves along x
  double wheels_ahead = 0;
  double ride_height = 0.35;    ///< m, [0, 5]: of the origin above the ground
  double heave_frequency = 14;  ///< rad/s, [1, 100]
  double tilt_frequency = 16;   ///< rad/s, [1, 100]: of pitch and roll
  double damping = 0.5;         ///< [0.05, 2]: ratio, of all three
  /// rad per m/s^2, [0, 0.1]: roll outwards in turns, pitch back under acceleration
  double lean = 0.006;
  double largest_speed = 5.56;        ///< m/s, (0, 20]: 20 km/h
  double largest_acceleration = 1.5;  ///< m/s^2, (0, 10]
  double largest_yaw_rate = 1.0;      ///< rad/s, (0, 5]
  double drive_time = 0.25;           ///< s, [0.02, 5]: lag of the acceleration behind the command
  double steer_time = 0.25;           ///< s, [0.02, 5]: lag of the yaw rate behind the command
  double side_slip = 0.01;            ///< s, [0, 1]: sideways speed per sideways acceleration held
  double side_slip_time = 0.2;        ///< s, [0.02, 5]: lag of the sideways speed

  // Wheels.
  double wheel_scale_error = 0.003;  ///< [0, 0.2], deviation, each wheel
  double wheel_noise = 0.004;        ///< m per square root of metre, [0, 1]: random walk
  double traction_slip = 0.002;  ///< s^2/m, [0, 0.1]: relative excess of the reading per traction
  double slip_spacing = 40;      ///< m, [0, 1e6]: mean path between bursts of a wheel; 0: none
  double slip_shortest = 0.5;    ///< m, [0.01, 1000]
  double slip_longest = 3;       ///< m, [slip_shortest, 1000]
  double slip_most = 0.3;        ///< [0, 1]: largest relative excess of the reading in a burst
  double wheel_resolution = 0.001;  ///< m, [0, 1]: of its counter; 0: exact

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Wanted speed over the ground and rate about the vertical.
struct GroundRobotCommand {
  double speed = 0;     ///< m/s
  double yaw_rate = 0;  ///< rad/s
};

/// The same parameters, terrain, commands and seed give the same bits. Allocates nothing after
/// construction.
class GroundRobot {
 public:
  /// At rest on the ground at time 0. Throws what `GroundRobotParameters::validate` throws, and
  /// std::invalid_argument when place or yaw is not finite.
  GroundRobot(const GroundRobotParameters& parameters, Terrain terrain,
              const Eigen::Vector2d& place, double yaw, std::uint64_t seed);

  /// Sets the command, limited to the abilities of the robot. One that is not finite is counted and
  /// ignored.
  void command(const GroundRobotCommand& command) noexcept;
  [[nodiscard]] std::size_t bad_commands() const noexcept { return bad_commands_; }

  /// A step of 2 ms (fourth-order Runge-Kutta).
  void step();
  static constexpr double kStep = 0.002;  ///< s

  [[nodiscard]] const BodyMotion& motion() const noexcept { return motion_; }
  [[nodiscard]] double yaw() const noexcept { return state_[kYaw]; }
  [[nodiscard]] double speed() const noexcept { return state_[kSpeed]; }  ///< m/s, forwards
  /// m, along the ground at the origin, backwards negative.
  [[nodiscard]] double distance() const noexcept { return state_[kDistance]; }
  /// m, reading of each wheel's counter; 0 at the start.
  [[nodiscard]] std::array<double, kWheels> odometers() const noexcept;
  [[nodiscard]] const Terrain& terrain() const noexcept { return terrain_; }

 private:
  enum : Eigen::Index {
    kX,
    kY,
    kZ,
    kYaw,
    kPitch,
    kRoll,
    kSpeed,
    kSide,
    kClimb,
    kYawRate,
    kPitchRate,
    kRollRate,
    kAcceleration,
    kDistance,
    kSize
  };
  using State = Eigen::Matrix<double, kSize, 1>;
  /// Of the plane through the ground under the wheels: height, pitch and roll.
  struct Ground {
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    Eigen::Vector3d rate = Eigen::Vector3d::Zero();
  };
  struct Wheel {
    double scale = 1;
    double turned = 0;       ///< m
    double burst_begin = 0;  ///< m of path
    double burst_end = 0;    ///< m of path
    double burst = 0;        ///< share
    double path = 0;         ///< m
  };

  [[nodiscard]] Ground ground_under(const State& state) const noexcept;
  [[nodiscard]] State derivative(const State& state, const Ground& ground) const;
  void measure(const State& derivative);
  void turn_wheels(double moved, double turned);
  void draw_burst(Wheel& wheel);

  GroundRobotParameters parameters_;
  Terrain terrain_;
  std::mt19937_64 engine_;
  State state_ = State::Zero();
  Ground ground_;
  GroundRobotCommand command_;
  BodyMotion motion_;
  std::array<Wheel, kWheels> wheels_{};
  std::size_t bad_commands_ = 0;
  std::uint64_t steps_ = 0;
};

struct CourseParameters {
  double speed = 4;       ///< m/s, (0, 20]: on straights
  double slowest = 1;     ///< m/s, (0, speed]: in sharp turns
  double gain = 1;        ///< 1/s, (0, 10]: yaw rate per error of the course
  double look_ahead = 3;  ///< m, [0.1, 100]: look-ahead distance on the leg
  double reached = 2.5;   ///< m, [0.1, 100]: radius within which a way-point is passed
  double sideways = 2;    ///< m/s^2, (0, 10]: largest acceleration in turns

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Steers a robot along way-points and stops it at the last one.
class CourseController {
 public:
  /// Throws what `CourseParameters::validate` throws, and std::invalid_argument when there are no
  /// way-points or one is not finite.
  CourseController(const CourseParameters& parameters, std::vector<Eigen::Vector2d> way_points);

  /// Command for a robot at this pose; the first call defines the start of the first leg.
  [[nodiscard]] GroundRobotCommand steer(const GroundRobot& robot);
  [[nodiscard]] bool arrived() const noexcept { return next_ >= way_points_.size(); }

 private:
  CourseParameters parameters_;
  std::vector<Eigen::Vector2d> way_points_;
  std::size_t next_ = 0;
  Eigen::Vector2d from_ = Eigen::Vector2d::Zero();
  bool started_ = false;
};

}  // namespace pipescout::simulation
