// SPDX-License-Identifier: Apache-2.0
#include "offset_uncertainty.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace pipescout::rack_vision {

OffsetUncertainty::OffsetUncertainty(const RackModel& model, double sigma) : sigma_(sigma) {
  for (std::size_t i = 0; i < model.pipes.size(); ++i) {
    movable_[i] = model.pipes[i].movable;
  }
  reset();
}

void OffsetUncertainty::reset() {
  has_begun_ = false;
  covariance_.setZero();
  for (std::size_t i = 0; i < kMaxPipes; ++i) {
    forget(i);
  }
}

void OffsetUncertainty::widen(double variance) {
  for (std::size_t i = 0; i < kMaxPipes; ++i) {
    if (movable_[i] && sigma_ > 0) {
      covariance_(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) += variance;
    }
  }
}

void OffsetUncertainty::forget(std::size_t pipe) {
  if (!movable_[pipe]) {
    return;
  }
  const double together = sigma_ * sigma_;
  const auto row = static_cast<Eigen::Index>(pipe);
  for (std::size_t i = 0; i < kMaxPipes; ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const double shared = movable_[i] ? std::min(together, covariance_(column, column)) : 0.0;
    covariance_(row, column) = covariance_(column, row) = shared;
  }
  covariance_(row, row) = 2 * together;
}

void OffsetUncertainty::begin(const OffsetMatrix& after) {
  has_begun_ = true;
  for (std::size_t i = 0; i < kMaxPipes; ++i) {
    for (std::size_t j = 0; j < kMaxPipes; ++j) {
      if (movable_[i] && movable_[j]) {
        const auto row = static_cast<Eigen::Index>(i);
        const auto column = static_cast<Eigen::Index>(j);
        covariance_(row, column) = after(row, column) + sigma_ * sigma_;
      }
    }
  }
}

void OffsetUncertainty::learn(const OffsetMatrix& by_edges, double share) {
  constexpr double kNothing = 1e-6;
  if (!(share > kNothing)) {
    return;
  }
  // Rows of pipes that are not estimated have no variance: 1 there leaves the others alone.
  OffsetMatrix sum = covariance_ + by_edges / share;
  for (Eigen::Index i = 0; i < sum.rows(); ++i) {
    if (!(by_edges(i, i) > 0)) {
      sum.row(i).setZero();
      sum.col(i).setZero();
      sum(i, i) = 1;
    }
  }
  OffsetMatrix known = covariance_;
  for (Eigen::Index i = 0; i < sum.rows(); ++i) {
    if (!(by_edges(i, i) > 0)) {
      known.row(i).setZero();
    }
  }
  const OffsetMatrix gained = known.transpose() * sum.llt().solve(known);
  if (gained.allFinite()) {
    covariance_ -= gained;
    covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
  }
}

}  // namespace pipescout::rack_vision
