// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "pipescout/odometry/weld_alignment.hpp"

/// The weights of `align_welds`: see the model in its header.
namespace pipescout::odometry::alignment {

/// Usable welds: chainage rises strictly.
struct WeldSequence {
  std::vector<double> chainage;    // m
  std::vector<double> variance;    // m^2, of each sighting
  std::vector<std::size_t> index;  // in the list it comes from

  [[nodiscard]] std::size_t size() const noexcept { return chainage.size(); }
  [[nodiscard]] double joint(std::size_t k) const noexcept { return chainage[k + 1] - chainage[k]; }
};

/// The longest strictly rising part of the good welds; the indices of the rest go to `unusable`.
[[nodiscard]] WeldSequence usable(std::span<const WeldPosition> welds,
                                  std::vector<std::size_t>& unusable);

/// The same welds seen from the other end: chainage negated, order turned.
[[nodiscard]] WeldSequence mirrored(const WeldSequence& sequence);

/// Ratio of the odometers along one path.
struct RatioState {
  double mean = 1.0;
  double variance = 0.0;
};

struct Step {
  double log_weight = 0.0;
  RatioState ratio;  // after the step
};

class AlignmentModel {
 public:
  AlignmentModel(const WeldAlignmentParameters& parameters, const WeldSequence& a,
                 const WeldSequence& b);

  [[nodiscard]] const WeldSequence& a() const noexcept { return a_; }
  [[nodiscard]] const WeldSequence& b() const noexcept { return b_; }
  [[nodiscard]] const WeldAlignmentParameters& parameters() const noexcept { return parameters_; }
  [[nodiscard]] double mean_joint() const noexcept { return mean_joint_; }

  /// Before the first step: the ratio of the median joints, which is that of the odometers where
  /// both lists hold the same sort of pipe, unless it is outside of what `scale_sigma` allows.
  [[nodiscard]] RatioState first_ratio() const noexcept { return first_ratio_; }

  /// Largest |L_B - ratio L_A| that a step may have.
  [[nodiscard]] double gate(double length) const noexcept {
    return parameters_.largest_slip + 0.02 * length;
  }

  /// From the pair (i, j) to the pair (i2, j2), i2 > i, j2 > j, no gap above the longest.
  [[nodiscard]] Step step(std::size_t i, std::size_t j, std::size_t i2, std::size_t j2,
                          const RatioState& before) const;

  /// What the weight of that step cannot exceed, whatever the lengths: a fraction of its cost.
  [[nodiscard]] double log_bound(std::size_t i, std::size_t j, std::size_t i2,
                                 std::size_t j2) const noexcept {
    return log_peak_ + gap_a_[i2 - i - 1] + gap_b_[j2 - j - 1] - (null_sum_[j2] - null_sum_[j]);
  }

  /// Log weight of the welds that the overlap should hold before (i, j) when a path begins there,
  /// or after (i, j) when it ends there.
  [[nodiscard]] double log_begin(std::size_t i, std::size_t j, const RatioState& ratio) const;
  [[nodiscard]] double log_end(std::size_t i, std::size_t j, const RatioState& ratio) const;

  /// Log density of a joint length in lists that have nothing to do with each other, 1/m.
  [[nodiscard]] double log_null(double length) const noexcept;

  /// m^2, of the difference of two joints of B and A with a ratio that is known.
  [[nodiscard]] double difference_variance(std::size_t i, std::size_t i2, std::size_t j,
                                           std::size_t j2) const noexcept;

 private:
  void learn_null();
  [[nodiscard]] double gap_weight(std::size_t welds, double log_single) const noexcept;
  [[nodiscard]] double gap_of_a(std::size_t welds) const noexcept;
  [[nodiscard]] double gap_of_b(std::size_t welds) const noexcept;

  const WeldAlignmentParameters& parameters_;
  const WeldSequence& a_;
  const WeldSequence& b_;
  double mean_joint_ = 0.0;
  RatioState first_ratio_;
  double log_match_ = 0.0;
  double log_peak_ = 0.0;        // log_match and the largest value of f
  double drift_variance_ = 0.0;  // per m
  double noise_variance_ = 0.0;  // per m
  std::vector<double> gap_a_;    // log weight of 0, 1, ... longest_gap welds
  std::vector<double> gap_b_;
  std::vector<double> null_bins_;  // log density
  std::vector<double> null_sum_;   // entry j: sum of log_null over the joints of B before weld j
};

/// log(exp(a) + exp(b)).
[[nodiscard]] double log_add(double a, double b) noexcept;

}  // namespace pipescout::odometry::alignment
