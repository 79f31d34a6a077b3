// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/linear_algebra/cholesky.hpp"

namespace pipescout::linear_algebra {

/// A = V diag(values) V^T of a symmetric matrix.
template <int N>
struct SymmetricEigen {
  Vector<N> values;   ///< ascending
  Square<N> vectors;  ///< V: column i belongs to value i; orthonormal, of either sign
  bool succeeded;     ///< false: no convergence, other results are unspecified
};

/// By QR iterations (Eigen::SelfAdjointEigenSolver), of the lower triangle. N is 2, 3 or 6.
template <int N>
[[nodiscard]] SymmetricEigen<N> symmetric_eigen(const Square<N>& a);

/// By the closed form: faster, to about half the digits.
[[nodiscard]] SymmetricEigen<3> symmetric_eigen_direct(const Square<3>& a);

}  // namespace pipescout::linear_algebra
