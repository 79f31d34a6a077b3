// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/linear_algebra/cholesky.hpp"

namespace pipescout::estimation {

inline constexpr double kLeastDeviation = 1e-9;
inline constexpr double kGreatestDeviation = 1e9;

inline bool is_deviation(double value) {
  return value >= kLeastDeviation && value <= kGreatestDeviation;
}

/// Whether `c` is symmetric to rounding and positive definite with deviations in range.
template <int N>
bool is_covariance(const Eigen::Matrix<double, N, N>& c) {
  constexpr double kRounding = 1e-9;
  constexpr double kLeastPivot = 1e-6;
  if (!c.allFinite() ||
      !((c - c.transpose()).cwiseAbs().maxCoeff() <= kRounding * c.cwiseAbs().maxCoeff())) {
    return false;
  }
  if (!(c.diagonal().array() > 0).all()) {
    return false;
  }
  // Correlations first, so that the rounding of large variances does not hide small ones.
  const Eigen::Matrix<double, N, 1> deviation = c.diagonal().cwiseSqrt();
  const Eigen::Matrix<double, N, 1> scale = deviation.cwiseInverse();
  const Eigen::Matrix<double, N, N> correlation = scale.asDiagonal() * c * scale.asDiagonal();
  const linear_algebra::Cholesky<N> root(correlation);
  return root.succeeded() && root.diagonal().minCoeff() > kLeastPivot &&
         is_deviation(deviation.minCoeff()) && is_deviation(deviation.maxCoeff());
}

/// Lower triangular W with W^T W the inverse of the covariance `c`, which is not checked.
template <int N>
Eigen::Matrix<double, N, N> whitening_of(const Eigen::Matrix<double, N, N>& c) {
  return linear_algebra::Cholesky<N>(c).inverse_lower();
}

}  // namespace pipescout::estimation
