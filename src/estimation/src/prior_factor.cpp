// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/prior_factor.hpp"

#include <stdexcept>

#include "pipescout/linear_algebra/products.hpp"
#include "square_root_information.hpp"

namespace pipescout::estimation {

using geometry::SO3;

PriorFactor::PriorFactor(const NavState& mean, const StateMatrix& covariance) : mean_(mean) {
  if (!mean.is_finite()) {
    throw std::invalid_argument("PriorFactor: the mean is not finite");
  }
  if (!is_covariance(covariance)) {
    throw std::invalid_argument(
        "PriorFactor: the covariance is not symmetric and positive definite with standard "
        "deviations in [1e-9, 1e9]");
  }
  whitening_ = whitening_of(covariance);
}

PriorFactor::Residual PriorFactor::evaluate(const NavState& x,
                                            Jacobians<kRows>* derivatives) const {
  const Residual r = mean_.local(x);
  if (derivatives != nullptr) {
    StateMatrix d = StateMatrix::Identity();
    d.block<3, 3>(kRotation, kRotation) = SO3::right_jacobian_inverse(r.segment<3>(kRotation));
    derivatives->from = linear_algebra::product(whitening_, d);
  }
  return whitening_ * r;
}

}  // namespace pipescout::estimation
