// SPDX-License-Identifier: Apache-2.0
#include "weld_alignment_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipescout/statistics/median.hpp"

namespace pipescout::odometry::alignment {
namespace {

constexpr double kBin = 0.02;             // m, of the null density
constexpr double kLongestBinned = 100.0;  // m, longer joints share the floor
constexpr double kFloorShare = 0.05;      // of the null density is spread over all lengths
constexpr double kInverseSqrtTwoPi = 0.3989422804014327;

double median_joint(const WeldSequence& sequence) {
  std::vector<double> joints(sequence.size() - 1);
  for (std::size_t k = 0; k < joints.size(); ++k) {
    joints[k] = sequence.joint(k);
  }
  return statistics::median_in_place(joints);
}

double mean_joint_of(const WeldSequence& sequence) {
  return (sequence.chainage.back() - sequence.chainage.front()) /
         static_cast<double>(sequence.size() - 1);
}

}  // namespace

double log_add(double a, double b) noexcept {
  const double larger = std::max(a, b);
  const double smaller = std::min(a, b);
  return std::isinf(smaller) ? larger : larger + std::log1p(std::exp(smaller - larger));
}

WeldSequence usable(std::span<const WeldPosition> welds, std::vector<std::size_t>& unusable) {
  std::vector<std::size_t> tails;  // entry k: last weld of the best rising part of k + 1 welds
  std::vector<std::size_t> previous(welds.size(), welds.size());
  for (std::size_t k = 0; k < welds.size(); ++k) {
    const WeldPosition& weld = welds[k];
    if (!std::isfinite(weld.chainage) || !std::isfinite(weld.standard_deviation) ||
        weld.standard_deviation <= 0.0) {
      continue;
    }
    const auto place = std::lower_bound(
        tails.begin(), tails.end(), weld.chainage,
        [&](std::size_t tail, double chainage) { return welds[tail].chainage < chainage; });
    if (place != tails.begin()) {
      previous[k] = *(place - 1);
    }
    if (place == tails.end()) {
      tails.push_back(k);
    } else if (weld.chainage < welds[*place].chainage) {
      *place = k;  // of equal chainages the first stays
    }
  }
  std::vector<std::size_t> kept;
  for (std::size_t k = tails.empty() ? welds.size() : tails.back(); k < welds.size();
       k = previous[k]) {
    kept.push_back(k);
  }
  std::reverse(kept.begin(), kept.end());
  WeldSequence sequence;
  for (std::size_t k = 0, next = 0; k < welds.size(); ++k) {
    if (next < kept.size() && kept[next] == k) {
      sequence.chainage.push_back(welds[k].chainage);
      sequence.variance.push_back(welds[k].standard_deviation * welds[k].standard_deviation);
      sequence.index.push_back(k);
      ++next;
    } else {
      unusable.push_back(k);
    }
  }
  return sequence;
}

WeldSequence mirrored(const WeldSequence& sequence) {
  WeldSequence mirror = sequence;
  std::reverse(mirror.chainage.begin(), mirror.chainage.end());
  std::reverse(mirror.variance.begin(), mirror.variance.end());
  std::reverse(mirror.index.begin(), mirror.index.end());
  for (double& chainage : mirror.chainage) {
    chainage = -chainage;
  }
  return mirror;
}

AlignmentModel::AlignmentModel(const WeldAlignmentParameters& parameters, const WeldSequence& a,
                               const WeldSequence& b)
    : parameters_(parameters),
      a_(a),
      b_(b),
      mean_joint_(std::min(mean_joint_of(a), mean_joint_of(b))),
      log_match_(std::log1p(-parameters.missed_probability) +
                 std::log1p(-parameters.spurious_probability)),
      drift_variance_(parameters.scale_drift * parameters.scale_drift / 1000.0),
      noise_variance_(parameters.length_noise * parameters.length_noise) {
  const double least_variance = 2.0 * *std::min_element(a.variance.begin(), a.variance.end()) +
                                2.0 * *std::min_element(b.variance.begin(), b.variance.end());
  log_peak_ =
      log_match_ +
      std::log((1.0 - parameters.slip_probability) * kInverseSqrtTwoPi / std::sqrt(least_variance) +
               parameters.slip_probability * std::numbers::inv_pi / parameters.slip_scale);
  const double ratio = median_joint(b) / median_joint(a);
  if (std::abs(ratio - 1.0) <= 2.0 * parameters.scale_sigma) {
    first_ratio_.mean = ratio;
  }
  first_ratio_.variance = parameters.scale_sigma * parameters.scale_sigma;
  for (std::size_t welds = 0; welds <= parameters.longest_gap; ++welds) {
    gap_a_.push_back(gap_weight(welds, std::log(parameters.missed_probability)));
    // A spurious weld lies anywhere in its joint: density 1 / length.
    gap_b_.push_back(gap_weight(welds, std::log(parameters.spurious_probability)) -
                     static_cast<double>(welds) * std::log(mean_joint_));
  }
  learn_null();
}

void AlignmentModel::learn_null() {
  double longest = 0.0;
  for (const WeldSequence* sequence : {&a_, &b_}) {
    for (std::size_t k = 0; k + 1 < sequence->size(); ++k) {
      longest = std::max(longest, sequence->joint(k));
    }
  }
  longest = std::min(longest, kLongestBinned);
  const auto bins = static_cast<std::size_t>(longest / kBin) + 2;
  std::vector<double> counts(bins, 0.0);
  double joints = 0.0;
  double variance = 0.0;
  for (const WeldSequence* sequence : {&a_, &b_}) {
    for (std::size_t k = 0; k + 1 < sequence->size(); ++k) {
      const double length = sequence->joint(k);
      variance += sequence->variance[k] + sequence->variance[k + 1] + noise_variance_ * length;
      joints += 1.0;
      if (length < longest) {
        counts[static_cast<std::size_t>(length / kBin)] += 1.0;
      }
    }
  }
  // Smoothed by a box twice: a triangle as wide as the noise that the lengths carry.
  const auto half = std::max<std::size_t>(
      1, static_cast<std::size_t>(
             std::min(std::sqrt(1.5 * variance / joints) / kBin, static_cast<double>(bins))));
  std::vector<double> sums(bins + 1, 0.0);
  for (int pass = 0; pass < 2; ++pass) {
    for (std::size_t bin = 0; bin < bins; ++bin) {
      sums[bin + 1] = sums[bin] + counts[bin];
    }
    for (std::size_t bin = 0; bin < bins; ++bin) {
      const std::size_t from = bin - std::min(bin, half);
      const std::size_t to = std::min(bin + half + 1, bins);
      counts[bin] = (sums[to] - sums[from]) / static_cast<double>(2 * half + 1);
    }
  }
  const double floor = kFloorShare / std::max(longest, mean_joint_);
  null_bins_.resize(bins);
  for (std::size_t bin = 0; bin < bins; ++bin) {
    null_bins_[bin] = std::log(floor + (1.0 - kFloorShare) * counts[bin] / (joints * kBin));
  }
  null_sum_.assign(b_.size(), 0.0);
  for (std::size_t j = 0; j + 1 < b_.size(); ++j) {
    null_sum_[j + 1] = null_sum_[j] + log_null(b_.joint(j));
  }
}

double AlignmentModel::log_null(double length) const noexcept {
  const double bin = length / kBin;
  return bin < static_cast<double>(null_bins_.size()) ? null_bins_[static_cast<std::size_t>(bin)]
                                                      : null_bins_.back();
}

double AlignmentModel::gap_weight(std::size_t welds, double log_single) const noexcept {
  if (welds == 0) {
    return 0.0;
  }
  const double count = static_cast<double>(welds);
  const double singly = count * log_single;
  const double outage = std::log(parameters_.outage_probability / parameters_.outage_welds) +
                        (count - 1.0) * std::log1p(-1.0 / (parameters_.outage_welds + 1.0));
  return log_add(singly, outage);
}

double AlignmentModel::gap_of_a(std::size_t welds) const noexcept {
  return welds < gap_a_.size() ? gap_a_[welds]
                               : gap_weight(welds, std::log(parameters_.missed_probability));
}

double AlignmentModel::gap_of_b(std::size_t welds) const noexcept {
  return welds < gap_b_.size() ? gap_b_[welds]
                               : gap_weight(welds, std::log(parameters_.spurious_probability)) -
                                     static_cast<double>(welds) * std::log(mean_joint_);
}

double AlignmentModel::difference_variance(std::size_t i, std::size_t i2, std::size_t j,
                                           std::size_t j2) const noexcept {
  return a_.variance[i] + a_.variance[i2] + b_.variance[j] + b_.variance[j2] +
         noise_variance_ * (a_.chainage[i2] - a_.chainage[i]);
}

Step AlignmentModel::step(std::size_t i, std::size_t j, std::size_t i2, std::size_t j2,
                          const RatioState& before) const {
  const double length_a = a_.chainage[i2] - a_.chainage[i];
  const double length_b = b_.chainage[j2] - b_.chainage[j];
  const double ratio_variance = before.variance + drift_variance_ * length_a;
  const double residual = length_b - before.mean * length_a;
  const double cross = ratio_variance * length_a;
  const double variance = difference_variance(i, i2, j, j2) + cross * length_a;
  const double normal = (1.0 - parameters_.slip_probability) * kInverseSqrtTwoPi /
                        std::sqrt(variance) * std::exp(-0.5 * residual * residual / variance);
  const double width = parameters_.slip_scale;
  const double slip = parameters_.slip_probability * width * std::numbers::inv_pi /
                      (width * width + residual * residual);
  // A slip says nothing about the ratio: only the normal part moves it.
  const double trust = normal / (normal + slip);
  const double gain = trust * cross / variance;
  return {
      .log_weight = std::log(normal + slip) + log_match_ + gap_a_[i2 - i - 1] + gap_b_[j2 - j - 1] -
                    (null_sum_[j2] - null_sum_[j]),
      .ratio = {.mean = before.mean + gain * residual, .variance = ratio_variance - gain * cross}};
}

double AlignmentModel::log_begin(std::size_t i, std::size_t j, const RatioState& ratio) const {
  // Welds before this pair which the other list should have: those that it reaches.
  const double start_of_b = a_.chainage[i] - (b_.chainage[j] - b_.chainage[0]) / ratio.mean;
  const double start_of_a = b_.chainage[j] - (a_.chainage[i] - a_.chainage[0]) * ratio.mean;
  const double margin = 0.5 * mean_joint_;
  const auto first_a =
      std::lower_bound(a_.chainage.begin(), a_.chainage.begin() + static_cast<std::ptrdiff_t>(i),
                       start_of_b - margin) -
      a_.chainage.begin();
  const auto first_b =
      std::lower_bound(b_.chainage.begin(), b_.chainage.begin() + static_cast<std::ptrdiff_t>(j),
                       start_of_a - margin) -
      b_.chainage.begin();
  const auto from = static_cast<std::size_t>(first_b);
  return gap_of_a(i - static_cast<std::size_t>(first_a)) + gap_of_b(j - from) -
         (null_sum_[j] - null_sum_[from]);
}

double AlignmentModel::log_end(std::size_t i, std::size_t j, const RatioState& ratio) const {
  const double end_of_b = a_.chainage[i] + (b_.chainage.back() - b_.chainage[j]) / ratio.mean;
  const double end_of_a = b_.chainage[j] + (a_.chainage.back() - a_.chainage[i]) * ratio.mean;
  const double margin = 0.5 * mean_joint_;
  const auto last_a = std::upper_bound(a_.chainage.begin() + static_cast<std::ptrdiff_t>(i),
                                       a_.chainage.end(), end_of_b + margin) -
                      a_.chainage.begin() - 1;
  const auto last_b = std::upper_bound(b_.chainage.begin() + static_cast<std::ptrdiff_t>(j),
                                       b_.chainage.end(), end_of_a + margin) -
                      b_.chainage.begin() - 1;
  const auto to = static_cast<std::size_t>(last_b);
  return gap_of_a(static_cast<std::size_t>(last_a) - i) + gap_of_b(to - j) -
         (null_sum_[to] - null_sum_[j]);
}

}  // namespace pipescout::odometry::alignment
