// SPDX-License-Identifier: Apache-2.0
#include "symmetric_eigen_definition.hpp"

namespace pipescout::linear_algebra {

template SymmetricEigen<6> symmetric_eigen<6>(const Square<6>&);

}  // namespace pipescout::linear_algebra
