// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>

#include "pipescout/estimation/start_alignment.hpp"

/// Whether a source of absolute measurements is to be believed: it is taken up again after an
/// outage, or after it was found wrong, only when it has borne itself out.
namespace pipescout::estimation {

enum class SourceState : std::uint8_t {
  kAbsent,     ///< nothing has come from it for `outage`
  kCandidate,  ///< it has come back; what it says is compared, and not used
  kTrusted,    ///< used
  kDoubted,    ///< it was trusted and has contradicted several times running; compared, and not
               ///< used where it contradicts
};
/// "absent", "candidate", "trusted", "doubted"; "unknown" for a value that is no enumerator.
[[nodiscard]] std::string_view to_string(SourceState state) noexcept;

struct SourceWatchParameters {
  /// Errors of measurements that are nearer in time than this are much the same; s, in [0, 1000].
  /// 0: each has its own. See `covariance_factor`.
  double correlation_time = 0;
  double outage = 5;                ///< s without an accepted measurement; in [0.1, 1000]
  std::size_t doubt_after = 8;      ///< measurements gated in a row; in [1, 10000]
  std::size_t agreeing = 5;         ///< measurements that must agree to be trusted; in [2, 10000]
  double agreeing_time = 1;         ///< s that they must span; in [0, 1000]
  double gate_probability = 0.999;  ///< share of good ones that count as agreeing; in (0.5, 1)
  /// Dead reckoning since the last trusted measurement is taken to be off by no less than this
  /// share of its way, one standard deviation; in [0, 1].
  double drift_share = 0.01;
  double drift_floor = 0.5;  ///< m (rad for headings), the least of it; in [0, 1000]
  /// Without an odometer, or when it or the IMU has had faults, by no less than this speed for 20 s
  /// at most; with both 5 times as much; m/s (rad/s), in [0, 100].
  double drift_speed = 1;
  /// A source that agrees with the motion, but not with the state, moves the state when it has
  /// agreed for so long; s, in [1, 1e6].
  double takeover = 60;
  /// The same where absolute measurements had borne the state out for `confirmation` seconds.
  double confirmed_takeover = 600;  ///< s, in [1, 1e6]
  double confirmation = 30;         ///< s, in [0, 1e6]

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// A measurement of a position, against what dead reckoning says. For headings: x alone, rad.
struct WatchedFix {
  double time = 0;
  Eigen::Vector3d measured = Eigen::Vector3d::Zero();   ///< m, in the map
  double deviation = 1;                                 ///< m, of `measured`, the worst axis
  Eigen::Vector3d reckoned = Eigen::Vector3d::Zero();   ///< m, the same point in `odom`
  double velocity_deviation = 0;                        ///< m/s, of the motion of `reckoned`
  Eigen::Vector3d predicted = Eigen::Vector3d::Zero();  ///< m, the same point by the state
  double predicted_deviation = 1;                       ///< m, of `predicted`, the worst axis
  double way = 0;                                       ///< m, travelled so far by dead reckoning
  bool witnessed = true;                                ///< the odometer is there
  bool shaken = false;     ///< IMU or odometer had faults since the last accepted position
  double borne_out = 0;    ///< s for which absolute positions have agreed with the state
  bool contested = false;  ///< another source of positions is trusted, and agrees with the state
};

/// By how much the covariance of each of a row of measurements, `spacing` seconds apart, has to be
/// larger so that together they tell no more than they do, when their errors are those of a
/// first-order Gauss-Markov process of that correlation time: (1 + a) / (1 - a) with
/// a = exp(-spacing / correlation_time), the variance of the mean of many against that of white
/// ones. Not beyond what makes all of `memory` seconds, the longest that is looked back upon, one
/// measurement. 1 without correlation. `spacing` > 0; not checked.
[[nodiscard]] double covariance_factor(double correlation_time, double spacing,
                                       double memory) noexcept;

/// What is to be done with a measurement.
enum class Verdict : std::uint8_t {
  kUse,       ///< as a measurement of a trusted source
  kHold,      ///< not at all
  kAcquire,   ///< the source has become trusted with this one: the state may have to be widened
  kTakeOver,  ///< the state is wrong: to be moved to where the source says
};

/// The state machine of one source of positions:
///
///     absent -> candidate -> trusted -> doubted -> trusted
///                               |          |
///                               +-> absent <+
///
/// A candidate's fixes must agree with each other and with the motion that dead reckoning has seen
/// meanwhile, and lie within what dead reckoning can be off since the last trusted measurement.
/// Those that are farther away are never taken as such, however consistent: they take over after
/// `takeover` or `confirmed_takeover` only, and not while another source contests it. So nothing is
/// captured by a cluster of wrong fixes that lasts for minutes, and nothing is locked out for ever.
///
/// Of a doubted source a fix is used, all the same, that lies where state and odometer have it: the
/// ones before it were wrong, not the state.
///
/// Pure; no allocation.
class AbsoluteSourceWatch {
 public:
  /// Throws as SourceWatchParameters::validate.
  explicit AbsoluteSourceWatch(const SourceWatchParameters& parameters);

  /// A measurement has come. Of a candidate those older than the newest are held.
  Verdict judge(const WatchedFix& fix) noexcept;
  /// While there is no state: compares the fix with those before and the motion.
  void compare(const WatchedFix& fix) noexcept;
  /// What the smoother's gate made of a measurement that was to be used.
  void note_accepted(double time, double way) noexcept;
  void note_gated() noexcept;
  /// The state stands on this source from now on: it was started from it.
  void trust(double time, double way) noexcept;
  /// The state has been placed anew by something else; what the source says is to be compared.
  void distrust(double time, double way) noexcept;
  /// Time goes on: a source that is silent becomes absent.
  void expire(double time) noexcept;

  [[nodiscard]] SourceState state() const noexcept { return state_; }
  [[nodiscard]] const TrackAlignment& track() const noexcept { return track_; }
  /// s for which its fixes have agreed with the motion, and how many; 0 of a trusted source.
  [[nodiscard]] double agreed_for() const noexcept;
  [[nodiscard]] std::size_t agreeing() const noexcept { return track_.pairs(); }
  /// m, of the first of them.
  [[nodiscard]] double first_deviation() const noexcept { return first_.deviation; }
  [[nodiscard]] double last_accepted() const noexcept { return last_accepted_; }
  /// What dead reckoning is taken to be off at least at a fix, one standard deviation.
  [[nodiscard]] double drift(const WatchedFix& fix) const noexcept;

 private:
  void begin_candidate(const WatchedFix& fix) noexcept;
  /// m/s, that dead reckoning may be off at least.
  [[nodiscard]] double drift_speed(const WatchedFix& fix) const noexcept;
  [[nodiscard]] bool agrees_with_motion(const WatchedFix& fix) const noexcept;
  [[nodiscard]] bool within_reach(const WatchedFix& fix) const noexcept;
  [[nodiscard]] bool bears_state_out(const WatchedFix& fix) const noexcept;

  SourceWatchParameters parameters_;
  double gate_ = 0;
  SourceState state_ = SourceState::kAbsent;
  double last_accepted_ = std::numeric_limits<double>::quiet_NaN();
  double last_seen_ = std::numeric_limits<double>::quiet_NaN();
  double trusted_since_ = std::numeric_limits<double>::quiet_NaN();  // or the state was placed
  double trusted_way_ = 0;
  std::size_t gated_running_ = 0;
  // Of the candidate.
  TrackAlignment track_{};
  WatchedFix first_{};
  std::size_t strayed_ = 0;  // running
  std::size_t within_ = 0;   // within reach, running
  double first_within_ = 0;
};

}  // namespace pipescout::estimation
