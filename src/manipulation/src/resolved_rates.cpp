// SPDX-License-Identifier: Apache-2.0
#include "resolved_rates.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace pipescout::manipulation::internal {
namespace {

/// Keeps the system solvable where J J^T has no inverse and no damping is asked for.
constexpr double kLeastDamping = 1e-6;

}  // namespace

JointVector resolved_rates(const Jacobian& jacobian, double manipulability,
                           const geometry::Vector6d& twist, const RateWeights& weights) noexcept {
  Jacobian weighted = jacobian;
  weighted.bottomRows<3>() *= weights.rotation;
  geometry::Vector6d wanted = twist;
  wanted.tail<3>() *= weights.rotation;
  const double singular = std::max(0.0, 1 - manipulability / weights.least_manipulability);
  const double damping = std::max(kLeastDamping, weights.damping * singular);
  geometry::Matrix6d square = weighted * weighted.transpose();
  square.diagonal().array() += damping * damping;
  return weighted.transpose() * square.ldlt().solve(wanted);
}

}  // namespace pipescout::manipulation::internal
