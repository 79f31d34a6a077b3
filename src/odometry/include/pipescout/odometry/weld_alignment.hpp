// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "pipescout/odometry/chainage_map.hpp"

/// Alignment of two weld lists of one pipe: which weld of one is which weld of the other, by the
/// sequence of joint lengths alone. No joint number, no kind of feature and no absolute chainage is
/// used: the lengths of the joints are the fingerprint of a pipe.
///
/// Model (a pair hidden Markov model). Given the welds of A, the steps between welds that both have
/// seen produce the welds of B. A step over the lengths L_A, L_B with m welds of A and n of B
/// passed over has the weight
///   match * gap(m) * gap(n) * f(L_B - s L_A) / prod(null(joint of B))
/// s is the local ratio of the odometers: a Kalman filter of a random walk, kept per path. f is a
/// normal density (uncertainty of the four sightings, of s, and of the odometers over L_A) mixed
/// with a Cauchy density for local slip, cut off at `largest_slip`. null is the density of joint
/// lengths in both lists, so that a weight is a likelihood ratio against two lists that have
/// nothing to do with each other, and that two joints of the usual length agree says little. Welds
/// beyond the overlap cost nothing.
///
/// Search: ungapped agreement along every diagonal proposes where the lists meet; from the best
/// proposals a path is traced; around the best path, in a band of a few joints, the
/// forward-backward recursion gives the posterior probability of each pair. Time about 5 ns * |A| *
/// |B| plus some microseconds per weld; memory O(|A| + |B|) in the longest gap.
///
/// All distances and standard deviations in metres; indices count from 0. Everything here is pure
/// and may be called by any number of threads at once.
namespace pipescout::odometry {

/// One girth weld as a run, a tally or a ledger has it. Its values are not trusted.
struct WeldPosition {
  double chainage = std::numeric_limits<double>::quiet_NaN();  ///< m, by the run's own odometer
  /// m, of the sighting itself, without what the odometer has gathered on the way to it.
  double standard_deviation = std::numeric_limits<double>::quiet_NaN();
};

enum class AlignmentDirection : std::uint8_t {
  kForward,   ///< both lists go the same way
  kReversed,  ///< chainage of one rises where that of the other falls
  kEither,    ///< whichever is more likely; twice the time
};

struct WeldAlignmentParameters {
  AlignmentDirection direction = AlignmentDirection::kForward;

  // What the lists may lack.
  double missed_probability = 0.03;    ///< a weld of A has no partner in B; in (0, 0.5)
  double spurious_probability = 0.03;  ///< welds of B without a partner per weld; in (0, 0.5)
  double outage_probability = 1e-3;    ///< a whole stretch of welds is lacking; in (0, 0.5)
  double outage_welds = 10.0;          ///< mean length of such a stretch, welds; in [1, 1e6]
  std::size_t longest_gap = 32;        ///< welds in a row without a partner; in [1, 1000]

  // What the odometers may do. Ratio: length by B over length by A.
  double scale_sigma = 0.02;       ///< of the ratio, about 1; in (0, 0.2]
  double scale_drift = 0.003;      ///< random walk of the ratio, per sqrt(km); in [0, 0.2]
  double length_noise = 0.01;      ///< m / sqrt(m), random walk of the difference; in [0, 1]
  double slip_probability = 0.05;  ///< that a joint's difference is not normal; in (0, 0.5)
  double slip_scale = 0.2;         ///< m, half width of the Cauchy density; in (0, 10]
  double largest_slip = 8.0;       ///< m, over one step; in (0, 100]

  // Where the lists may meet: |chainage of B - chainage of A - offset| <= tolerance (of -B when
  // reversed). The default knows nothing.
  double offset = 0.0;                                                ///< m, finite
  double offset_tolerance = std::numeric_limits<double>::infinity();  ///< m, above 0

  double accept_probability = 0.9;  ///< least posterior of a match; in [0.5, 1)
  std::size_t proposals = 8;        ///< places that are tried; in [1, 1000]

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct WeldMatch {
  std::size_t a = 0;
  std::size_t b = 0;
  double probability = 0.0;  ///< posterior that the two are one weld
  /// m, how much longer B has the stretch since the previous match than the ratio of the odometers
  /// around it lets expect; 0 for the first.
  double residual = 0.0;
};

/// A weld without a partner, in [0, size).
struct UnmatchedWeld {
  std::size_t index = 0;
  bool within_overlap = false;    ///< the other list passes this place: missed, or spurious
  double best_probability = 0.0;  ///< of its likeliest partner: well above 0, it is ambiguous
};

enum class AlignmentStatus : std::uint8_t {
  kOk = 0,
  kTooFewWelds = 1,  ///< one of the lists has fewer than 3 usable welds
  kNoOverlap = 2,    ///< no place where the lists agree better than by chance: no match is given
};

struct WeldAlignment {
  AlignmentStatus status = AlignmentStatus::kTooFewWelds;
  bool reversed = false;              ///< chainage of B falls where that of A rises
  std::vector<WeldMatch> matches;     ///< `a` rises strictly; `b` rises, or falls when reversed
  std::vector<UnmatchedWeld> only_a;  ///< usable, without a partner; by index
  std::vector<UnmatchedWeld> only_b;
  /// Left out because the value is bad (not finite, standard deviation not positive) or because the
  /// chainage does not rise with the most others.
  std::vector<std::size_t> unusable_a;
  std::vector<std::size_t> unusable_b;
  /// Log likelihood ratio of the place found against unrelated lists, and that of the best other
  /// place (-infinity without one). Their difference is the margin; it enters the probabilities.
  double score = -std::numeric_limits<double>::infinity();
  double other_score = -std::numeric_limits<double>::infinity();
  ChainageMap a_to_b;  ///< of no knots unless status is kOk
};

/// Bad welds are never an error: they are left out and listed.
/// Throws what `WeldAlignmentParameters::validate` throws.
[[nodiscard]] WeldAlignment align_welds(std::span<const WeldPosition> a,
                                        std::span<const WeldPosition> b,
                                        const WeldAlignmentParameters& parameters = {});

/// For people: "ok", "too few welds", "no overlap"; "unknown" for a value that is no enumerator.
[[nodiscard]] const char* to_string(AlignmentStatus status) noexcept;

}  // namespace pipescout::odometry
