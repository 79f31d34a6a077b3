// SPDX-License-Identifier: Apache-2.0
#include "symmetric_eigen_definition.hpp"

namespace pipescout::linear_algebra {

SymmetricEigen<3> symmetric_eigen_direct(const Square<3>& a) {
  Eigen::SelfAdjointEigenSolver<Square<3>> solver;
  solver.computeDirect(a);
  return {solver.eigenvalues(), solver.eigenvectors(), solver.info() == Eigen::Success};
}

template SymmetricEigen<2> symmetric_eigen<2>(const Square<2>&);
template SymmetricEigen<3> symmetric_eigen<3>(const Square<3>&);

}  // namespace pipescout::linear_algebra
