// SPDX-License-Identifier: Apache-2.0
#include "cholesky_definition.hpp"

namespace pipescout::linear_algebra {

template class Cholesky<1>;
template class Cholesky<2>;
template class Cholesky<3>;
template class Cholesky<4>;

}  // namespace pipescout::linear_algebra
