// SPDX-License-Identifier: Apache-2.0
#include "pipescout/state_estimator/agreeing_fixes.hpp"

#include <cmath>
#include <numbers>
#include <utility>

namespace pipescout {

using sensor_msgs::msg::NavSatFix;

double distance_between(const NavSatFix& a, const NavSatFix& b) {
  constexpr double kRadius = 6.371e6;  // m, of the Earth
  constexpr double kDegree = std::numbers::pi / 180;
  const double north = (b.latitude - a.latitude) * kDegree;
  const double east = std::remainder(b.longitude - a.longitude, 360.0) * kDegree *
                      std::cos(0.5 * (a.latitude + b.latitude) * kDegree);
  return kRadius * std::hypot(north, east);
}

bool AgreeingFixes::add(const NavSatFix& fix) {
  if (!fixes_.empty() && !(distance_between(fixes_.back(), fix) < kNear)) {
    fixes_.clear();
  }
  fixes_.push_back(fix);
  return fixes_.size() >= kAgreeing;
}

std::vector<NavSatFix> AgreeingFixes::take() {
  return std::exchange(fixes_, {});
}

}  // namespace pipescout
