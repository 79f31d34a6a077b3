// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bitset>

#include "feature_system.hpp"

namespace pipescout::rack_vision {

/// The belief about the offsets within the solution of one image: loose at first, so that pipes
/// that moved pull on their belief and not on the pose; then as it is, but for those that moved.
class OffsetPrior {
 public:
  /// `freedom`: added deviation while it is loose, m; 0: strict from the start.
  /// Returns false when the belief's covariance is none.
  [[nodiscard]] bool start(const OffsetBelief& belief, const UnknownLayout& layout, double freedom);
  void add(const SolverState& state, SystemMatrix& information, SystemVector& gradient,
           double& cost) const;
  /// Compares the belief with `state`, which was found with the loose prior and this information
  /// (data and priors), and tightens the prior of the pipes that lie where they were believed.
  void judge(const SolverState& state, const SystemMatrix& information, double innovation_gate);
  /// What `judge` found, as the fields of PoseSolution.
  void report(PoseSolution& solution) const;

 private:
  [[nodiscard]] bool set_information(const SystemVector& added_variance);
  [[nodiscard]] SystemVector innovation(const SolverState& state) const;

  UnknownLayout layout_;
  SystemVector mean_;
  SystemMatrix covariance_, information_;
  double freedom_ = 0;
  std::bitset<kMaxPipes> moved_;
  std::array<double, kMaxPipes> compared_{}, deviation_{};
};

}  // namespace pipescout::rack_vision
