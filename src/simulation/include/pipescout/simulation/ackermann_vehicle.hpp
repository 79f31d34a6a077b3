// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

/// A vehicle that steers its front wheels, on sloping ground, with ground truth. SI units, radians.
///
/// The origin is in the middle of the rear axle, x forward, y left. Commands act after a delay; the
/// steering angle then follows at a limited rate and the speed with a limited acceleration. In
/// turns the vehicle understeers (Gillespie, "Fundamentals of vehicle dynamics", 1992, chapter 6)
/// and slips sideways downhill.
namespace pipescout::simulation {

struct AckermannVehicleParameters {
  double wheel_base = 1.2;            ///< m, [0.1, 10]
  double largest_steering = 0.5;      ///< rad, (0, 1.4]
  double steering_rate = 0.6;         ///< rad/s, (0, 10]
  double steering_delay = 0.1;        ///< s, [0, 1]
  double drive_delay = 0.1;           ///< s, [0, 1]
  double largest_acceleration = 1.2;  ///< m/s^2, (0, 10]
  double largest_deceleration = 2.5;  ///< m/s^2, (0, 10]
  double understeer = 0.01;           ///< rad per m/s^2, [0, 0.1]
  double wheel_slip = 0.01;           ///< [0, 0.2]: share of the speed that is lost
  double slope = 0;                   ///< rad, [0, 0.3]: of the ground
  double uphill = 0;                  ///< rad: heading in which it rises
  double side_slip = 0.05;            ///< s, [0, 1]: sideways speed per downhill acceleration

  /// Throws std::invalid_argument that names the field.
  void validate() const;
};

struct AckermannState {
  double x = 0;
  double y = 0;
  double heading = 0;
  double speed = 0;     ///< m/s, of the wheels
  double steering = 0;  ///< rad, of the front wheels
  double yaw_rate = 0;  ///< rad/s
};

class AckermannVehicle {
 public:
  /// s, each integration step.
  static constexpr double kStep = 1e-3;

  /// Throws std::invalid_argument.
  AckermannVehicle(const AckermannVehicleParameters& parameters, const AckermannState& start);

  /// What the vehicle is to do from now on; what is not finite is taken for a stop.
  void command(double speed, double steering);
  /// One step of 1 ms.
  void step();
  [[nodiscard]] const AckermannState& state() const { return state_; }

 private:
  struct Command {
    double speed = 0;
    double steering = 0;
  };

  AckermannVehicleParameters parameters_;
  AckermannState state_;
  Command command_;
  std::vector<Command> history_;  ///< one for each step, a ring
  long steps_ = 0;
};

}  // namespace pipescout::simulation
