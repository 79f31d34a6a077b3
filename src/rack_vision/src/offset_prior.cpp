// SPDX-License-Identifier: Apache-2.0
#include "offset_prior.hpp"

#include <cmath>

#include "system_solver.hpp"

namespace pipescout::rack_vision {

bool OffsetPrior::start(const OffsetBelief& belief, const UnknownLayout& layout, double freedom) {
  layout_ = layout;
  freedom_ = freedom;
  moved_.reset();
  compared_ = deviation_ = {};
  mean_.setZero(layout.offset_count);
  covariance_.setZero(layout.offset_count, layout.offset_count);
  for (int i = 0; i < static_cast<int>(kMaxPipes); ++i) {
    const int row = layout.offset[static_cast<std::size_t>(i)] - kPoseUnknowns;
    if (row < 0) {
      continue;
    }
    mean_[row] = belief.mean[static_cast<std::size_t>(i)];
    for (int j = 0; j < static_cast<int>(kMaxPipes); ++j) {
      const int column = layout.offset[static_cast<std::size_t>(j)] - kPoseUnknowns;
      if (column >= 0) {
        covariance_(row, column) = 0.5 * (belief.covariance(i, j) + belief.covariance(j, i));
      }
    }
  }
  return set_information(SystemVector::Constant(layout.offset_count, freedom * freedom));
}

bool OffsetPrior::set_information(const SystemVector& added_variance) {
  SystemMatrix widened = covariance_;
  widened.diagonal() += added_variance;
  if (layout_.offset_count == 0) {
    information_.setZero(0, 0);
    return true;
  }
  const std::optional<SystemMatrix> inverse = inverse_positive(widened);
  if (inverse) {
    information_ = *inverse;
  }
  return inverse.has_value();
}

void OffsetPrior::report(PoseSolution& solution) const {
  solution.offset_moved = moved_;
  solution.offset_innovation = compared_;
  solution.innovation_deviation = deviation_;
}

SystemVector OffsetPrior::innovation(const SolverState& state) const {
  SystemVector difference = -mean_;
  for (std::size_t i = 0; i < kMaxPipes; ++i) {
    if (layout_.offset[i] >= 0) {
      difference[layout_.offset[i] - kPoseUnknowns] += state.offsets[i];
    }
  }
  return difference;
}

void OffsetPrior::add(const SolverState& state, SystemMatrix& information, SystemVector& gradient,
                      double& cost) const {
  const int n = layout_.offset_count;
  if (n == 0) {
    return;
  }
  const SystemVector difference = innovation(state);
  const SystemVector weighted = information_ * difference;
  information.block(kPoseUnknowns, kPoseUnknowns, n, n) += information_;
  gradient.segment(kPoseUnknowns, n) += weighted;
  cost += 0.5 * difference.dot(weighted);
}

void OffsetPrior::judge(const SolverState& state, const SystemMatrix& information,
                        double innovation_gate) {
  const int n = layout_.offset_count;
  if (n == 0 || freedom_ == 0) {
    return;
  }
  SystemMatrix regular = information;
  // What is not observed (the place along the pipes) must not stop the inverse.
  constexpr double kTrace = 1e-6;
  regular.diagonal().array() += kTrace;
  // Of the inverse, the columns of the offsets.
  const SystemMatrix covariance = inverse_columns(regular, kPoseUnknowns, n);
  const SystemVector difference = innovation(state);
  SystemVector added = SystemVector::Zero(n);
  for (std::size_t i = 0; i < kMaxPipes; ++i) {
    const int unknown = layout_.offset[i];
    if (unknown < 0) {
      continue;
    }
    const int k = unknown - kPoseUnknowns;
    const double variance = covariance(unknown, k) + covariance_(k, k);
    compared_[i] = difference[k];
    deviation_[i] = std::sqrt(variance);
    if (difference[k] * difference[k] > innovation_gate * innovation_gate * variance) {
      moved_.set(i);
      added[k] = std::max(freedom_ * freedom_, difference[k] * difference[k]);
    }
  }
  if (!set_information(added)) {
    // The belief knows some combination of offsets exactly: the loose one does for this image.
    (void)set_information(SystemVector::Constant(n, freedom_ * freedom_));
  }
}

}  // namespace pipescout::rack_vision
