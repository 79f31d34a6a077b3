// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "pipescout/manipulation/arm_controller.hpp"

namespace pipescout::manipulation::internal {

/// The largest v with which a joint may go on for a period, after which it brakes by `acceleration`
/// times `period` in each period, and comes to rest within `distance`. `distance` >= 0, rad.
[[nodiscard]] double fastest_that_stops(double distance, double acceleration,
                                        double period) noexcept;
/// How far it gets after the period in which it goes at `velocity` >= 0, rad.
[[nodiscard]] double braking_distance(double velocity, double acceleration, double period) noexcept;

/// Where a joint is commanded to be, and how fast it got there.
struct Commanded {
  JointVector position{};
  JointVector velocity{};
};

/// Steps of all joints of an arm. A step moves each by its new velocity times the period. It keeps
/// within the limits of velocity and acceleration, and only gets to where braking as hard as
/// allowed brings the arm to rest within the limits of position, clear of itself and the ground. As
/// braking is always one of the choices, there is always one.
class JointSteps {
 public:
  explicit JointSteps(const ArmControllerParameters& parameters);

  struct Result {
    std::array<JointCut, kMostJoints> cuts{};
    bool clearance_cut = false;
  };
  /// As near to `wanted`, rad/s, finite, as may be. Too fast ones are slowed together, so that the
  /// camera moves the same way.
  Result advance(const ArmModel& model, JointVector wanted, Commanded& at) const;
  /// Whether a posture is clear.
  [[nodiscard]] bool clear(const ArmModel& model, const JointVector& q) const;

 private:
  [[nodiscard]] bool stops_clear(const ArmModel& model, const Commanded& at) const;
  [[nodiscard]] Commanded stepped(const ArmModel& model, const Commanded& at,
                                  const JointVector& velocity) const;
  /// Nearer to rest by what is allowed in a period.
  [[nodiscard]] JointVector braked(const JointVector& velocity) const;

  double period_;
  double acceleration_;
  double least_clearance_;
  double ground_;
};

}  // namespace pipescout::manipulation::internal
