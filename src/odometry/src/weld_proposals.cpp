// SPDX-License-Identifier: Apache-2.0
#include "weld_proposals.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <tuple>

namespace pipescout::odometry::alignment {
namespace {

// The ratio of the odometers is followed along each diagonal by a first-order filter; what does not
// agree moves it little, so that it survives a missed weld.
constexpr float kRatioGain = 0.15F;
constexpr float kLargestRatioStep = 0.01F;
constexpr double kRatioLag = 0.002;      // standard deviation of what that filter lacks
constexpr float kLargestPenalty = 9.0F;  // of one joint: a slip, as likely as f's tail has it

/// All diagonals, d = j - i + rows - 1 for the joints i of A and j of B: what the current row works
/// on keeps its place while the rows go by. Arrays rather than records, for the vector unit.
struct Diagonals {
  Diagonals(std::size_t count, float first_ratio)
      : score(count, 0.0F),
        ratio(count, first_ratio),
        begin(count, 0),
        best_score(count, 0.0F),
        best_begin(count, 0),
        best_end(count, 0) {}

  std::vector<float> score;         // of the stretch that ends at the row before
  std::vector<float> ratio;         // of the odometers
  std::vector<std::int32_t> begin;  // first joint of A in that stretch
  std::vector<float> best_score;
  std::vector<std::int32_t> best_begin;
  std::vector<std::int32_t> best_end;
};

/// What is the same for all joints of B in one row.
struct Row {
  float length;
  float precision;  // 1 / (2 variance)
  float log_peak;
  float move;  // gain of the ratio, per metre
  float lowest_ratio;
  float highest_ratio;
  std::int32_t joint;
};

/// One step along the diagonals from `d` on, `count` of them.
void advance(Diagonals& diagonals, std::size_t d, std::size_t count, const Row& row,
             const float* joint_b, const float* null_b) {
  float* __restrict const scores = diagonals.score.data() + d;
  float* __restrict const ratios = diagonals.ratio.data() + d;
  std::int32_t* __restrict const begins = diagonals.begin.data() + d;
  float* __restrict const best_scores = diagonals.best_score.data() + d;
  std::int32_t* __restrict const best_begins = diagonals.best_begin.data() + d;
  std::int32_t* __restrict const best_ends = diagonals.best_end.data() + d;
  for (std::size_t k = 0; k < count; ++k) {
    const float residual = joint_b[k] - ratios[k] * row.length;
    const float misfit = residual * residual * row.precision;
    const float penalty = misfit < kLargestPenalty ? misfit : kLargestPenalty;
    float move = residual * row.move;
    move = move < kLargestRatioStep ? move : kLargestRatioStep;
    move = move > -kLargestRatioStep ? move : -kLargestRatioStep;
    float ratio = ratios[k] + move;
    ratio = ratio < row.highest_ratio ? ratio : row.highest_ratio;
    ratios[k] = ratio > row.lowest_ratio ? ratio : row.lowest_ratio;
    const float before = scores[k];
    const float score = before + row.log_peak - penalty - null_b[k];
    const std::int32_t begin_before = begins[k];
    // No stretch ends at the row before: one may begin here.
    begins[k] = before > 0.0F ? begin_before : row.joint;
    scores[k] = score > 0.0F ? score : 0.0F;
  }
  // A loop of its own, or the compiler threads the two conditions and finds no vectors.
  for (std::size_t k = 0; k < count; ++k) {
    const float score = scores[k];
    const std::int32_t begin = begins[k];
    const float best_score = best_scores[k];
    const std::int32_t best_begin = best_begins[k];
    const std::int32_t best_end = best_ends[k];
    const bool better = score > best_score;
    best_scores[k] = better ? score : best_score;
    best_begins[k] = better ? begin : best_begin;
    best_ends[k] = better ? row.joint : best_end;
  }
}

}  // namespace

std::vector<Proposal> propose(const AlignmentModel& model, std::size_t count) {
  const WeldSequence& a = model.a();
  const WeldSequence& b = model.b();
  const std::size_t rows = a.size() - 1;
  const std::size_t columns = b.size() - 1;
  std::vector<float> joint_b(columns);
  std::vector<float> null_b(columns);
  for (std::size_t j = 0; j < columns; ++j) {
    joint_b[j] = static_cast<float>(b.joint(j));
    null_b[j] = static_cast<float>(model.log_null(b.joint(j)));
  }
  const WeldAlignmentParameters& parameters = model.parameters();
  const auto lowest_ratio = static_cast<float>(1.0 - 3.0 * parameters.scale_sigma);
  const auto highest_ratio = static_cast<float>(1.0 + 3.0 * parameters.scale_sigma);
  const auto first_ratio = static_cast<float>(model.first_ratio().mean);

  Diagonals diagonals(rows + columns - 1, first_ratio);
  for (std::size_t i = 0; i < rows; ++i) {
    const double length = a.joint(i);
    const double lag = kRatioLag * length;
    const double variance = model.difference_variance(i, i + 1, 0, 1) + lag * lag;
    const Row row{
        .length = static_cast<float>(length),
        .precision = static_cast<float>(0.5 / variance),
        .log_peak = static_cast<float>(-0.5 * std::log(2.0 * std::numbers::pi * variance)),
        .move = kRatioGain / static_cast<float>(length),
        .lowest_ratio = lowest_ratio,
        .highest_ratio = highest_ratio,
        .joint = static_cast<std::int32_t>(i)};
    std::size_t from = 0;
    std::size_t to = columns;
    if (std::isfinite(parameters.offset_tolerance)) {
      const double centre = a.chainage[i] + parameters.offset;
      const auto first = b.chainage.begin();
      from = static_cast<std::size_t>(std::lower_bound(first,
                                                       first + static_cast<std::ptrdiff_t>(columns),
                                                       centre - parameters.offset_tolerance) -
                                      first);
      to = static_cast<std::size_t>(std::upper_bound(first,
                                                     first + static_cast<std::ptrdiff_t>(columns),
                                                     centre + parameters.offset_tolerance) -
                                    first);
    }
    if (from < to) {
      advance(diagonals, rows - 1 - i + from, to - from, row, joint_b.data() + from,
              null_b.data() + from);
    }
  }

  std::vector<Proposal> proposals;
  for (std::size_t d = 0; d < rows + columns - 1; ++d) {
    if (diagonals.best_score[d] > 0.0F) {
      const auto middle =
          static_cast<std::size_t>((diagonals.best_begin[d] + diagonals.best_end[d] + 1) / 2);
      proposals.push_back(
          {.score = diagonals.best_score[d], .a = middle, .b = middle + d + 1 - rows});
    }
  }
  const auto better = [](const Proposal& one, const Proposal& other) {
    return std::tie(other.score, one.a, one.b) < std::tie(one.score, other.a, other.b);
  };
  const auto kept = std::min(count, proposals.size());
  std::partial_sort(proposals.begin(), proposals.begin() + static_cast<std::ptrdiff_t>(kept),
                    proposals.end(), better);
  proposals.resize(kept);
  return proposals;
}

}  // namespace pipescout::odometry::alignment
