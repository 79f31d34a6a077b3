// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "pipescout/odometry/chainage_map.hpp"

/// Alignment of two weld lists of one pipe: data association of their welds by the sequence of
/// joint lengths alone. Joint numbers, kinds of features and absolute chainages are not used.
///
/// Model (a pair hidden Markov model). Given the welds of A, the steps between common welds produce
/// the welds of B. A step over the lengths L_A, L_B that skips m welds of A and n of B has the
/// weight
///   match * gap(m) * gap(n) * f(L_B - s L_A) / prod(null(joint of B))
/// s is the local ratio of the odometers: a Kalman filter of a random walk, kept per path. f is a
/// normal density (uncertainty of the four sightings, of s, and of the odometers over L_A) mixed
/// with a Cauchy density for local slip, cut off at `largest_slip`. null is the density of joint
/// lengths in both lists, so that a weight is a likelihood ratio relative to unrelated lists, and
/// two joints of a common length carry little information. Welds beyond the overlap have no cost.
///
/// Search: ungapped agreement along every diagonal proposes alignments; a path is traced from the
/// best proposals; in a band of a few joints around the best path, the forward-backward recursion
/// gives the posterior probability of each pair. Time about 5 ns * |A| *
/// |B| plus some microseconds per weld; memory O(|A| + |B|) in the longest gap.
///
/// All distances and standard deviations in metres; indices count from 0. Everything here is pure
/// and may be called by any number of threads at once.
namespace pipescout::odometry {

/// One girth weld of a run, a tally or a ledger. Its values are validated.
struct WeldPosition {
  double chainage = std::numeric_limits<double>::quiet_NaN();  ///< m, by the run's own odometer
  /// m, of the detection itself, without the accumulated error of the odometer.
  double standard_deviation = std::numeric_limits<double>::quiet_NaN();
};

enum class AlignmentDirection : std::uint8_t {
  kForward,   ///< both lists have the same direction
  kReversed,  ///< the lists have opposite directions
  kEither,    ///< the more likely direction; twice the computing time
};

struct WeldAlignmentParameters {
  AlignmentDirection direction = AlignmentDirection::kForward;

  // Model of missing and spurious welds.
  double missed_probability = 0.03;    ///< a weld of A has no partner in B; in (0, 0.5)
  double spurious_probability = 0.03;  ///< welds of B without a partner per weld; in (0, 0.5)
  double outage_probability = 1e-3;    ///< a whole section of welds is missing; in (0, 0.5)
  double outage_welds = 10.0;          ///< mean length of such a section, welds; in [1, 1e6]
  std::size_t longest_gap = 32;        ///< welds in a row without a partner; in [1, 1000]

  // Error model of the odometers. Ratio: length by B divided by length by A.
  double scale_sigma = 0.02;   ///< of the ratio, about 1; in (0, 0.2]
  double scale_drift = 0.003;  ///< random walk of the ratio, per sqrt(km); in [0, 0.2]
  double length_noise = 0.01;  ///< m / sqrt(m), random walk of the difference; in [0, 1]
  double slip_probability =
      0.05;                   ///< probability that a joint's difference is not normal; in (0, 0.5)
  double slip_scale = 0.2;    ///< m, half width of the Cauchy density; in (0, 10]
  double largest_slip = 8.0;  ///< m, over one step; in (0, 100]

  // Prior of the alignment: |chainage of B - chainage of A - offset| <= tolerance (of -B when
  // reversed). No restriction by default.
  double offset = 0.0;                                                ///< m, finite
  double offset_tolerance = std::numeric_limits<double>::infinity();  ///< m, above 0

  double accept_probability = 0.9;  ///< smallest posterior of a match; in [0.5, 1)
  std::size_t proposals = 8;        ///< number of tried alignments; in [1, 1000]

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct WeldMatch {
  std::size_t a = 0;
  std::size_t b = 0;
  double probability = 0.0;  ///< posterior that the two are one weld
  /// m, excess length in B of the section since the previous match over that expected from the
  /// local ratio of the odometers; 0 for the first.
  double residual = 0.0;
};

/// An unmatched weld, in [0, size).
struct UnmatchedWeld {
  std::size_t index = 0;
  bool within_overlap = false;  ///< the other list covers this position: missed, or spurious
  /// of its most likely partner; if well above 0, the weld is ambiguous
  double best_probability = 0.0;
};

enum class AlignmentStatus : std::uint8_t {
  kOk = 0,
  kTooFewWelds = 1,  ///< one of the lists has fewer than 3 usable welds
  kNoOverlap = 2,    ///< the lists agree nowhere better than by chance: no matches
};

struct WeldAlignment {
  AlignmentStatus status = AlignmentStatus::kTooFewWelds;
  bool reversed = false;  ///< chainage of B decreases where that of A increases
  std::vector<WeldMatch>
      matches;  ///< `a` increases strictly; `b` increases, or decreases when reversed
  std::vector<UnmatchedWeld> only_a;  ///< usable, unmatched; by index
  std::vector<UnmatchedWeld> only_b;
  /// Excluded because a value is invalid (not finite, standard deviation not positive) or because
  /// the chainage is not in increasing order with most others.
  std::vector<std::size_t> unusable_a;
  std::vector<std::size_t> unusable_b;
  /// Log likelihood ratio of the alignment relative to unrelated lists, and that of the second-best
  /// alignment (-infinity without one). Their difference is the margin; it enters the
  /// probabilities.
  double score = -std::numeric_limits<double>::infinity();
  double other_score = -std::numeric_limits<double>::infinity();
  ChainageMap a_to_b;  ///< of no knots unless status is kOk
};

/// Invalid welds are not an error: they are excluded and listed. Throws what
/// `WeldAlignmentParameters::validate` throws.
[[nodiscard]] WeldAlignment align_welds(std::span<const WeldPosition> a,
                                        std::span<const WeldPosition> b,
                                        const WeldAlignmentParameters& parameters = {});

/// For messages: "ok", "too few welds", "no overlap"; "unknown" for any other value.
[[nodiscard]] const char* to_string(AlignmentStatus status) noexcept;

}  // namespace pipescout::odometry
