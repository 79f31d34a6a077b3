// SPDX-License-Identifier: Apache-2.0
#include "cholesky_definition.hpp"

namespace pipescout::linear_algebra {

template class Cholesky<1>;
template class Cholesky<2>;
template class Cholesky<3>;
template Eigen::Matrix<double, 1, 15> Cholesky<1>::whiten_columns(
    const Eigen::Matrix<double, 1, 15>&) const;
template Eigen::Matrix<double, 3, 15> Cholesky<3>::whiten_columns(
    const Eigen::Matrix<double, 3, 15>&) const;

}  // namespace pipescout::linear_algebra
