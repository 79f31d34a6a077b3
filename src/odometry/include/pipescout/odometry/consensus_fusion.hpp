// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

/// Consensus fusion of redundant odometers: Wang, Cao, Luan and Zhang, "Precision Location
/// Technology of Pipeline Robot Based on Multi-Sensor Data Fusion", Robot 30(3), 2008. Equation
/// numbers below are those of that paper.
///
/// The odometers of one robot measure the same travelled distance at the same time. Those that the
/// majority does not support (a slipping or blocked wheel) are rejected; the others are fused. All
/// distances and standard deviations are in metres; all indices count from 0.
///
/// Every function here is pure: the same input gives the same bits, no state is kept between calls,
/// and any number of threads may call concurrently. None allocates memory unless it throws.
namespace pipescout::odometry {

inline constexpr std::size_t kMinOdometers = 2;
inline constexpr std::size_t kMaxOdometers = 16;

/// The reading of one odometer. Its values are validated: see `RejectionReason`.
struct OdometerReading {
  double distance = std::numeric_limits<double>::quiet_NaN();            ///< m, raw: before offsets
  double standard_deviation = std::numeric_limits<double>::quiet_NaN();  ///< m, the paper's sigma_i
  bool valid = true;  ///< false: marked as invalid by the driver
};

/// Some of the odometers: bit i is odometer i.
using OdometerSet = std::bitset<kMaxOdometers>;

/// m x m, row-major, D of equation (5). Unaligned and of bounded size, so that it is on the stack
/// and has the same layout in code compiled for other vector instructions.
using ConfidenceDistanceMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor | Eigen::DontAlign,
                  static_cast<int>(kMaxOdometers), static_cast<int>(kMaxOdometers)>;

/// m x m, row-major, entries 0 and 1, R of equation (7): the adjacency matrix of the support graph,
/// r_ij = 1 for an edge from i to j, "i supports j".
using RelationMatrix =
    Eigen::Matrix<std::uint8_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor | Eigen::DontAlign,
                  static_cast<int>(kMaxOdometers), static_cast<int>(kMaxOdometers)>;

/// Weight w_i of a member of the fusion set in  sum(w_i x_i) / sum(w_i).
enum class Weighting : std::uint8_t {
  kMaximumLikelihood,  ///< 1 / sigma_i^2: result of equations (8) to (12)
  kPaperEquation13,    ///< 1 / sigma_i: equation (13) as printed
};

/// What "supported by a group of sensors" (section 2 of the paper) means. An odometer is in the
/// fusion set when more than half of the usable odometers, itself counted, and at least one other
/// support it. No rule depends on the order of the odometers, and no ties occur. Reasons and
/// figures: docs/decisions/majority-support-rule.md.
enum class SupportRule : std::uint8_t {
  kMajority,        ///< i counts for j when i supports j, weakly (r_ij = 1, r_ji = 0) or strongly
  kMutualMajority,  ///< i counts for j only when they support each other. Stricter: a precise
                    ///< odometer among coarse ones needs precise agreement. The same as kMajority
                    ///< when all standard deviations are equal
};

struct ConsensusFusionParameters {
  /// Largest confidence distance at which i still supports j, equation (6); in (0, 1). The paper's
  /// 0.75 lets readings of equal sigma differ by 1.15 sigma.
  double epsilon = 0.75;
  Weighting weighting = Weighting::kMaximumLikelihood;
  SupportRule support_rule = SupportRule::kMajority;
  /// m, finite, one per odometer or none (all zero). Added to the fused readings to compensate
  /// known errors (section 4: 0.18, 0.155, 0.165). As in the paper, support is computed from the
  /// readings WITHOUT offsets: offsets that differ by a sigma or more must be applied to the
  /// readings instead, or they appear as disagreement.
  std::vector<double> offsets{};

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// The reason why an odometer is not in the fusion set. The first that applies, in the order
/// kMarkedInvalid, kNotANumber, kBadSigma, kUnsupported. A reading with one of the first three is
/// not usable: it is not fused and does not influence the other odometers.
enum class RejectionReason : std::uint8_t {
  kNone = 0,           ///< it is in the fusion set
  kUnsupported = 1,    ///< no group supports it
  kMarkedInvalid = 2,  ///< `OdometerReading::valid` is false
  kNotANumber = 3,     ///< its distance is NaN or infinite, or becomes so with its offset
  kBadSigma = 4,       ///< its standard deviation is not a positive finite number
};

enum class FusionStatus : std::uint8_t {
  kOk = 0,
  kNoConsensus = 1,  ///< no odometer is supported by a group; there is no fused distance
};

/// A distance and its uncertainty, m. NaN when not available.
struct FusedDistance {
  double distance = std::numeric_limits<double>::quiet_NaN();
  double standard_deviation = std::numeric_limits<double>::quiet_NaN();
};

struct ConsensusFusionResult {
  FusionStatus status = FusionStatus::kNoConsensus;
  FusedDistance fused;     ///< both NaN when status is kNoConsensus
  OdometerSet fusion_set;  ///< empty when status is kNoConsensus
  /// Entry i is that of odometer i; entries from m on are kNone.
  std::array<RejectionReason, kMaxOdometers> rejections{};
  ConfidenceDistanceMatrix confidence_distance;  ///< as of `confidence_distance_matrix`
  RelationMatrix relation;                       ///< as of `relation_matrix`
};

/// d_ij of equations (1) to (4): the probability that a normal variable of mean x_i and standard
/// deviation sigma_i lies within |x_i - x_j| of its mean, erf(|x_i - x_j| / (sqrt(2) sigma_i)).
/// In [0, 1]; 0 when the readings are equal. Not symmetric: d_ji uses sigma_j.
/// Not checked: x_i, x_j finite and sigma_i > 0; NaN in, NaN out.
[[nodiscard]] double confidence_distance(double x_i, double x_j, double sigma_i) noexcept;

/// D of equation (5), m x m, entries in [0, 1], zero diagonal. An unusable reading (see
/// `RejectionReason`, without offsets) has the distance 1 from every reading, itself included: row,
/// column and diagonal entry are 1. Throws std::invalid_argument when there are not 2 to 16
/// readings.
[[nodiscard]] ConfidenceDistanceMatrix confidence_distance_matrix(
    std::span<const OdometerReading> readings);

/// R of equations (6) and (7): r_ij = 1 when d_ij <= epsilon, else 0 (for NaN too).
/// Throws std::invalid_argument when D is not square with 2 to 16 rows, or epsilon not in (0, 1).
[[nodiscard]] RelationMatrix relation_matrix(const ConfidenceDistanceMatrix& confidence_distance,
                                             double epsilon);

/// The odometers that a group supports; empty when there is no such group. An odometer that does
/// not support itself (r_ii = 0) is not usable: it is neither counted nor selected. Throws
/// std::invalid_argument when R is not square with 2 to 16 rows, or `rule` is not an enumerator.
[[nodiscard]] OdometerSet fusion_set(const RelationMatrix& relation, SupportRule rule);

/// Weighted mean of the members, offsets added, equation (13) or its 1 / sigma^2 form, and the
/// standard deviation sqrt(sum(w_i^2 sigma_i^2)) / sum(w_i) for independent errors of the members
/// and correct sigmas. (The selection of the members is not taken into account.) The distance lies
/// between the smallest and the largest member. Throws std::invalid_argument when there are not 2
/// to 16 readings, `offsets` is neither empty nor of their number, `members` is empty, exceeds the
/// readings or contains an unusable one, or `weighting` is not an enumerator.
[[nodiscard]] FusedDistance fuse_members(std::span<const OdometerReading> readings,
                                         std::span<const double> offsets,
                                         const OdometerSet& members, Weighting weighting);

/// The complete method: D, R, fusion set, fused distance.
class ConsensusFusion {
 public:
  /// Throws what `ConsensusFusionParameters::validate` throws.
  explicit ConsensusFusion(ConsensusFusionParameters parameters);

  /// `readings`: one per odometer, always in the same order (that of the offsets), all taken at the
  /// same time. Invalid values are not an error: they are excluded, with the reason in the result.
  /// Throws std::invalid_argument when there are not 2 to 16 readings, or not as many as offsets.
  [[nodiscard]] ConsensusFusionResult fuse(std::span<const OdometerReading> readings) const;

  [[nodiscard]] const ConsensusFusionParameters& parameters() const noexcept { return parameters_; }

 private:
  ConsensusFusionParameters parameters_;
};

/// For messages: "unsupported", "not a number", ... "unknown" for any other value.
[[nodiscard]] const char* to_string(RejectionReason reason) noexcept;
[[nodiscard]] const char* to_string(FusionStatus status) noexcept;

}  // namespace pipescout::odometry
