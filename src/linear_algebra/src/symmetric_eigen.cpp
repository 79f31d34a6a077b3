// SPDX-License-Identifier: Apache-2.0
#include "pipescout/linear_algebra/symmetric_eigen.hpp"

#include <Eigen/Eigenvalues>

namespace pipescout::linear_algebra {

template <int N>
SymmetricEigen<N> symmetric_eigen(const Square<N>& a) {
  const Eigen::SelfAdjointEigenSolver<Square<N>> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors(), solver.info() == Eigen::Success};
}

SymmetricEigen<3> symmetric_eigen_direct(const Square<3>& a) {
  Eigen::SelfAdjointEigenSolver<Square<3>> solver;
  solver.computeDirect(a);
  return {solver.eigenvalues(), solver.eigenvectors(), solver.info() == Eigen::Success};
}

template SymmetricEigen<2> symmetric_eigen<2>(const Square<2>&);
template SymmetricEigen<3> symmetric_eigen<3>(const Square<3>&);
template SymmetricEigen<6> symmetric_eigen<6>(const Square<6>&);

}  // namespace pipescout::linear_algebra
