// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>

#include "pipescout/linear_algebra/cholesky.hpp"

namespace pipescout::linear_algebra {

template <int N>
Cholesky<N>::Cholesky(const Square<N>& a) {
  const Eigen::LLT<Square<N>> factors(a);
  factors_ = factors.matrixLLT();
  succeeded_ = factors.info() == Eigen::Success;
}

template <int N>
Square<N> Cholesky<N>::lower() const {
  return factors_.template triangularView<Eigen::Lower>();
}

template <int N>
double Cholesky<N>::log_determinant() const {
  return 2 * factors_.diagonal().array().log().sum();
}

template <int N>
Vector<N> Cholesky<N>::solve(const Vector<N>& b) const {
  Vector<N> x = b;
  const auto lower = factors_.template triangularView<Eigen::Lower>();
  lower.solveInPlace(x);
  lower.transpose().solveInPlace(x);
  return x;
}

template <int N>
Square<N> Cholesky<N>::inverse() const {
  Square<N> x = Square<N>::Identity();
  const auto lower = factors_.template triangularView<Eigen::Lower>();
  lower.solveInPlace(x);
  lower.transpose().solveInPlace(x);
  return x;
}

template <int N>
Vector<N> Cholesky<N>::whiten(const Vector<N>& b) const {
  return factors_.template triangularView<Eigen::Lower>().solve(b);
}

template <int N>
Eigen::Matrix<double, N, 15> Cholesky<N>::whiten_columns(
    const Eigen::Matrix<double, N, 15>& b) const {
  return factors_.template triangularView<Eigen::Lower>().solve(b);
}

template <int N>
Square<N> Cholesky<N>::inverse_lower() const {
  Square<N> x = Square<N>::Identity();
  factors_.template triangularView<Eigen::Lower>().solveInPlace(x);
  return x;
}

}  // namespace pipescout::linear_algebra
