// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/linear_algebra/cholesky.hpp"

/// Covariances and information matrices that may be singular to rounding: by P^T L D L^T P
/// (Eigen::LDLT). The lower triangle is read.
namespace pipescout::linear_algebra {

/// A^-1 B; where A is singular, 0 in its null space. (N, Columns) is (2, 1), (3, 1), (3, 3), (3,
/// 6), (6, 1), (6, 6), (9, 1) or (12, 6).
template <int N, int Columns>
[[nodiscard]] Eigen::Matrix<double, N, Columns> solve_semidefinite(
    const Square<N>& a, const Eigen::Matrix<double, N, Columns>& b);

/// A^-1, symmetric to rounding. N is 3 or 6.
template <int N>
[[nodiscard]] Square<N> inverse_semidefinite(const Square<N>& a) {
  return solve_semidefinite<N, N>(a, Square<N>::Identity());
}

/// The squared Mahalanobis distance e^T A^-1 e: chi-square distributed with N degrees of freedom
/// where A is the covariance of a normal e. N is 2, 3, 6 or 9.
template <int N>
[[nodiscard]] double squared_mahalanobis(const Square<N>& covariance, const Vector<N>& error) {
  return error.dot(solve_semidefinite<N, 1>(covariance, error));
}

}  // namespace pipescout::linear_algebra
