// SPDX-License-Identifier: Apache-2.0
#include "joint_doubt.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pipescout::odometry {
namespace {

/// m: half of a bend of 90 degrees and 5 diameters in a pipe of 1 m.
constexpr double kHalfBend = 4.0;

/// Of a normal distribution, beyond `distance`.
double normal_tail(double distance, double variance) {
  if (variance <= 0.0) {
    return distance < 0.0 ? 1.0 : 0.0;
  }
  return 0.5 * std::erfc(distance / std::sqrt(2.0 * variance));
}

/// Of a uniform distribution within `reach` to either side, beyond `distance`.
double uniform_tail(double distance, double reach) {
  return reach > 0.0 ? std::clamp(0.5 * (reach - distance) / reach, 0.0, 1.0) : 0.0;
}

}  // namespace

JointDoubt::JointDoubt(const WeldPositioningParameters& parameters, const JointChain& chain,
                       std::span<const TallyBend> bends)
    : parameters_(parameters), chain_(chain), found_(std::numeric_limits<double>::quiet_NaN()) {
  for (const TallyBend& bend : bends) {
    bends_.push_back(chain.weld(static_cast<int>(bend.joint)) + bend.distance);
  }
  std::ranges::sort(bends_);
}

bool JointDoubt::bend_since_anchor(const WeldHypothesis& now, double odometer) const noexcept {
  const double at_anchor = odometer - now.net;
  if (found_ > std::min(at_anchor, odometer) - kHalfBend &&
      found_ < std::max(at_anchor, odometer) + kHalfBend) {
    return true;
  }
  const double anchor = chain_.weld(now.anchor);
  const double place = anchor + now.offset;
  // Of a bend ahead nothing has been passed, or less than of one behind.
  const double from = std::min(anchor, place) - (now.direction > 0 ? kHalfBend : 0.0);
  const double to = std::max(anchor, place) + (now.direction > 0 ? 0.0 : kHalfBend);
  const auto bend = std::ranges::lower_bound(bends_, from);
  return bend != bends_.end() && *bend <= to;
}

JointDoubt::Doubt JointDoubt::doubt(const WeldHypothesis& now, int joint,
                                    double odometer) const noexcept {
  const double possible = parameters_.largest_double_slip * now.path;
  const double slip = parameters_.double_slip_probability;
  const double bend = bend_since_anchor(now, odometer) ? parameters_.bend_fault_probability : 0.0;
  const double reach = std::min(parameters_.largest_bend_fault, possible);
  Doubt result;
  const auto beyond = [&](int weld, double sign) {
    const double distance = sign * (chain_.weld(weld) - chain_.weld(now.anchor) - now.offset);
    const double variance = now.p00 + chain_.variance_between(now.anchor, weld);
    const double by_bend = bend * uniform_tail(distance, reach);
    result.by_bend += by_bend;
    result.total += (1.0 - slip - bend) * normal_tail(distance, variance) +
                    slip * uniform_tail(distance, possible) + by_bend;
  };
  if (joint > 0) {  // beyond the ends of the pipe there is no joint
    beyond(joint, -1.0);
  }
  if (joint + 1 < chain_.joints()) {
    beyond(joint + 1, 1.0);
  }
  result.total = std::clamp(result.total, 0.0, 1.0);
  return result;
}

}  // namespace pipescout::odometry
