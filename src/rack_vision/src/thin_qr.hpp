// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace pipescout::rack_vision {

/// A = Q R with as many columns in Q as in A, by Householder's reflections. Compiled once for every
/// size: it serves tables that are made at start.
struct ThinQr {
  explicit ThinQr(const Eigen::MatrixXd& a);  ///< at least as many rows as columns

  Eigen::MatrixXd q;  ///< rows x columns, orthonormal columns
  Eigen::MatrixXd r;  ///< columns x columns, upper triangular
};

}  // namespace pipescout::rack_vision
