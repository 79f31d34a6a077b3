// SPDX-License-Identifier: Apache-2.0
#include "cholesky_definition.hpp"

namespace pipescout::linear_algebra {

template class Cholesky<4>;
template class Cholesky<6>;
template class Cholesky<15>;
template Eigen::Matrix<double, 6, 15> Cholesky<6>::whiten_columns(
    const Eigen::Matrix<double, 6, 15>&) const;

}  // namespace pipescout::linear_algebra
