// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/linear_algebra/cholesky.hpp"

namespace pipescout::linear_algebra {

/// J P J^T: the covariance of y = J x to first order, where P is that of x. (Rows, N) is (1, 15),
/// (3, 15), (6, 15), (15, 15), (6, 6) or (3, 3).
template <int Rows, int N>
[[nodiscard]] Square<Rows> propagate(const Eigen::Matrix<double, Rows, N>& jacobian,
                                     const Square<N>& covariance);

/// J^T J: the information of rows J of unit covariance. N is 15.
template <int N>
[[nodiscard]] Square<N> information_of(const Square<N>& rows);

/// A B. N is 15.
template <int N>
[[nodiscard]] Square<N> product(const Square<N>& a, const Square<N>& b);

/// The inverse of any regular matrix, by LU with partial pivoting. N is 6.
template <int N>
[[nodiscard]] Square<N> inverse(const Square<N>& a);

}  // namespace pipescout::linear_algebra
