// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

/// Where the crawler is: coarse, which joint of the pipe; fine, the fused odometer since the last
/// girth weld (Wang, Cao, Luan and Zhang, Robot 30(3), 2008, section 1, which leaves the method
/// open).
///
/// A pipe is a chain of joints; its tally lists their lengths. Joint j lies between weld j and weld
/// j + 1. Lengths differ by more than they are measured wrong, so that a sequence of them is a
/// fingerprint: several hypotheses (weld reached last, orientation) are kept, each with a Kalman
/// filter over (distance from that weld, odometer scale), until one explains the welds best. A
/// detection is a weld as expected, a weld after a gross odometer fault or an error of the tally,
/// or spurious; welds that should have been seen on new ground count as missed.
///
/// Metres throughout; indices count from 0. Deterministic: the same events give the same bits.
/// Objects share nothing; one object must not be called from two threads at once.
namespace pipescout::odometry {

/// One joint as the tally has it.
struct TallyJoint {
  double length = std::numeric_limits<double>::quiet_NaN();  ///< m, > 0
  double standard_deviation = 0.01;                          ///< m, >= 0, of that length
};

/// How the crawler faces: whether chainage grows or falls when the odometer distance grows.
enum class Orientation : std::uint8_t {
  kForward = 0,
  kBackward = 1,
  kUnknown = 2,  ///< only as a start: both are tried
};

/// Where the crawler starts. Ground that it covers again, reversing, is no evidence for or against
/// a weld that was not seen there: a detector may keep quiet about a weld it has reported already.
struct WeldPositioningStart {
  bool joint_known = false;                   ///< false: anywhere in the pipe, all welds alike
  std::size_t joint = 0;                      ///< read when known; [0, joints)
  double distance = 0.0;                      ///< m, into that joint; finite
  double distance_standard_deviation = 0.05;  ///< m, > 0
  Orientation orientation = Orientation::kForward;  ///< kUnknown needs an unknown joint
};

struct WeldPositioningParameters {
  // The welds.
  double missed_probability = 0.02;    ///< of one weld; (0, 0.5]
  double spurious_probability = 0.01;  ///< spurious detections per joint; (0, 0.5]
  // The odometer.
  double initial_scale = 1.0;                      ///< true metres per odometer metre; (0.5, 2)
  double initial_scale_standard_deviation = 0.02;  ///< (0, 0.2]
  /// Random walk of the scale, wear: variance per metre; [0, 1e-4]. 4e-9 is 0.6 % in 10 km.
  double scale_drift = 4e-9;
  /// Gross faults per joint that survive the fusion (two of three wheels slip together); (0, 0.5].
  double double_slip_probability = 1e-3;
  double largest_double_slip = 0.35;  ///< as a part of the distance since the last weld; (0, 1]
  /// m, > 0. Longer increments are refused, and so are standard deviations above.
  double largest_increment = 50.0;
  double bad_increment_standard_deviation = 0.05;  ///< m, what a refused one may hide; >= 0
  /// Gain of the factor on the stated odometer variance that is learnt from the welds; [0, 0.2];
  /// 0: the stated variance is taken as it is.
  double noise_adaptation = 0.02;
  // The pipe.
  double tally_error_probability = 2e-5;  ///< a wrong length, a joint missing or extra; (0, 0.5]
  double first_weld_chainage = 0.0;       ///< m, of weld 0; finite
  /// Used without a tally: what a joint is expected to be, its spread, and how many there may be.
  TallyJoint standard_joint{.length = 12.0, .standard_deviation = 0.12};
  std::size_t largest_joint_count = 4096;  ///< [1, 1000000]
  // The hypotheses.
  /// [8, 1000000]; never fewer than two per weld of the tally, so that a search misses no place.
  std::size_t largest_hypothesis_count = 4096;
  double prune_ratio = 1e-8;  ///< to the heaviest; lighter ones go; (0, 0.01]
  double gate = 5.0;          ///< standard deviations within which a weld is as expected; [3, 10]
  // The lock.
  double lock_probability = 0.9999;      ///< (0.5, 1)
  double unlock_probability = 0.99;      ///< (0, lock_probability]
  std::size_t lock_welds = 1;            ///< sightings in a row that must find it so; >= 1
  double lock_standard_deviation = 1.0;  ///< m, of the distance into the joint at most; > 0

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// What the fused odometer went since the last event. Negative: it reversed.
struct OdometerIncrement {
  double distance = std::numeric_limits<double>::quiet_NaN();  ///< m
  double variance = std::numeric_limits<double>::quiet_NaN();  ///< m^2, >= 0, independent of others
};

/// A girth weld, as the detector reports it.
struct WeldSighting {
  /// m, the sum of the increments at which the weld passed: now, or a little earlier.
  double odometer_distance = std::numeric_limits<double>::quiet_NaN();
  double standard_deviation = std::numeric_limits<double>::quiet_NaN();  ///< m, > 0
  /// That it is a weld, [0, 1]; NaN: not known. A low one makes a spurious detection more likely
  /// than `spurious_probability` says, a high one never less.
  double confidence = std::numeric_limits<double>::quiet_NaN();
};

/// What became of an event. Only kAccepted changes where the crawler is thought to be.
enum class PositioningStatus : std::uint8_t {
  kAccepted = 0,
  kBadValue = 1,    ///< not finite, a variance below zero, too long an increment, ...
  kOutOfOrder = 2,  ///< a weld where the crawler has not been since the last one
};

struct WeldPositionEstimate {
  PositioningStatus status = PositioningStatus::kAccepted;
  bool known = false;   ///< false: no weld seen yet from an unknown start; the next six are void
  bool locked = false;  ///< the probability was high for long enough and the variance is small
  std::size_t joint = 0;
  Orientation orientation = Orientation::kUnknown;
  /// That the crawler is less than half a joint from the place stated; in [0, 1].
  double probability = 0.0;
  /// m, from the weld at the low end of the joint, whichever way the crawler faces. Its variance
  /// allows for the length of the joint in the tally where the last weld was not that one.
  double distance_into_joint = std::numeric_limits<double>::quiet_NaN();
  /// m, as the tally adds up (its sum of errors is not in the covariance); without a tally, as the
  /// learnt lengths do.
  double chainage = std::numeric_limits<double>::quiet_NaN();
  double scale = std::numeric_limits<double>::quiet_NaN();  ///< true metres per odometer metre
  /// Of (distance into the joint, scale). Holds the spread of the hypotheses within half a joint,
  /// so it is wide while two of them compete.
  Eigen::Matrix<double, 2, 2, Eigen::DontAlign> covariance =
      Eigen::Matrix<double, 2, 2, Eigen::DontAlign>::Constant(
          std::numeric_limits<double>::quiet_NaN());
  double noise_factor = 1.0;  ///< learnt factor on the stated odometer variance
  std::size_t hypotheses = 0;
  /// The welds so far show that the fused odometer was wrong by `spacing_error` somewhere in the
  /// last joints. Set once per fault, by the weld that makes it certain. One pass cannot tell
  /// this from a wrong length in the tally; a second pass over the joint can (`learnt_joints`).
  bool double_slip_detected = false;
  bool tally_error_detected =
      false;                   ///< likewise, too far off for a slip: a joint missing or extra
  double spacing_error = 0.0;  ///< m, odometer less tally; 0 unless one of the two is set
};

/// Counts since construction.
struct WeldPositioningCounts {
  std::uint64_t increments = 0;
  std::uint64_t bad_increments = 0;
  std::uint64_t welds = 0;
  std::uint64_t bad_welds = 0;
  std::uint64_t out_of_order_welds = 0;
  std::uint64_t unexplained_welds = 0;  ///< no hypothesis had room for them; taken as spurious
  std::uint64_t double_slips = 0;
  std::uint64_t tally_errors = 0;
  std::uint64_t locks_lost = 0;
};

/// A joint as the crawler measured it while locked.
struct LearntJoint {
  double length;              ///< m; what the tally or the standard says as long as never measured
  double standard_deviation;  ///< m
  std::uint32_t observations = 0;
};

class WeldPositioning {
 public:
  /// An empty tally: joints are as `standard_joint` and are learnt; the start must then be known.
  /// Allocates all it will ever use.
  /// Throws std::invalid_argument naming field, value and range: what the parameters' `validate`
  /// throws, a joint (`tally[17].length`) or the start.
  WeldPositioning(WeldPositioningParameters parameters, std::span<const TallyJoint> tally,
                  const WeldPositioningStart& start);
  ~WeldPositioning();
  WeldPositioning(WeldPositioning&&) noexcept;
  WeldPositioning& operator=(WeldPositioning&&) noexcept;

  /// In the order of time. Never throw, never allocate; bad values are counted and reported.
  /// An increment takes constant time, a weld time proportional to the hypotheses.
  const WeldPositionEstimate& add_increment(const OdometerIncrement& increment) noexcept;
  const WeldPositionEstimate& add_weld(const WeldSighting& weld) noexcept;

  /// As the last event left it.
  [[nodiscard]] const WeldPositionEstimate& estimate() const noexcept;
  [[nodiscard]] const WeldPositioningCounts& counts() const noexcept;
  /// m, the sum of all good increments: what `WeldSighting::odometer_distance` refers to.
  [[nodiscard]] double odometer_distance() const noexcept;
  /// One per joint of the tally, or `largest_joint_count`.
  [[nodiscard]] std::span<const LearntJoint> learnt_joints() const noexcept;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// For people: "accepted", "bad value", "out of order"; "unknown" for a value that is none.
[[nodiscard]] const char* to_string(PositioningStatus status) noexcept;
/// "forward", "backward", "unknown".
[[nodiscard]] const char* to_string(Orientation orientation) noexcept;

}  // namespace pipescout::odometry
