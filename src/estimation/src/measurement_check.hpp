// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <initializer_list>

#include "pipescout/estimation/factor.hpp"
#include "square_root_information.hpp"

/// What measurements may hold.
namespace pipescout::estimation {

inline bool finite(std::initializer_list<double> values) {
  for (const double value : values) {
    if (!std::isfinite(value)) {
      return false;
    }
  }
  return true;
}

inline bool finite(const geometry::SE3& t) {
  return t.translation().allFinite() && t.rotation().quaternion().coeffs().allFinite();
}

inline bool is_unit(const Eigen::Vector3d& direction) {
  constexpr double kUnit = 1e-6;
  return std::abs(direction.norm() - 1) <= kUnit;
}

inline InputFault verdict(bool all_finite, bool good_covariance) {
  if (!all_finite) {
    return InputFault::kNotFinite;
  }
  return good_covariance ? InputFault::kNone : InputFault::kBadCovariance;
}

}  // namespace pipescout::estimation
