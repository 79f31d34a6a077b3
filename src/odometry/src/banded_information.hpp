// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace pipescout::odometry {

/// Normal equations of a chain in which each unknown meets only its neighbours up to `bandwidth`
/// away (1: tridiagonal): H x = g, H symmetric and positive definite.
class BandedInformation {
 public:
  BandedInformation(std::size_t size, std::size_t bandwidth);

  /// An observation of x[i] with the given weight (1 / variance): adds to H and g.
  void observe(std::size_t i, double value, double weight);

  /// An observation of x[j] - x[i], i < j <= i + bandwidth.
  void observe_difference(std::size_t i, std::size_t j, double value, double weight);

  /// x. Factorises H = L D L^T in place: call once, then `covariance`.
  /// Throws std::domain_error when H is not positive definite.
  [[nodiscard]] std::vector<double> solve();

  /// Entry (i, j) of the inverse of H, i <= j <= i + bandwidth: Takahashi's recursion, exact.
  [[nodiscard]] double covariance(std::size_t i, std::size_t j) const {
    return inverse_[i * (bandwidth_ + 1) + (j - i)];
  }

 private:
  [[nodiscard]] double& entry(std::size_t i, std::size_t j) {  // i <= j
    return band_[i * (bandwidth_ + 1) + (j - i)];
  }
  void invert();

  std::size_t size_;
  std::size_t bandwidth_;
  std::vector<double> band_;     // upper band of H by rows; after `solve` D, and L^T beside it
  std::vector<double> right_;    // g
  std::vector<double> inverse_;  // upper band
};

}  // namespace pipescout::odometry
