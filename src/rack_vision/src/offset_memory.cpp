// SPDX-License-Identifier: Apache-2.0
#include "offset_memory.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace pipescout::rack_vision {
namespace {

using OffsetVector = Eigen::Matrix<double, static_cast<int>(kMaxPipes), 1>;

constexpr double kAlikeImages = 25;
constexpr double kOffsetFloor = 0.0015;  // m: what shading and shadows that stay leave of an error
constexpr double kOffsetDrift = 0.0003;  // m/sqrt(s): pipes move by heat and flow

}  // namespace

OffsetMemory::OffsetMemory(const RackModel& model, double sigma)
    : pipes_(model.pipes.size()), sigma_(sigma) {
  for (std::size_t i = 0; i < pipes_; ++i) {
    movable_[i] = model.pipes[i].movable;
  }
  reset();
}

void OffsetMemory::reset() {
  belief_ = {};
  for (std::size_t i = 0; i < pipes_; ++i) {
    if (movable_[i]) {
      const auto pipe = static_cast<Eigen::Index>(i);
      belief_.covariance(pipe, pipe) = sigma_ * sigma_;
    }
  }
}

void OffsetMemory::predict(double dt) {
  for (std::size_t i = 0; i < pipes_; ++i) {
    const auto pipe = static_cast<Eigen::Index>(i);
    if (belief_.covariance(pipe, pipe) > 0) {
      belief_.covariance(pipe, pipe) += kOffsetDrift * kOffsetDrift * dt;
    }
  }
}

void OffsetMemory::learn(const OffsetBelief& after) {
  OffsetVector step = OffsetVector::Zero();
  OffsetMatrix prior = OffsetMatrix::Identity();
  OffsetMatrix posterior = OffsetMatrix::Identity();
  for (std::size_t i = 0; i < pipes_; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    if (belief_.covariance(row, row) <= 0) {
      continue;
    }
    step(row) = after.mean[i] - belief_.mean[i];
    for (std::size_t j = 0; j < pipes_; ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      if (belief_.covariance(column, column) > 0) {
        prior(row, column) = belief_.covariance(row, column);
        posterior(row, column) = after.covariance(row, column);
      }
    }
  }
  prior = prior.llt().solve(OffsetMatrix::Identity()).eval();
  posterior = posterior.llt().solve(OffsetMatrix::Identity()).eval();
  const OffsetMatrix information = prior + (posterior - prior) / kAlikeImages;
  const OffsetMatrix covariance = information.llt().solve(OffsetMatrix::Identity());
  const OffsetVector moved = covariance * (posterior * step) / kAlikeImages;
  if (!covariance.allFinite() || !moved.allFinite()) {
    return;
  }
  for (std::size_t i = 0; i < pipes_; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    if (belief_.covariance(row, row) <= 0) {
      continue;
    }
    belief_.mean[i] += moved(row);
    for (std::size_t j = 0; j < pipes_; ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      if (belief_.covariance(column, column) > 0 && j != i) {
        belief_.covariance(row, column) = covariance(row, column);
      }
    }
  }
  for (std::size_t i = 0; i < pipes_; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    if (belief_.covariance(row, row) > 0) {
      belief_.covariance(row, row) = std::max(covariance(row, row), kOffsetFloor * kOffsetFloor);
    }
  }
}

}  // namespace pipescout::rack_vision
