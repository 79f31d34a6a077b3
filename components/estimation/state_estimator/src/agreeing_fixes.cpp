// SPDX-License-Identifier: Apache-2.0
#include "pipescout/state_estimator/agreeing_fixes.hpp"

#include <utility>

#include "pipescout/geometry/geodesy.hpp"

namespace pipescout {

using sensor_msgs::msg::NavSatFix;

namespace {

/// m, whatever the altitudes, which may not be known.
double distance_between(const NavSatFix& a, const NavSatFix& b) {
  const auto on_ellipsoid = [](const NavSatFix& fix) {
    return geometry::GeodeticPosition{fix.latitude, fix.longitude, 0};
  };
  return geometry::LocalFrame(on_ellipsoid(a)).position(on_ellipsoid(b)).norm();
}

}  // namespace

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
