// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

/// Position of a crawler: coarse by the joint of the pipe, fine by the fused odometer since the
/// last girth weld (Wang, Cao, Luan and Zhang, Robot 30(3), 2008, section 1, which does not specify
/// the method).
///
/// A pipe is a chain of joints; its tally lists their lengths. Joint j lies between weld j and weld
/// j + 1. Lengths differ by more than the measurement error, so that a sequence of them identifies
/// the position. Several hypotheses (last weld, orientation) are tracked, each with a Kalman filter
/// over (distance from that weld, odometer scale), until one explains the welds best. A detection
/// is an expected weld, a weld after a gross odometer fault or an error of the tally, or spurious;
/// undetected welds on new ground are missed.
///
/// Metres throughout; indices count from 0. Deterministic: the same events give the same bits.
/// Objects share nothing; one object must not be called from two threads at once.
namespace pipescout::odometry {

/// One joint of the tally.
struct TallyJoint {
  double length = std::numeric_limits<double>::quiet_NaN();  ///< m, > 0
  double standard_deviation = 0.01;                          ///< m, >= 0, of that length
};

/// A bend of the pipe, a landmark between welds.
struct TallyBend {
  std::size_t joint = 0;  ///< of the tally, that its middle is in
  double distance =
      std::numeric_limits<double>::quiet_NaN();             ///< m, of its middle from the low end
  double standard_deviation = 0.1;                          ///< m, > 0, of that distance
  double angle = std::numeric_limits<double>::quiet_NaN();  ///< rad, (0, pi]
  double angle_standard_deviation = 0.05;                   ///< rad, > 0
};

/// Orientation of the crawler: whether chainage increases or decreases with the odometer distance.
enum class Orientation : std::uint8_t {
  kForward = 0,
  kBackward = 1,
  kUnknown = 2,  ///< only as initial value: both are tried
};

/// Initial position of the crawler. Reversing over the same ground adds no evidence about
/// undetected welds: a detector need not report a weld again.
struct WeldPositioningStart {
  bool joint_known = false;  ///< false: anywhere in the pipe, with equal probability
  std::size_t joint = 0;     ///< used when known; [0, joints)
  double distance = 0.0;     ///< m, into that joint; finite
  double distance_standard_deviation = 0.05;        ///< m, > 0
  Orientation orientation = Orientation::kForward;  ///< kUnknown needs an unknown joint
};

struct WeldPositioningParameters {
  // The welds.
  double missed_probability = 0.02;    ///< of one weld; (0, 0.5]
  double spurious_probability = 0.01;  ///< spurious detections per joint; (0, 0.5]
  // The bends.
  double missed_bend_probability = 0.02;  ///< of one bend; (0, 0.5]
  double spurious_bend_probability =
      0.005;  ///< bends found where there is none, per joint; (0, 0.5]
  // The odometer.
  double initial_scale = 1.0;                      ///< true metres per odometer metre; (0.5, 2)
  double initial_scale_standard_deviation = 0.02;  ///< (0, 0.2]
  /// Random walk of the scale, wear: variance per metre; [0, 1e-4]. 4e-9 is 0.6 % in 10 km.
  double scale_drift = 4e-9;
  /// Gross faults per joint that the fusion does not detect (two of three wheels slip together);
  /// (0, 0.5].
  double double_slip_probability = 1e-3;
  double largest_double_slip = 0.35;  ///< as a share of the distance since the last weld; (0, 1]
  /// Per joint with a bend, that the fused distance is off by more than its variance says; [0,
  /// 0.4]. Three wheels leave no residual in a bend, so that a slip over most of it is not told: in
  /// simulated runs some joints in a hundred, by 0.34 m at most. 0: none, as of five wheels.
  double bend_fault_probability = 0.02;
  double largest_bend_fault = 0.4;  ///< m, > 0: and by how much, evenly distributed
  /// m, > 0. Longer increments are refused, and so are standard deviations above.
  double largest_increment = 50.0;
  double bad_increment_standard_deviation = 0.05;  ///< m, added for a refused one; >= 0
  /// Gain of the estimated factor on the stated odometer variance; [0, 0.2]; 0: the stated variance
  /// is used unchanged.
  double noise_adaptation = 0.02;
  // The pipe.
  double tally_error_probability = 2e-5;  ///< a wrong length, a joint missing or extra; (0, 0.5]
  double first_weld_chainage = 0.0;       ///< m, of weld 0; finite
  /// Used without a tally: prior length of a joint, its standard deviation, and the largest number
  /// of joints.
  TallyJoint standard_joint{.length = 12.0, .standard_deviation = 0.12};
  std::size_t largest_joint_count = 4096;  ///< [1, 1000000]
  // The hypotheses.
  /// [8, 1000000]; never fewer than two per weld of the tally, so that the search is complete.
  std::size_t largest_hypothesis_count = 4096;
  double prune_ratio =
      1e-8;           ///< relative to the largest weight; hypotheses below are removed; (0, 0.01]
  double gate = 5.0;  ///< standard deviations: gate of an expected weld; [3, 10]
  // The lock.
  double lock_probability = 0.9999;      ///< (0.5, 1)
  double unlock_probability = 0.99;      ///< (0, lock_probability]
  std::size_t lock_welds = 1;            ///< detections in a row that must exceed it; >= 1
  double lock_standard_deviation = 1.0;  ///< m, largest one of the distance into the joint; > 0

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Increment of the fused odometer since the last event. Negative: reversing.
struct OdometerIncrement {
  double distance = std::numeric_limits<double>::quiet_NaN();  ///< m
  double variance = std::numeric_limits<double>::quiet_NaN();  ///< m^2, >= 0, independent of others
};

/// A girth weld reported by the detector.
struct WeldSighting {
  /// m, the sum of the increments at the passage of the weld: now, or a little earlier.
  double odometer_distance = std::numeric_limits<double>::quiet_NaN();
  double standard_deviation = std::numeric_limits<double>::quiet_NaN();  ///< m, > 0
  /// Probability that it is a weld, [0, 1]; NaN: unknown. A low value makes a spurious detection
  /// more likely than `spurious_probability`, a high one never less likely.
  double confidence = std::numeric_limits<double>::quiet_NaN();
};

/// A bend found by the wheels, such as `FoundBend` of OdometerStream.
struct BendSighting {
  /// m, the sum of the increments at the middle of the bend. It may lie before the last welds.
  double odometer_distance = std::numeric_limits<double>::quiet_NaN();
  double standard_deviation = std::numeric_limits<double>::quiet_NaN();        ///< m, > 0
  double angle = std::numeric_limits<double>::quiet_NaN();                     ///< rad, (0, pi]
  double angle_standard_deviation = std::numeric_limits<double>::quiet_NaN();  ///< rad, > 0
};

/// Outcome of an event. Only kAccepted changes the position.
enum class PositioningStatus : std::uint8_t {
  kAccepted = 0,
  kBadValue = 1,    ///< not finite, a variance below zero, too long an increment, ...
  kOutOfOrder = 2,  ///< a weld at a distance that was not reached since the last one
};

struct WeldPositionEstimate {
  PositioningStatus status = PositioningStatus::kAccepted;
  bool known = false;  ///< false: no weld yet after an unknown start; the next seven are invalid
  /// The probability was high for enough welds, the variance is small, and no fault of the odometer
  /// in a bend since the last weld can have taken it into another joint (by more than 1 in 1000).
  bool locked = false;
  std::size_t joint = 0;
  Orientation orientation = Orientation::kUnknown;
  /// Probability that the crawler is within half a joint of this position; in [0, 1].
  double probability = 0.0;
  /// Probability that it is in `joint`, in [0, 1]: `probability`, less what the variance and faults
  /// of the odometer that the fusion does not tell put beyond the welds of the joint. About half of
  /// it at a weld.
  double joint_probability = 0.0;
  /// m, from the weld at the low end of the joint, in either orientation. Its variance includes
  /// that of the joint's length in the tally if the last weld was at the other end.
  double distance_into_joint = std::numeric_limits<double>::quiet_NaN();
  /// m, sum of the tally's lengths (its accumulated error is not in the covariance); without a
  /// tally, of the estimated lengths.
  double chainage = std::numeric_limits<double>::quiet_NaN();
  double scale = std::numeric_limits<double>::quiet_NaN();  ///< true metres per odometer metre
  /// Of (distance into the joint, scale). Includes the spread of the hypotheses within half a
  /// joint, so it is large while two of them compete.
  Eigen::Matrix<double, 2, 2, Eigen::DontAlign> covariance =
      Eigen::Matrix<double, 2, 2, Eigen::DontAlign>::Constant(
          std::numeric_limits<double>::quiet_NaN());
  double noise_factor = 1.0;  ///< estimated factor on the stated odometer variance
  std::size_t hypotheses = 0;
  /// The welds reveal a gross error `spacing_error` of the fused odometer in the last joints. Set
  /// once per fault, by the weld that makes it certain. One pass cannot distinguish it from a wrong
  /// length in the tally; a second pass over the joint can (`learnt_joints`).
  bool double_slip_detected = false;
  /// the same with an error too large for a slip: a joint missing or extra
  bool tally_error_detected = false;
  double spacing_error = 0.0;  ///< m, odometer less tally; 0 unless one of the two is set
};

/// Counts since construction.
struct WeldPositioningCounts {
  std::uint64_t increments = 0;
  std::uint64_t bad_increments = 0;
  std::uint64_t welds = 0;
  std::uint64_t bad_welds = 0;
  std::uint64_t out_of_order_welds = 0;
  std::uint64_t unexplained_welds = 0;  ///< consistent with no hypothesis; treated as spurious
  std::uint64_t bends = 0;
  std::uint64_t bad_bends = 0;
  std::uint64_t out_of_order_bends = 0;
  std::uint64_t unexplained_bends = 0;  ///< near no bend of the tally in any hypothesis
  std::uint64_t double_slips = 0;
  std::uint64_t tally_errors = 0;
  std::uint64_t locks_lost = 0;
};

/// A joint as the crawler measured it while locked.
struct LearntJoint {
  double length;              ///< m; that of the tally or the prior if never measured
  double standard_deviation;  ///< m
  std::uint32_t observations = 0;
};

class WeldPositioning {
 public:
  /// An empty tally: joints have the prior `standard_joint` and are estimated; the start must then
  /// be known. All allocation happens here. Throws std::invalid_argument naming field, value and
  /// range: what the parameters' `validate` throws, a joint (`tally[17].length`), the start, or a
  /// bend (`bends[3].angle`); bends need a tally.
  WeldPositioning(WeldPositioningParameters parameters, std::span<const TallyJoint> tally,
                  const WeldPositioningStart& start, std::span<const TallyBend> bends = {});
  ~WeldPositioning();
  WeldPositioning(WeldPositioning&&) noexcept;
  WeldPositioning& operator=(WeldPositioning&&) noexcept;

  /// In the order of time. Never throw, never allocate; invalid values are counted and reported. An
  /// increment takes constant time, a weld time proportional to the hypotheses.
  const WeldPositionEstimate& add_increment(const OdometerIncrement& increment) noexcept;
  const WeldPositionEstimate& add_weld(const WeldSighting& weld) noexcept;
  /// A bend tells bends of the tally apart by place and angle, and where the crawler is: by
  /// probabilistic data association (Bar-Shalom and Tse, Automatica 11, 1975) within each
  /// hypothesis, with a bend that is none and with an odometer fault since the last weld.
  const WeldPositionEstimate& add_bend(const BendSighting& bend) noexcept;

  /// The position after the last event.
  [[nodiscard]] const WeldPositionEstimate& estimate() const noexcept;
  [[nodiscard]] const WeldPositioningCounts& counts() const noexcept;
  /// m, the sum of all valid increments: the reference of `WeldSighting::odometer_distance`.
  [[nodiscard]] double odometer_distance() const noexcept;
  /// One per joint of the tally, or `largest_joint_count`.
  [[nodiscard]] std::span<const LearntJoint> learnt_joints() const noexcept;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// For messages: "accepted", "bad value", "out of order"; "unknown" for any other value.
[[nodiscard]] const char* to_string(PositioningStatus status) noexcept;
/// "forward", "backward", "unknown".
[[nodiscard]] const char* to_string(Orientation orientation) noexcept;

}  // namespace pipescout::odometry
