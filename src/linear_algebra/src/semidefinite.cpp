// SPDX-License-Identifier: Apache-2.0
#include "pipescout/linear_algebra/semidefinite.hpp"

#include <Eigen/Cholesky>

namespace pipescout::linear_algebra {

template <int N, int Columns>
Eigen::Matrix<double, N, Columns> solve_semidefinite(const Square<N>& a,
                                                     const Eigen::Matrix<double, N, Columns>& b) {
  return Eigen::LDLT<Square<N>>(a).solve(b);
}

template Vector<2> solve_semidefinite<2, 1>(const Square<2>&, const Vector<2>&);
template Vector<3> solve_semidefinite<3, 1>(const Square<3>&, const Vector<3>&);
template Square<3> solve_semidefinite<3, 3>(const Square<3>&, const Square<3>&);
template Eigen::Matrix<double, 3, 6> solve_semidefinite<3, 6>(const Square<3>&,
                                                              const Eigen::Matrix<double, 3, 6>&);
template Vector<6> solve_semidefinite<6, 1>(const Square<6>&, const Vector<6>&);
template Square<6> solve_semidefinite<6, 6>(const Square<6>&, const Square<6>&);
template Vector<9> solve_semidefinite<9, 1>(const Square<9>&, const Vector<9>&);
template Eigen::Matrix<double, 12, 6> solve_semidefinite<12, 6>(
    const Square<12>&, const Eigen::Matrix<double, 12, 6>&);

}  // namespace pipescout::linear_algebra
