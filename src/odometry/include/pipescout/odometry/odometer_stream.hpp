// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "pipescout/odometry/consensus_fusion.hpp"

/// Streaming fusion of redundant odometers: fuses samples of 2 to 16 odometers, each with its own
/// rate and phase, to one travelled distance with its variance. Consensus is that of
/// `ConsensusFusion` (Wang and others, 2008), on the increments since the last agreed distance.
///
/// Method: every odometer's path is interpolated at the ticks of one time grid. Between anchors at
/// least `window_distance` apart, the increments of all odometers since the anchor are fused at
/// each tick, so a slip that becomes detectable is corrected back to the anchor.
///
/// Metres and seconds, along the pipe, forward positive; reversing makes increments negative.
/// Deterministic: the same samples in the same order give the same bits. Memory is bounded; after
/// construction nothing allocates unless it throws. One thread at a time per object.
namespace pipescout::odometry {

/// True increment = scale * measured increment. From weld to weld: true length = scale * measured
/// length + offset, where the offset is the paper's compensation (section 4); only
/// `OdometerStream::end_segment` adds it.
struct OdometerCorrection {
  double scale = 1.0;   ///< in [0.5, 2]
  double offset = 0.0;  ///< m per segment, finite
  /// Of (scale, offset), symmetric positive semi-definite; units 1, m, m^2.
  Eigen::Matrix<double, 2, 2, Eigen::DontAlign> covariance{{0.0, 0.0}, {0.0, 0.0}};

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

enum class OdometerKind : std::uint8_t {
  kAbsolute,   ///< a value is the distance counted so far, from an arbitrary zero
  kIncrement,  ///< a value is the distance since the previous sample; a lost one cannot be
               ///< recovered
};

struct OdometerParameters {
  OdometerKind kind = OdometerKind::kAbsolute;
  double resolution = 0.001;  ///< m per encoder count, > 0
  /// m per square root of metre, > 0: standard deviation of the independent error, which grows with
  /// the square root of the path. The paper's 0.056 m on 5.5 m are 0.024.
  double sigma_per_sqrt_metre = 0.024;
  double wrap = 0.0;    ///< m, range after which an absolute counter wraps around; 0: never
  double period = 0.0;  ///< s between samples, to detect lost increments; 0: unknown
  /// rad, where the wheel touches the wall: around the axis of the crawler from its top, clockwise
  /// for one who looks forward (3 o'clock is pi / 2). Needed by `FusionRule::kCircumference`.
  double clock = std::numeric_limits<double>::quiet_NaN();
  /// m, finite: how far to the left of the robot's reference point the wheel is. With the rates of
  /// `push_yaw_rate` its share of a turn is taken out of its increments: a wheel at y travels
  /// d - y theta where the reference point travels d and the robot turns by theta to the left
  /// (rigid body, wheel axles across the robot; of a steered wheel this is the part along the
  /// robot).
  double lateral = 0.0;
  OdometerCorrection correction{};
};

enum class SigmaSource : std::uint8_t {
  kGiven,      ///< `OdometerParameters::sigma_per_sqrt_metre`
  kResiduals,  ///< 1.4826 * median of |increment - fused| / sqrt(path) over `residual_windows`, the
               ///< fused variance added; the given one until half of these windows have passed
};

/// How the increments of the odometers become one.
enum class FusionRule : std::uint8_t {
  kConsensus,  ///< of those that a group supports: equations (1) to (13). In a bend the wheels of a
               ///< circumference travel different distances, and it drops the minority
  kAverage,    ///< the plain mean, equation (14): a slipping wheel is part of it
  kCircumference,  ///< wheels at known clock positions: distance, bend and slip are told apart, see
                   ///< `CircumferenceParameters`
};

/// Wheels around the circumference of a pipe. In a bend each goes its own way: the wheel at the
/// clock position c travels  d - r theta cos(c - b)  where the axis is d long and turns by theta
/// towards the direction b. With three wheels a slip of one looks exactly like a bend towards it.
/// What tells them apart: a bend may have any direction, a slip only that of a wheel; a bend is not
/// tighter than pipes are, has often a standard angle, and does not change the speed of the crawler
/// more than it changes elsewhere. The distance is the mean over the explanations, weighted by
/// their probability, and their difference is in the variance. More wheels add redundancy. Why:
/// docs/decisions/bends-told-from-slip-by-probability.md.
struct CircumferenceParameters {
  double radius = 0.0;          ///< m, > 0: from the axis of the pipe to where the wheels touch it
  double tightest_bend = 1.5;   ///< [0.6, 100]: radius of the axis, in diameters of the pipe
  double smallest_bend = 0.1;   ///< rad, (0, pi]: smaller ones are not told as found
  double clock_sigma = 0.0175;  ///< rad, [0, 0.5]: standard deviation of a clock position
};

/// Thresholds of the health states of an odometer. A window is the path between two anchors.
struct OdometerHealthParameters {
  double slip_ratio = 0.03;  ///< (0, 1): slips when its error exceeds this share of the distance
  double slip_sigmas = 3.0;  ///< [1, 10]: and this many standard deviations
  /// (0, 1): stuck when it measures less than this share of the distance
  double stuck_ratio = 0.1;
  double worn_tolerance = 0.01;  ///< (0, 0.5): worn when its scale deviates more from the median
  double worn_release = 0.7;     ///< (0, 1): not worn any more below this share of the tolerance
  double scale_memory = 200.0;   ///< m, >= window_distance: path over which the scale is estimated
  int enter_windows = 2;         ///< [1, 1000]: windows in a row before slipping or stuck
  int leave_windows = 3;         ///< [1, 1000]: windows in a row until it is ok again
  double bad_share_enter = 0.3;  ///< (0, 1): share of bad values among about 20 samples
  double bad_share_leave = 0.1;  ///< (0, bad_share_enter)
};

struct OdometerStreamParameters {
  std::vector<OdometerParameters> odometers{};  ///< 2 to 16
  FusionRule rule = FusionRule::kConsensus;
  /// Of `kCircumference`, which needs three wheels that are not all on one line
  CircumferenceParameters circumference{};
  ConsensusFusionParameters consensus{};  ///< offsets must be empty: see `end_segment`
  /// [1, 10]. Support is computed with sigmas multiplied by this factor: without it too many sound
  /// readings are rejected (docs/decisions/majority-support-rule.md). The resulting variance is
  /// without it.
  double sigma_margin = 3.0;
  SigmaSource sigma_source = SigmaSource::kGiven;
  std::size_t residual_windows = 32;  ///< [8, 64]
  double tick_period = 0.1;           ///< s, (0, 60]: of the grid on which odometers are aligned
  double window_distance = 1.0;       ///< m, (0, 100]: path after which the distance is anchored
  /// [0, 16]. Windows over which a slip that is too small for one window is detected, and then
  /// removed. The distance is final up to the oldest of these windows. Needs three odometers.
  std::size_t lookback_windows = 8;
  /// [1, 10]: threshold in standard deviations, and `health.slip_ratio`
  double lookback_sigmas = 5.0;
  double window_time = 30.0;  ///< s, >= tick_period: or time, at standstill
  /// s, [0, 60 * tick_period]: longest wait of a tick for late odometers
  double maximum_delay = 0.5;
  double maximum_gap = 2.0;   ///< s, [tick_period, 1000 * tick_period]: longer ones are not bridged
  double silent_after = 1.0;  ///< s, > 0: without samples; silent odometers are not waited for
  double maximum_speed = 5.0;  ///< m/s, > 0: a faster sample is a counter fault
  /// Errors common to all odometers (bends, deposits, temperature), unobservable by consensus:
  double common_sigma_per_sqrt_metre = 0.0;  ///< m per square root of metre, >= 0
  double common_scale_sigma = 0.0;           ///< [0, 1], of a scale common to all
  /// (0, 1]. Standard deviation of a single odometer as a share of the distance.
  double unverified_ratio = 0.3;
  OdometerHealthParameters health{};

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct OdometerSample {
  std::size_t odometer = 0;
  double time = std::numeric_limits<double>::quiet_NaN();   ///< s, of measurement
  double value = std::numeric_limits<double>::quiet_NaN();  ///< m, see `OdometerKind`
  bool valid = true;  ///< false: marked as invalid by the driver
};

/// Outcome of a sample. Only accepted ones are fused; each kind is counted.
enum class SampleOutcome : std::uint8_t {
  kAccepted,
  kMarkedInvalid,
  kNotANumber,       ///< value NaN or infinite
  kBadStamp,         ///< stamp NaN or infinite
  kDuplicateStamp,   ///< stamp equal to that of the previous sample
  kOutOfOrder,       ///< stamp before that of the previous sample
  kStampLeap,        ///< further from the newest stamp than `maximum_gap`, and not yet confirmed by
                     ///< another odometer, or by four more of this one with the others silent
  kImplausible,      ///< faster than `maximum_speed`: a reset of the counter, a wrong value
  kUnknownOdometer,  ///< no such odometer
};
inline constexpr std::size_t kSampleOutcomes = 9;

enum class OdometerHealth : std::uint8_t {
  kOk,
  kWorn,       ///< its scale deviates from that of the others beyond the tolerance
  kSlipping,   ///< disagrees with the consensus
  kStuck,      ///< stands still while the others move; excluded from the consensus
  kBadValues,  ///< too many of its samples are unusable
  kSilent,     ///< no samples
};

/// Use of an odometer in the latest fusion.
enum class OdometerUse : std::uint8_t {
  kAbsent,       ///< no value for this tick: silent, late, or not started
  kIncomplete,   ///< joined, lost samples or was reset since the anchor
  kStuck,        ///< excluded for its health
  kDrifted,      ///< excluded: slip over the last windows, see `lookback_windows`
  kUnsupported,  ///< no group supports it; or a fault of it explains the increments
  kFused,
  kFallback,  ///< no consensus: used for the fallback
};

struct OdometerState {
  OdometerHealth health = OdometerHealth::kSilent;
  OdometerUse use = OdometerUse::kAbsent;
  double increment = std::numeric_limits<double>::quiet_NaN();           ///< m since the anchor
  double standard_deviation = std::numeric_limits<double>::quiet_NaN();  ///< m, without the margin
  /// m, without correction, at the last tick with a position of it. From weld to weld this is
  /// `WeldSpacing::measured` of a calibration, when `gaps` is the same at both.
  double measured = 0.0;
  double sigma_per_sqrt_metre = 0.0;  ///< in use: given or estimated
  double relative_scale = 1.0;        ///< to the median odometer, over `scale_memory`
  OdometerCorrection correction{};
  std::array<std::uint64_t, kSampleOutcomes> samples{};  ///< by `SampleOutcome`
  std::uint64_t gaps = 0;         ///< gaps in its path: silence, lost increments
  std::uint64_t unsupported = 0;  ///< windows in which no group supported it
};

enum class StreamStatus : std::uint8_t {
  kWaiting,      ///< no tick has been fused yet
  kOk,           ///< a group of odometers agrees
  kNoConsensus,  ///< the fallback: median of the increments of the odometers that are ok or worn
                 ///< (of all when none is); its standard deviation is the largest deviation among
                 ///< them, or `unverified_ratio` of the distance for a single one, added up over
                 ///< windows in a row without consensus as errors of one sign
  kNoData,  ///< no odometer: the last speed is extrapolated, with the standard deviation of a speed
            ///< up to `maximum_speed`; corrected when an absolute counter spans the gap
};

/// A bend of the pipe. Distances are those of `FusedStream::distance`; their accumulated error is
/// not in the standard deviations.
struct FoundBend {
  double middle = 0.0;                     ///< m
  double middle_standard_deviation = 0.0;  ///< m
  double length = 0.0;                     ///< m, along the axis; good to a window
  double angle = 0.0;                      ///< rad, > 0
  double angle_standard_deviation = 0.0;   ///< rad
  /// rad, (-pi, pi]: where the centre of the bend is, as a clock position of the crawler, its roll
  /// added where `set_roll` has told it
  double direction = 0.0;
  double probability = 0.0;  ///< that it is none of a slip; above 0.5
};

struct FusedStream {
  StreamStatus status = StreamStatus::kWaiting;
  std::uint64_t tick = 0;                                  ///< ticks fused so far
  double time = std::numeric_limits<double>::quiet_NaN();  ///< s, of the tick
  double distance = 0.0;                                   ///< m since the first tick
  double variance = 0.0;                                   ///< m^2, random and systematic
  double random_variance = 0.0;   ///< m^2, the part that is independent between increments
  double speed = 0.0;             ///< m/s, over the window
  double window_increment = 0.0;  ///< m since the anchor, part of `distance`
  /// D, R, fusion set and standard deviation of the consensus, margin included. Entries of
  /// odometers that were not used are marked invalid.
  ConsensusFusionResult consensus{};
  std::array<OdometerState, kMaxOdometers> odometers{};
  std::uint64_t windows = 0;               ///< anchors so far
  std::uint64_t windows_no_consensus = 0;  ///< of these
  std::uint64_t windows_no_data = 0;       ///< of these
  std::uint64_t bends = 0;                 ///< found so far, see `kCircumference`
  FoundBend bend{};                        ///< the last of them
  /// Probability that the pipe is bent where the crawler is; 0 with other rules.
  double in_bend = 0.0;
  /// windows in which a bend or a fault explained the increments; 0 with other rules
  std::uint64_t uneven_windows = 0;
  std::uint64_t leaps = 0;             ///< jumps of all clocks that were accepted
  std::uint64_t unknown_odometer = 0;  ///< samples of unknown odometers
};

struct PushResult {
  SampleOutcome outcome = SampleOutcome::kAccepted;
  std::size_t ticks = 0;  ///< completed by the sample; `state` is that of the last
};

class OdometerStream {
 public:
  /// Throws what `OdometerStreamParameters::validate` throws.
  explicit OdometerStream(OdometerStreamParameters parameters);
  OdometerStream(OdometerStream&& other) noexcept;
  OdometerStream& operator=(OdometerStream&& other) noexcept;
  ~OdometerStream();

  /// Samples of one odometer in the order of their stamps, of different ones in any order within
  /// `maximum_delay`. Never throws: unusable samples are counted and reported in the result.
  PushResult push(const OdometerSample& sample) noexcept;

  /// Fuses the ticks that still wait for late odometers, at the end of a run. Returns their number.
  std::size_t flush() noexcept;

  /// Applies to later measurements; the distance so far and its variance are final. The errors of
  /// successive corrections of an odometer are treated as one persistent error. The estimate of the
  /// relative scale is restarted, and a worn odometer becomes ok. Throws std::invalid_argument as
  /// `OdometerCorrection::validate`, or naming the odometer.
  void set_correction(std::size_t odometer, const OdometerCorrection& correction);

  /// rad/s, about the robot's axis that points up, to the left positive, at `time` (s, as of the
  /// samples), from a gyroscope. In the order of the stamps; to come before the odometers' samples
  /// that are later. Wheels beside each other travel different ways in a turn, which looks like a
  /// slip of half of them; see `OdometerParameters::lateral`. Between two rates that are further
  /// apart than `maximum_gap`, the robot counts as not turning. What is not finite or not later
  /// than the last one is ignored.
  void push_yaw_rate(double time, double rate) noexcept;

  /// rad, roll of the crawler from now on, clockwise for one who looks forward: clock positions in
  /// the pipe are those of the crawler plus its roll. Only `FoundBend::direction` depends on it.
  /// Not finite: ignored.
  void set_roll(double roll) noexcept;

  /// Call it at the passage of a weld: adds the offsets of the odometers, each weighted by its
  /// share of the fused distance since the last call, with their variance. The distance so far is
  /// final.
  void end_segment() noexcept;

  [[nodiscard]] const FusedStream& state() const noexcept;
  [[nodiscard]] const OdometerStreamParameters& parameters() const noexcept;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// For messages; "unknown" for any other value.
[[nodiscard]] const char* to_string(SampleOutcome outcome) noexcept;
[[nodiscard]] const char* to_string(OdometerHealth health) noexcept;
[[nodiscard]] const char* to_string(OdometerUse use) noexcept;
[[nodiscard]] const char* to_string(StreamStatus status) noexcept;

}  // namespace pipescout::odometry
