// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Eigenvalues>

#include "pipescout/linear_algebra/symmetric_eigen.hpp"

namespace pipescout::linear_algebra {

template <int N>
SymmetricEigen<N> symmetric_eigen(const Square<N>& a) {
  const Eigen::SelfAdjointEigenSolver<Square<N>> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors(), solver.info() == Eigen::Success};
}

}  // namespace pipescout::linear_algebra
