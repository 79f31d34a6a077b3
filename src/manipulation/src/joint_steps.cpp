// SPDX-License-Identifier: Apache-2.0
#include "joint_steps.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::manipulation::internal {
namespace {

/// Parts of the way from braking to what is wanted that are tried, when the whole is too far.
constexpr std::array kParts{1.0, 0.5, 0.25, 0.0};
constexpr double kAsWanted = 1e-9;  // rad/s

}  // namespace

// In units of one change of velocity b = acceleration * period, a joint with v = (n + r) b, n whole
// and 0 <= r < 1, goes on by (n - 1 + r) + ... + (1 + r) + r while it brakes.

double braking_distance(double velocity, double acceleration, double period) noexcept {
  const double change = acceleration * period;
  const double n = std::floor(velocity / change);
  const double r = velocity / change - n;
  return change * period * (n * (n - 1) / 2 + n * r);
}

double fastest_that_stops(double distance, double acceleration, double period) noexcept {
  // The whole way, (n + 1) r + n (n + 1) / 2, grows with n + r and is that of n + 1 where r is 1.
  const double way = std::max(0.0, distance) / (acceleration * period * period);
  if (std::isinf(way)) {
    return way;  // a continuous joint
  }
  const double n = std::floor((std::sqrt(1 + 8 * way) - 1) / 2);
  const double r = (way - n * (n + 1) / 2) / (n + 1);
  return acceleration * period * (n + r);
}

JointSteps::JointSteps(const ArmControllerParameters& parameters)
    : period_(parameters.period),
      acceleration_(parameters.largest_acceleration),
      least_clearance_(parameters.least_clearance),
      ground_(parameters.ground) {}

JointVector JointSteps::braked(const JointVector& velocity) const {
  const double change = acceleration_ * period_;
  return velocity.unaryExpr(
      [change](double v) { return std::copysign(std::max(0.0, std::abs(v) - change), v); });
}

Commanded JointSteps::stepped(const ArmModel& model, const Commanded& at,
                              const JointVector& velocity) const {
  Commanded next{.position = at.position + period_ * velocity, .velocity = velocity};
  for (Eigen::Index i = 0; i < next.position.size(); ++i) {
    const ArmJoint& joint = model.joints()[static_cast<std::size_t>(i)];
    // Only rounding is beyond.
    next.position[i] = std::clamp(next.position[i], joint.lower, joint.upper);
  }
  return next;
}

bool JointSteps::clear(const ArmModel& model, const JointVector& q) const {
  const Clearance clearance = model.clearance(q, ground_);
  return std::min(clearance.self, clearance.plane) >= least_clearance_;
}

bool JointSteps::stops_clear(const ArmModel& model, const Commanded& at) const {
  const Clearance clearance = model.clearance(at.position, ground_);
  const double room = std::min(clearance.self, clearance.plane) - least_clearance_;
  if (room < 0) {
    return false;
  }
  // No point gets farther than all joints turn, times the reach: most often that is little.
  double turned = 0;
  for (const double v : at.velocity) {
    turned += braking_distance(std::abs(v), acceleration_, period_);
  }
  if (room >= turned * model.reach()) {
    return true;
  }
  Commanded braking = at;
  while (braking.velocity.cwiseAbs().maxCoeff() > 0) {
    braking = stepped(model, braking, braked(braking.velocity));
    if (!clear(model, braking.position)) {
      return false;
    }
  }
  return true;
}

JointSteps::Result JointSteps::advance(const ArmModel& model, JointVector wanted,
                                       Commanded& at) const {
  Result result;
  const auto cut_of = [&result](Eigen::Index i) -> JointCut& {
    return result.cuts[static_cast<std::size_t>(i)];
  };
  double slower = 1;
  for (Eigen::Index i = 0; i < wanted.size(); ++i) {
    const double largest = model.joints()[static_cast<std::size_t>(i)].velocity;
    if (std::abs(wanted[i]) > largest) {
      slower = std::min(slower, largest / std::abs(wanted[i]));
      cut_of(i) = JointCut::kVelocity;
    }
  }
  wanted *= slower;

  const JointVector brake = braked(at.velocity);
  const double change = acceleration_ * period_;
  JointVector velocity = wanted;
  for (Eigen::Index i = 0; i < wanted.size(); ++i) {
    const ArmJoint& joint = model.joints()[static_cast<std::size_t>(i)];
    const double quickest = std::clamp(wanted[i], at.velocity[i] - change, at.velocity[i] + change);
    const double room_up = joint.upper - at.position[i];
    const double room_down = at.position[i] - joint.lower;
    // Rounding may leave no room by a hair: braking is right then.
    const double most = std::max(brake[i], fastest_that_stops(room_up, acceleration_, period_));
    const double least = std::min(brake[i], -fastest_that_stops(room_down, acceleration_, period_));
    velocity[i] = std::clamp(quickest, least, most);
    if (std::abs(velocity[i] - quickest) > kAsWanted) {
      cut_of(i) = JointCut::kPosition;
    } else if (std::abs(quickest - wanted[i]) > kAsWanted) {
      cut_of(i) = JointCut::kAcceleration;
    }
  }
  for (const double part : kParts) {
    const Commanded next = stepped(model, at, brake + part * (velocity - brake));
    if (part == 0 || stops_clear(model, next)) {
      at = next;
      break;
    }
    result.clearance_cut = true;
  }
  return result;
}

}  // namespace pipescout::manipulation::internal
