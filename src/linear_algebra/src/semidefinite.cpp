// SPDX-License-Identifier: Apache-2.0
#include "semidefinite_definition.hpp"

namespace pipescout::linear_algebra {

template Vector<2> solve_semidefinite<2, 1>(const Square<2>&, const Vector<2>&);
template Vector<3> solve_semidefinite<3, 1>(const Square<3>&, const Vector<3>&);
template Square<3> solve_semidefinite<3, 3>(const Square<3>&, const Square<3>&);
template Eigen::Matrix<double, 3, 6> solve_semidefinite<3, 6>(const Square<3>&,
                                                              const Eigen::Matrix<double, 3, 6>&);

}  // namespace pipescout::linear_algebra
