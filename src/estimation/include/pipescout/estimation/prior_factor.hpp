// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/estimation/factor.hpp"

namespace pipescout::estimation {

/// Prior of a state: W local(mean, x).
class PriorFactor {
 public:
  static constexpr FactorKind kKind = FactorKind::kPrior;
  static constexpr int kRows = kStateSize;
  using Residual = StateVector;

  /// `covariance` over the tangent space at `mean`. Throws std::invalid_argument when the mean is
  /// not finite or the covariance is not that of standard deviations in [1e-9, 1e9].
  PriorFactor(const NavState& mean, const StateMatrix& covariance);
  Residual evaluate(const NavState& x, Jacobians<kRows>* derivatives = nullptr) const;

 private:
  NavState mean_;
  StateMatrix whitening_;
};

}  // namespace pipescout::estimation
