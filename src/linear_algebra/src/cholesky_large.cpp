// SPDX-License-Identifier: Apache-2.0
#include "cholesky_definition.hpp"

namespace pipescout::linear_algebra {

template class Cholesky<6>;
template class Cholesky<15>;

}  // namespace pipescout::linear_algebra
