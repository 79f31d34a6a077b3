// SPDX-License-Identifier: Apache-2.0
#include "banded_information.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace pipescout::odometry {

BandedInformation::BandedInformation(std::size_t size, std::size_t bandwidth)
    : size_(size), bandwidth_(bandwidth), band_(size * (bandwidth + 1), 0.0), right_(size, 0.0) {}

void BandedInformation::observe(std::size_t i, double value, double weight) {
  entry(i, i) += weight;
  right_[i] += weight * value;
}

void BandedInformation::observe_difference(std::size_t i, std::size_t j, double value,
                                           double weight) {
  entry(i, i) += weight;
  entry(j, j) += weight;
  entry(i, j) -= weight;
  right_[i] -= weight * value;
  right_[j] += weight * value;
}

std::vector<double> BandedInformation::solve() {
  std::vector<double> x = right_;
  for (std::size_t k = 0; k < size_; ++k) {
    const double pivot = entry(k, k);
    if (!(pivot > 0.0)) {
      throw std::domain_error("the normal equations are not positive definite");
    }
    const std::size_t end = std::min(size_, k + bandwidth_ + 1);
    for (std::size_t i = k + 1; i < end; ++i) {
      const double factor = entry(k, i) / pivot;
      if (factor != 0.0) {
        for (std::size_t j = i; j < end; ++j) {
          entry(i, j) -= factor * entry(k, j);
        }
        x[i] -= factor * x[k];
      }
    }
    for (std::size_t i = k + 1; i < end; ++i) {
      entry(k, i) /= pivot;
    }
  }
  for (std::size_t k = size_; k-- > 0;) {
    x[k] /= entry(k, k);
    for (std::size_t j = k + 1; j < std::min(size_, k + bandwidth_ + 1); ++j) {
      x[k] -= entry(k, j) * x[j];
    }
  }
  invert();
  return x;
}

/// Z = D^-1 L^-1 + (I - L^T) Z, of which the band needs only itself.
void BandedInformation::invert() {
  inverse_.assign(band_.size(), 0.0);
  const auto z = [this](std::size_t i, std::size_t j) -> double& {
    return inverse_[std::min(i, j) * (bandwidth_ + 1) + (std::max(i, j) - std::min(i, j))];
  };
  for (std::size_t k = size_; k-- > 0;) {
    const std::size_t end = std::min(size_, k + bandwidth_ + 1);
    for (std::size_t j = end; j-- > k;) {
      double sum = j == k ? 1.0 / entry(k, k) : 0.0;
      for (std::size_t i = k + 1; i < end; ++i) {
        sum -= entry(k, i) * z(i, j);
      }
      z(k, j) = sum;
    }
  }
}

}  // namespace pipescout::odometry
