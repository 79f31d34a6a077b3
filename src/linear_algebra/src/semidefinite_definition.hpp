// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>

#include "pipescout/linear_algebra/semidefinite.hpp"

namespace pipescout::linear_algebra {

template <int N, int Columns>
Eigen::Matrix<double, N, Columns> solve_semidefinite(const Square<N>& a,
                                                     const Eigen::Matrix<double, N, Columns>& b) {
  return Eigen::LDLT<Square<N>>(a).solve(b);
}

}  // namespace pipescout::linear_algebra
