// SPDX-License-Identifier: Apache-2.0
#include "semidefinite_definition.hpp"

namespace pipescout::linear_algebra {

template Vector<6> solve_semidefinite<6, 1>(const Square<6>&, const Vector<6>&);
template Square<6> solve_semidefinite<6, 6>(const Square<6>&, const Square<6>&);
template Vector<9> solve_semidefinite<9, 1>(const Square<9>&, const Vector<9>&);
template Eigen::Matrix<double, 12, 6> solve_semidefinite<12, 6>(
    const Square<12>&, const Eigen::Matrix<double, 12, 6>&);

}  // namespace pipescout::linear_algebra
