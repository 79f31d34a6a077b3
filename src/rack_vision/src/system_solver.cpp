// SPDX-License-Identifier: Apache-2.0
#include "system_solver.hpp"

#include <Eigen/Cholesky>

namespace pipescout::rack_vision {

SystemVector solve_system(const SystemMatrix& a, const SystemVector& b) {
  return Eigen::LDLT<SystemMatrix>(a).solve(b);
}

SystemMatrix solve_columns(const SystemMatrix& a, const SystemMatrix& b) {
  return Eigen::LDLT<SystemMatrix>(a).solve(b);
}

SystemMatrix inverse_system(const SystemMatrix& a) {
  return solve_columns(a, SystemMatrix::Identity(a.rows(), a.cols()));
}

SystemMatrix inverse_columns(const SystemMatrix& a, int first, int count) {
  return solve_columns(a, SystemMatrix::Identity(a.rows(), a.cols()).middleCols(first, count));
}

std::optional<SystemMatrix> inverse_positive(const SystemMatrix& a) {
  const Eigen::LLT<SystemMatrix> factors(a);
  if (factors.info() != Eigen::Success) {
    return std::nullopt;
  }
  return factors.solve(SystemMatrix(SystemMatrix::Identity(a.rows(), a.cols())));
}

SystemMatrix product(const SystemMatrix& a, const SystemMatrix& b) {
  return a * b;
}

}  // namespace pipescout::rack_vision
