// SPDX-License-Identifier: Apache-2.0
#include "offset_memory.hpp"

#include <algorithm>
#include <optional>

#include "system_solver.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr int kJudgedSamples = 10;
constexpr double kSupportedShare = 0.5;  // of the samples of a pipe: it is where it is seen
constexpr double kDoubtedShare = 0.35;
constexpr int kImagesInDoubt = 10;
constexpr double kOffsetFloor = 0.0015;  // m: what shading and shadows that stay leave of an error
constexpr double kPlaceSigma = 0.01;     // m: a place is exact to a step of the search
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
  images_in_doubt_ = {};
  for (std::size_t i = 0; i < pipes_; ++i) {
    if (movable_[i]) {
      set(i, 0, sigma_);
    }
  }
}

void OffsetMemory::predict(double dt) {
  for (std::size_t i = 0; i < pipes_; ++i) {
    if (may_move(i)) {
      const auto pipe = static_cast<Eigen::Index>(i);
      belief_.covariance(pipe, pipe) += kOffsetDrift * kOffsetDrift * dt;
    }
  }
}

bool OffsetMemory::may_move(std::size_t pipe) const noexcept {
  const auto row = static_cast<Eigen::Index>(pipe);
  return belief_.covariance(row, row) > 0;
}

void OffsetMemory::set(std::size_t pipe, double mean, double sigma) {
  const auto row = static_cast<Eigen::Index>(pipe);
  belief_.mean[pipe] = mean;
  belief_.covariance.row(row).setZero();
  belief_.covariance.col(row).setZero();
  belief_.covariance(row, row) = sigma * sigma;
}

void OffsetMemory::widen(double sigma) {
  for (std::size_t i = 0; i < pipes_; ++i) {
    const auto pipe = static_cast<Eigen::Index>(i);
    if (may_move(i) && belief_.covariance(pipe, pipe) < sigma * sigma) {
      set(i, belief_.mean[i], sigma);
    }
  }
}

void OffsetMemory::doubt() {
  for (std::size_t i = 0; i < pipes_; ++i) {
    if (may_move(i)) {
      doubt(i);
    }
  }
}

void OffsetMemory::doubt(std::size_t pipe) {
  set(pipe, belief_.mean[pipe], sigma_);
}

bool OffsetMemory::judge(std::size_t pipe, const PipeSupport& support) {
  if (support.searched < kJudgedSamples) {
    return false;
  }
  if (support.found < kDoubtedShare * support.searched) {
    if (++images_in_doubt_[pipe] >= kImagesInDoubt) {
      images_in_doubt_[pipe] = 0;
      doubt(pipe);  // it may only be hard to see for a while
    }
    return false;
  }
  images_in_doubt_[pipe] = 0;
  return support.found >= kSupportedShare * support.searched;
}

void OffsetMemory::place(std::size_t pipe, double offset) {
  set(pipe, offset, kPlaceSigma);
  belief_.unplaced[pipe] = false;
}

void OffsetMemory::learn(const OffsetBelief& after, std::span<const PipeSupport> support,
                         double share) {
  belief_.unplaced = after.unplaced;
  std::array<int, kMaxPipes> index{};  // among the pipes that were seen; -1: it was not
  int seen = 0;
  for (std::size_t i = 0; i < pipes_; ++i) {
    index[i] = may_move(i) && judge(i, support[i]) ? seen++ : -1;
  }
  if (seen == 0) {
    return;
  }
  SystemVector step(seen);
  SystemMatrix before(seen, seen), found(seen, seen);
  for (std::size_t i = 0; i < pipes_; ++i) {
    if (index[i] < 0) {
      continue;
    }
    const auto row = static_cast<Eigen::Index>(i);
    if (after.covariance(row, row) > belief_.covariance(row, row)) {
      return;  // what the image says contradicts itself
    }
    step(index[i]) = after.mean[i] - belief_.mean[i];
    for (std::size_t j = 0; j < pipes_; ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      if (index[j] >= 0) {
        before(index[i], index[j]) = belief_.covariance(row, column);
        found(index[i], index[j]) = after.covariance(row, column);
      }
    }
  }
  const std::optional<SystemMatrix> prior = inverse_positive(before);
  const std::optional<SystemMatrix> posterior = inverse_positive(found);
  if (!prior || !posterior) {
    return;
  }
  const auto covariance = inverse_positive(*prior + share * (*posterior - *prior));
  if (!covariance) {
    return;
  }
  const SystemVector moved = share * *covariance * (*posterior * step);
  if (!covariance->allFinite() || !moved.allFinite()) {
    return;
  }
  for (std::size_t i = 0; i < pipes_; ++i) {
    if (index[i] < 0) {
      continue;
    }
    const auto row = static_cast<Eigen::Index>(i);
    belief_.mean[i] += moved(index[i]);
    for (std::size_t j = 0; j < pipes_; ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      if (j != i) {
        // What hangs together with a pipe that was not seen is forgotten.
        const double shared = index[j] >= 0 ? (*covariance)(index[i], index[j]) : 0.0;
        belief_.covariance(row, column) = shared;
        belief_.covariance(column, row) = shared;
      }
    }
    belief_.covariance(row, row) =
        std::max((*covariance)(index[i], index[i]), kOffsetFloor * kOffsetFloor);
  }
}

}  // namespace pipescout::rack_vision
