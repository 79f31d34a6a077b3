// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include "pipescout/estimation/error_correlation.hpp"
#include "pipescout/estimation/start_alignment.hpp"
#include "pipescout/estimation/track_witness.hpp"

/// Monitoring of a source of absolute measurements: after an outage, or after it was doubted, it is
/// used again only when its measurements have proved consistent.
namespace pipescout::estimation {

enum class SourceState : std::uint8_t {
  kAbsent,     ///< no measurement for `outage`
  kCandidate,  ///< it has returned; its measurements are compared and not used
  kTrusted,    ///< used
  kDoubted,    ///< it was trusted, and several measurements in a row were gated; compared, and not
               ///< used if inconsistent
};
/// "absent", "candidate", "trusted", "doubted"; "unknown" for any other value.
[[nodiscard]] std::string_view to_string(SourceState state) noexcept;

struct SourceWatchParameters {
  /// Correlation time of the measurement errors; s, in [0, 1000]. 0: white. See
  /// `covariance_factor`.
  double correlation_time = 0;
  /// s, in [0, 1000]: below `correlation_time` the correlation time is found on line, from the
  /// innovations, between both, beginning with `correlation_time`; else it is as stated. Of
  /// positions alone. See ErrorCorrelation.
  double shortest_correlation_time = 1000;
  /// s, in [0, 1000], of the heights of GPS, where that is longer: a vehicle on the ground knows
  /// how it climbs so well that it averages heights over minutes, through which their errors may
  /// last.
  double height_correlation_time = 0;
  /// Standard deviations are taken for up to this factor larger than stated, while measurements
  /// turn out to be that far off the state; in [1, 100]. 1: as stated, always.
  double largest_deviation_factor = 1;
  double outage = 5;            ///< s without an accepted measurement; in [0.1, 1000]
  std::size_t doubt_after = 8;  ///< measurements gated in a row; in [1, 10000]
  std::size_t agreeing = 5;     ///< measurements that must agree to be trusted; in [2, 10000]
  double agreeing_time = 1;     ///< s that they must span; in [0, 1000]
  /// share of correct measurements that count as agreeing; in (0.5, 1)
  double gate_probability = 0.999;
  /// Lower bound of the error of dead reckoning since the last trusted measurement, as a share of
  /// the distance travelled, one standard deviation; in [0, 1].
  double drift_share = 0.01;
  double drift_floor = 0.5;  ///< m (rad for headings), smallest value of that bound; in [0, 1000]
  /// The same without an odometer, or after faults of it or of the IMU, as a speed, for at most 20
  /// s; five times as much with both; m/s (rad/s), in [0, 100].
  double drift_speed = 1;
  /// A source that is consistent with the motion, but not with the state, resets the state after
  /// this time; s, in [1, 1e6].
  double takeover = 60;
  /// The same if absolute measurements had confirmed the state for `confirmation` seconds.
  double confirmed_takeover = 600;  ///< s, in [1, 1e6]
  double confirmation = 30;         ///< s, in [0, 1e6]

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// A measurement of a position, compared with dead reckoning. For headings: x alone, rad.
struct WatchedFix {
  double time = 0;
  Eigen::Vector3d measured = Eigen::Vector3d::Zero();  ///< m, in the map
  double deviation = 1;                                ///< m, of `measured`, the worst axis
  Eigen::Vector3d reckoned = Eigen::Vector3d::Zero();  ///< m, the same point in `odom`
  double velocity_deviation = 0;                       ///< m/s, of the motion of `reckoned`
  Eigen::Vector3d predicted =
      Eigen::Vector3d::Zero();     ///< m, the same point according to the state
  double predicted_deviation = 1;  ///< m, of `predicted`, the worst axis
  double yaw = 0;                  ///< rad, of the map from `odom`
  double way = 0;                  ///< m, travelled so far by dead reckoning
  bool witnessed = true;           ///< an odometer is available
  bool shaken = false;             ///< IMU or odometer had faults since the last accepted position
  double borne_out = 0;            ///< s for which absolute positions have confirmed the state
  bool contested = false;  ///< another source of positions is trusted and consistent with the state
};

/// Factor by which the covariance of each measurement in a series, `spacing` seconds apart, has to
/// be inflated when the errors are a first-order Gauss-Markov process of that correlation time: (1
/// + a) / (1 - a) with a = exp(-spacing / correlation_time), the ratio of the variance of the mean
/// of many measurements to that of white ones. It holds for correlations longer than the smoother's
/// lag too: what leaves the lag stays in the state as if it were known from independent
/// measurements. 1 without correlation. `spacing` > 0; not checked.
[[nodiscard]] double covariance_factor(double correlation_time, double spacing) noexcept;

/// Use of a measurement.
enum class Verdict : std::uint8_t {
  kUse,      ///< as a measurement of a trusted source
  kHold,     ///< not at all
  kAcquire,  ///< the source has become trusted: the covariance of the state may have to be inflated
  kTakeOver,  ///< the state is wrong: reset it to the source's position
};

/// The state machine of one source of positions:
///
///     absent -> candidate -> trusted -> doubted -> trusted
///                               |          |
///                               +-> absent <+
///
/// A candidate's fixes must agree with each other and with the motion by dead reckoning in the
/// meantime, and lie within the possible error of dead reckoning since the last trusted
/// measurement. Fixes farther away are not accepted, however consistent they are: they reset the
/// state only after `takeover` or `confirmed_takeover`, and not while another source contradicts
/// them. So a cluster of wrong fixes that lasts for minutes does not capture the state, and no
/// source is locked out permanently.
///
/// A fix of a doubted source that is consistent with state and odometer is used: then the previous
/// fixes were wrong, not the state. And fixes that go on from those that were believed, as dead
/// reckoning says, are within reach wherever the state is: see TrackWitness. Then it is the state
/// that is off, or surer than it should be.
///
/// Pure; no allocation.
class AbsoluteSourceWatch {
 public:
  /// Throws as SourceWatchParameters::validate.
  explicit AbsoluteSourceWatch(const SourceWatchParameters& parameters);

  /// Processes a measurement. For a candidate, measurements older than the newest one are held.
  Verdict judge(const WatchedFix& fix) noexcept;
  /// Before initialisation: compares the fix with previous ones and the motion.
  void compare(const WatchedFix& fix) noexcept;
  /// A measurement of a trusted source is on its way to the smoother. `innovation`: m, horizontal,
  /// measured less predicted.
  void offer(const TrackPair& pair, double yaw, const Eigen::Vector2d& innovation) noexcept;
  /// Reports the result of the smoother's gate for a measurement to be used.
  void note_accepted(double time, double way) noexcept;
  void note_gated() noexcept;
  /// Learns how far measurements are off, accepted or gated, from their chi-squares. Before
  /// `note_accepted`.
  void note_misfit(double time, double chi_square_per_degree) noexcept;
  /// Factor on the covariance of a measurement `spacing` s (> 0) after the one before: of
  /// correlated errors, and, in [1, largest_deviation_factor^2], what the misfits showed so far.
  [[nodiscard]] double covariance_scale(double spacing) const noexcept;
  /// s, of the errors, as it is used: stated, or found on line.
  [[nodiscard]] double correlation_time() const noexcept;
  /// The same next to what the innovations show. Costs some tens of microseconds.
  [[nodiscard]] CorrelationFinding correlation() const noexcept;
  /// Factor on the standard deviations: what the misfits showed so far.
  [[nodiscard]] double deviation_factor() const noexcept;
  /// The state was initialised from this source.
  void trust(double time, double way) noexcept;
  /// The state was reset by another source; measurements of this one have to be compared again.
  void distrust(double time, double way) noexcept;
  /// Advances the time: a silent source becomes absent.
  void expire(double time) noexcept;

  [[nodiscard]] SourceState state() const noexcept { return state_; }
  [[nodiscard]] const TrackAlignment& track() const noexcept { return track_; }
  /// s for which its fixes have agreed with the motion, and their number; 0 for a trusted source.
  [[nodiscard]] double agreed_for() const noexcept;
  [[nodiscard]] std::size_t agreeing() const noexcept { return track_.pairs(); }
  /// m, of the first of them.
  [[nodiscard]] double first_deviation() const noexcept { return first_.deviation; }
  [[nodiscard]] double last_accepted() const noexcept { return last_accepted_; }
  /// Lower bound of the error of dead reckoning at a fix, one standard deviation.
  [[nodiscard]] double drift(const WatchedFix& fix) const noexcept;

 private:
  void begin_candidate(const WatchedFix& fix) noexcept;
  /// m/s, lower bound of the velocity error of dead reckoning.
  [[nodiscard]] double drift_speed(const WatchedFix& fix) const noexcept;
  [[nodiscard]] bool agrees_with_motion(const WatchedFix& fix) const noexcept;
  [[nodiscard]] bool within_reach(const WatchedFix& fix) const noexcept;
  [[nodiscard]] std::optional<bool> ask_witness(const TrackPair& pair, double yaw) const noexcept;
  [[nodiscard]] bool goes_on(const WatchedFix& fix) const noexcept;
  [[nodiscard]] bool bears_state_out(const WatchedFix& fix) const noexcept;

  SourceWatchParameters parameters_;
  double gate_ = 0;
  SourceState state_ = SourceState::kAbsent;
  double last_accepted_ = std::numeric_limits<double>::quiet_NaN();
  double last_seen_ = std::numeric_limits<double>::quiet_NaN();
  double trusted_since_ = std::numeric_limits<double>::quiet_NaN();  // or since the state was reset
  double trusted_way_ = 0;
  std::size_t gated_running_ = 0;
  TrackWitness witness_{};
  ErrorCorrelation correlation_{};
  double log_scale_ = 0;  // of the covariances
  struct Offered {
    TrackPair pair{};
    double yaw = 0;
    Eigen::Vector2d innovation = Eigen::Vector2d::Zero();
  };
  std::array<Offered, 8>
      offered_{};  // the newest, in a ring: the gate may not have told of them yet
  std::size_t next_offered_ = 0;
  // Of the candidate.
  TrackAlignment track_{};
  WatchedFix first_{};
  std::size_t strayed_ = 0;  // running
  std::size_t within_ = 0;   // within reach, running
  double first_within_ = 0;
};

}  // namespace pipescout::estimation
