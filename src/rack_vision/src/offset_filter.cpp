// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/offset_filter.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "pipescout/validation/check.hpp"

namespace pipescout::rack_vision {

void OffsetFilterParameters::validate() const {
  constexpr double kHuge = 1e3;
  validation::check_above("initial_deviation", initial_deviation, 0, kHuge);
  validation::check_within("creep", creep, 0, kHuge);
  validation::check_within("images_to_move", images_to_move, 1, 100);
  validation::check_above("largest_mean_innovation", largest_mean_innovation, 0, kHuge);
}

OffsetFilter::OffsetFilter(const RackModel& model, const OffsetFilterParameters& parameters)
    : parameters_(parameters), pipes_(model.pipes.size()) {
  parameters_.validate();
  for (std::size_t i = 0; i < pipes_; ++i) {
    movable_[i] = model.pipes[i].movable;
  }
  reset(std::vector<double>(pipes_, 0.0));
}

void OffsetFilter::reset(PipeOffsets offsets) {
  if (offsets.size() != pipes_ ||
      !std::ranges::all_of(offsets, [](double x) { return std::isfinite(x); })) {
    throw std::invalid_argument("OffsetFilter::reset: needs one finite offset per pipe");
  }
  belief_ = {};
  contradictions_ = {};
  mean_innovation_ = {};
  for (std::size_t i = 0; i < pipes_; ++i) {
    if (movable_[i]) {
      belief_.mean[i] = offsets[i];
      const int k = static_cast<int>(i);
      belief_.covariance(k, k) = parameters_.initial_deviation * parameters_.initial_deviation;
    }
  }
}

void OffsetFilter::predict(double seconds) noexcept {
  if (!(seconds > 0) || !std::isfinite(seconds)) {
    return;
  }
  for (std::size_t i = 0; i < pipes_; ++i) {
    if (movable_[i]) {
      const int k = static_cast<int>(i);
      belief_.covariance(k, k) += parameters_.creep * parameters_.creep * seconds;
    }
  }
}

void OffsetFilter::update(const PoseSolution& solution) noexcept {
  if (solution.status != PoseStatus::kOk && solution.status != PoseStatus::kUnobserved) {
    return;
  }
  const OffsetBelief before = belief_;
  belief_ = solution.offsets;
  for (std::size_t i = 0; i < pipes_; ++i) {
    contradictions_[i] = solution.offset_moved[i] ? contradictions_[i] + 1 : 0;
    if (contradictions_[i] == 0) {
      continue;
    }
    if (contradictions_[i] >= parameters_.images_to_move) {
      contradictions_[i] = 0;  // it has moved: what this image says is the belief
      continue;
    }
    // The solution did not use the belief about this pipe, and its own word is not believed yet.
    const int k = static_cast<int>(i);
    belief_.mean[i] = before.mean[i];
    belief_.covariance.row(k).setZero();
    belief_.covariance.col(k).setZero();
    belief_.covariance(k, k) = before.covariance(k, k);
  }
  watch_innovations(solution);
}

void OffsetFilter::watch_innovations(const PoseSolution& solution) noexcept {
  constexpr double kForget = 0.15;  // per image: the mean is that of about the last ten
  constexpr double kTwice = 2;      // the mean runs behind what it follows
  for (std::size_t i = 0; i < pipes_; ++i) {
    const double deviation = solution.innovation_deviation[i];
    if (!(deviation > 0) || !solution.offset_observed[i]) {
      continue;
    }
    double& mean = mean_innovation_[i];
    mean += kForget * (solution.offset_innovation[i] / deviation - mean);
    if (solution.offset_moved[i]) {
      mean = 0;  // handled as a sudden move
    } else if (std::abs(mean) > parameters_.largest_mean_innovation) {
      const double moved = kTwice * mean * deviation;
      const int k = static_cast<int>(i);
      belief_.covariance(k, k) += moved * moved;
      mean = 0;
    }
  }
}

}  // namespace pipescout::rack_vision
