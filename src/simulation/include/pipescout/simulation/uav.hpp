// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <random>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/simulation/dryden_wind.hpp"

/// A quadrotor with its autopilot, which takes velocity commands, in wind; with ground truth.
///
/// The rotors push along the body's z axis only, so that a lateral force requires a tilt: gusts
/// displace and rotate the vehicle. The autopilot is that of common practice: a proportional
/// velocity loop, estimation of the aerodynamic force from the accelerometer, and a second-order
/// attitude loop; its attitude is exact, and its velocity has a slowly varying error. Frames:
/// `rack`, here any frame at rest with z up; body, `base_link` (x forward, y left, z up); and the
/// level frame, at the body's origin with its yaw but z straight up. SI units and radians.
namespace pipescout::simulation {

struct UavParameters {
  /// Acceleration by drag, opposite to the airspeed v: (linear + quadratic |v|) v.
  double linear_drag = 0.2;      ///< 1/s, [0, 10]: of the rotors
  double quadratic_drag = 0.01;  ///< 1/m, [0, 10]: of the frame
  double rotational_drag = 1.0;  ///< 1/s, [0, 50]: of the rotation rate through the air
  double largest_tilt = 0.5;     ///< rad, (0, 1.2]
  double largest_thrust = 20.0;  ///< m/s^2, (9.81, 100]: thrust / mass
  double velocity_gain = 5.0;    ///< 1/s, (0, 20]
  /// 1/s, [0, 50]: bandwidth of the low-pass filter with which the autopilot estimates and
  /// compensates the aerodynamic force; 0: no compensation.
  double gust_bandwidth = 8.0;
  double attitude_frequency = 15.0;  ///< rad/s, (0, 50]: of the closed attitude loop
  double attitude_damping = 0.9;     ///< (0, 3]: its damping ratio
  double largest_speed = 3.0;        ///< m/s, (0, 30]: limit of commands, with unchanged direction
  double largest_yaw_rate = 1.0;     ///< rad/s, (0, 6]: as above
  double command_time_out = 1.0;     ///< s, (0, 1000]: after it, the command is zero
  /// m/s, [0, 1]: standard deviation of the autopilot's velocity error per axis.
  double velocity_error = 0.01;
  double velocity_error_time = 10.0;  ///< s, [0.1, 1000]: correlation time of that error

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Content of geometry_msgs/TwistStamped.
struct UavCommand {
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< m/s, level frame
  double yaw_rate = 0;                                 ///< rad/s, about straight up
};

/// The truth.
struct UavState {
  double time = 0;  ///< s
  geometry::SE3 T_rack_body;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< m/s, rack frame
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  ///< m/s^2, rack frame
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();  ///< rad/s, body frame
  /// m/s^2, body frame: reading of an ideal accelerometer at the origin.
  Eigen::Vector3d specific_force = Eigen::Vector3d::Zero();
};

inline constexpr double kGravity = 9.80665;  ///< m/s^2

/// The same parameters, commands, wind and seed give the same bits. Allocates nothing after
/// construction.
class Uav {
 public:
  /// Hovers at `position` (rack frame, m) with `yaw` (rad) at time 0, tilted against a steady wind
  /// of `mean_wind` (rack frame, m/s). Throws what `UavParameters::validate` throws, and
  /// std::invalid_argument when the place or the wind is not finite, or the wind is too strong to
  /// hover in.
  Uav(const UavParameters& parameters, const Eigen::Vector3d& position, double yaw,
      const Eigen::Vector3d& mean_wind, std::uint64_t seed);

  /// Sets the command. One that is not finite is counted and ignored.
  void command(const UavCommand& command) noexcept;
  [[nodiscard]] std::size_t bad_commands() const noexcept { return bad_commands_; }

  /// A step of 1 ms (fourth-order Runge-Kutta; autopilot and wind held) in this wind, in rack axes.
  void step(const WindSample& wind);
  static constexpr double kStep = 0.001;  ///< s

  [[nodiscard]] const UavState& state() const noexcept { return state_; }
  [[nodiscard]] const UavParameters& parameters() const noexcept { return parameters_; }

 private:
  /// Commands of the autopilot to the rotors; constant for a step.
  struct Actuation {
    double thrust = 0;                                      ///< m/s^2, along body z
    geometry::SO3 R_rack_wanted;                            ///< attitude
    Eigen::Vector3d wanted_rate = Eigen::Vector3d::Zero();  ///< rad/s, rack frame
  };
  /// Position, velocity (rack frame), rotation vector since the begin of the step and angular rate
  /// (body frame), or their derivatives.
  using Motion = Eigen::Matrix<double, 12, 1>;

  [[nodiscard]] Actuation autopilot();
  [[nodiscard]] Motion derivative(const Motion& motion, const Actuation& actuation,
                                  const WindSample& wind) const;
  [[nodiscard]] Eigen::Vector3d air_acceleration(const Eigen::Vector3d& velocity,
                                                 const Eigen::Vector3d& wind) const noexcept;
  void drift_velocity_error();

  UavParameters parameters_;
  std::mt19937_64 engine_;
  UavState state_;
  UavCommand command_;
  double commanded_at_ = 0;
  double wanted_yaw_ = 0;
  Eigen::Vector3d expected_drag_ = Eigen::Vector3d::Zero();   ///< m/s^2, rack axes
  double thrust_ = kGravity;                                  ///< m/s^2, of the last step
  Eigen::Vector3d velocity_error_ = Eigen::Vector3d::Zero();  ///< m/s, rack axes
  std::size_t bad_commands_ = 0;
  std::uint64_t steps_ = 0;
};

}  // namespace pipescout::simulation
