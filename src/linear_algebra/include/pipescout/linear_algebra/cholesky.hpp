// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

/// Decompositions and products of small fixed-size matrices, compiled once: Eigen's templates take
/// a second or more of compile time for each size in each file that uses them. Results are those of
/// Eigen, with the same signs, orders and tolerances. No allocation. A size that is not listed does
/// not link.
namespace pipescout::linear_algebra {

template <int N>
using Square = Eigen::Matrix<double, N, N>;
template <int N>
using Vector = Eigen::Matrix<double, N, 1>;

/// A = L L^T of a symmetric positive definite matrix, of which the lower triangle is read
/// (Eigen::LLT). N is 1, 2, 3, 4, 6 or 15.
///
/// When `succeeded()` is false, all other results are unspecified. NaN in A is not always detected.
template <int N>
class Cholesky {
 public:
  explicit Cholesky(const Square<N>& a);

  /// Whether A was positive definite to rounding.
  [[nodiscard]] bool succeeded() const noexcept { return succeeded_; }
  /// L, zero above the diagonal.
  [[nodiscard]] Square<N> lower() const;
  /// The diagonal of L, all positive.
  [[nodiscard]] Vector<N> diagonal() const { return factors_.diagonal(); }
  /// ln det A
  [[nodiscard]] double log_determinant() const;
  /// A^-1 b
  [[nodiscard]] Vector<N> solve(const Vector<N>& b) const;
  /// A^-1, symmetric to rounding.
  [[nodiscard]] Square<N> inverse() const;
  /// L^-1 b: of unit covariance where A is the covariance of b.
  [[nodiscard]] Vector<N> whiten(const Vector<N>& b) const;
  /// L^-1 B; (N, Columns) is (1, 15), (3, 15) or (6, 15).
  template <int Columns>
  [[nodiscard]] Eigen::Matrix<double, N, Columns> whiten_columns(
      const Eigen::Matrix<double, N, Columns>& b) const;
  /// L^-1, lower triangular: W with W^T W = A^-1.
  [[nodiscard]] Square<N> inverse_lower() const;

 private:
  Square<N> factors_;  // L in the lower triangle; above it, entries of A
  bool succeeded_;
};

extern template class Cholesky<1>;
extern template class Cholesky<2>;
extern template class Cholesky<3>;
extern template class Cholesky<4>;
extern template class Cholesky<6>;
extern template class Cholesky<15>;

}  // namespace pipescout::linear_algebra
