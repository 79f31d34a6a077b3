// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/estimation/absolute_source_watch.hpp"
#include "pipescout/estimation/fixed_lag_smoother.hpp"
#include "pipescout/estimation/pipe_centre_line.hpp"

/// State estimation of a vehicle from measurements in any order and of any quality.
///
/// Frames: `map` and `odom` (z up), `body` (axes of the vehicle, x forwards, z up; its origin is
/// the IMU). SI units, rad; times in seconds of one clock.
namespace pipescout::estimation {

/// One instantaneous reading, in the axes of the IMU.
struct ImuReading {
  double time = 0;
  Eigen::Vector3d specific_force = Eigen::Vector3d::Zero();  ///< m/s^2
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();    ///< rad/s
};

enum class OdometerStatus : std::uint8_t {
  kGood,
  kNoConsensus,  ///< the odometers are inconsistent: used with `no_consensus_factor`
  kNoData,       ///< extrapolated: not used
};

/// Distance travelled since an arbitrary zero, forwards positive.
struct OdometerReading {
  double time = 0;
  double distance = 0;  ///< m
  /// m^2, accumulated: errors of increments are independent, so that the variance of an increment
  /// is the difference of two of these.
  double variance = 0;
  OdometerStatus status = OdometerStatus::kGood;
};

/// How the wheels say that the body turns: a witness of standstill beside the gyro, whose bias and
/// a slow turn look alike. Nothing else is made of it.
struct WheelTurn {
  double time = 0;
  double yaw_rate = 0;  ///< rad/s, to the left positive
};

/// An initial pose in the map, complete or in part. Used for initialisation; ignored while running.
struct GivenPose {
  double time = 0;
  std::optional<Eigen::Vector3d> position{};  ///< m, of the body
  double position_deviation = 1;              ///< m, per axis, in [1e-3, 1e4]
  std::optional<double> heading{};            ///< rad, of the body's x axis from the map's x axis
  double heading_deviation = 0.1;             ///< rad, in [1e-4, 1]
};

enum class Source : std::uint8_t {
  kImu,
  kOdometer,
  kRelativePose,
  kGps,
  kVisualPose,
  kHeading,
  kWeld,
};
inline constexpr std::size_t kSources = 7;
/// "imu", "odometer", "relative_pose", "gps", "visual_pose", "heading", "weld"; "unknown".
[[nodiscard]] std::string_view to_string(Source source) noexcept;

struct StartParameters {
  double levelling = 1;  ///< s of IMU readings for levelling; in [0.1, 60]
  /// Standstill during levelling: upper bounds of the readings' standard deviations.
  double still_rate = 0.02;  ///< rad/s, in [1e-6, 10]
  double still_force = 0.3;  ///< m/s^2, in [1e-6, 100]
  /// A mean rate above this is a rotation, or a bias beyond that of a working gyro; rad/s, in
  /// [1e-6, 1].
  double largest_gyro_bias = 0.02;
  double accelerometer_bias_deviation = 0.1;  ///< m/s^2, in [1e-6, 10]
  double largest_tilt = 0.8;                  ///< rad, of body z from the vertical; in [0.01, pi/2]
  /// largest relative deviation of the mean force from gravity; in [0.01, 0.5]
  double gravity_tolerance = 0.1;
  double moving_tilt_deviation = 0.1;  ///< rad, when not at standstill; in [1e-3, 1]
  double largest_speed = 5;            ///< m/s, when not at standstill; in [0, 100]
  /// m/s, standard deviation of the velocity of a vehicle that hovers until it is initialised in
  /// the map, which improves levelling. In {0} (no assumption) or [1e-3, 10].
  double hover_speed = 0;
  double heading_deviation = 0.15;  ///< rad, required of a heading from motion; in [1e-3, 1]
  std::size_t position_fixes = 5;   ///< GPS positions that must agree first; in [1, 1000]
  /// s, after which the heading from motion is restarted; in [1, 10000]
  double longest_alignment = 120;
  /// The body's x axis points along a weld's `direction`.
  bool heading_from_weld = false;
  double weld_heading_deviation = 0.05;  ///< rad, in [1e-4, 1]
};

struct OdometerUse {
  double deviation = 0.005;         ///< m, added to each increment's; in [1e-6, 10]
  double share = 0.005;             ///< of the increment, added; in [0, 1]
  double across_deviation = 0.02;   ///< m, sideways slip between keyframes; in [1e-6, 100]
  double no_consensus_factor = 10;  ///< on deviations without consensus; 0: not used; in {0} or
                                    ///< [1, 1000]
  double largest_speed = 30;        ///< m/s; a larger speed between two readings is a reset of the
                                    ///< counter; in [0.1, 1000]
  double largest_gap = 0.5;         ///< s between readings that are interpolated; in [0.01, 10]
  /// m, in the body: the point whose path is measured, and which moves along the direction of
  /// travel.
  Eigen::Vector3d sensor = Eigen::Vector3d::Zero();
};

struct StandstillUse {
  /// Distance unchanged, the gyro quiet, and the wheels, if they tell, not turning the body.
  bool by_odometer = false;
  bool by_imu = false;           ///< gyro and accelerometer quiet: for vehicles that cannot hover
  double window = 0.5;           ///< s for which the condition must hold; in [0.05, 10]
  double still_distance = 2e-3;  ///< m, in [1e-9, 1]
  double still_rate = 0.01;      ///< rad/s, standard deviation and mean less bias; in [1e-6, 10]
  double still_force = 0.1;      ///< m/s^2, standard deviation; in [1e-6, 100]
  /// rad/s, mean over the window, of wheels that stand (WheelTurn); in [1e-6, 10]
  double wheel_rate = 2e-3;
  double velocity_deviation = 0.01;  ///< m/s, of the zero velocity; in [1e-6, 10]
  double rate_deviation = 2e-3;      ///< rad/s, of the zero angular rate; in [1e-6, 10]
};

/// A source of factors that this library has no watch for: magnetometers, barometers, beacons, the
/// velocity of a GPS receiver, or whatever a user measures. Its factors are of `own_kind(i)`, with
/// i its place in `StateEstimatorParameters::own_sources`, by which `smoother.robustness` holds its
/// gate and kernel.
struct OwnSource {
  /// s, correlation time of the measurement errors: `covariance_factor` applies; in [0, 1000]
  double correlation_time = 0;
};

struct StateEstimatorParameters {
  FixedLagSmootherParameters smoother{};
  geometry::SO3 R_body_imu{};       ///< from the axes of the IMU to those of the body
  double specific_force_scale = 1;  ///< factor from the readings to m/s^2: 9.80665 for an IMU in g;
                                    ///< in [1e-3, 1e3]
  double largest_rate = 40;         ///< rad/s; readings above it are refused; in [0.1, 1e4]
  double largest_force = 400;       ///< m/s^2, the same; in [1, 1e6]
  /// A reading that differs from the previous one by more, or by several times the recent
  /// differences, is used only if the next one confirms it.
  double spike_rate = 3;          ///< rad/s, in [0.01, 1e4]
  double spike_force = 15;        ///< m/s^2, in [0.1, 1e6]
  double largest_imu_gap = 0.05;  ///< s between readings that are joined, in [1e-4, 1]
  double keyframe_period = 0.1;   ///< s, in [0.005, 10]
  double imu_silence = 0.3;       ///< s without readings until coasting; in [0.01, 10]
  /// s, for which measurements that are ahead of the IMU wait for it. Of those that are further
  /// ahead the state makes use without the IMU, whose readings then come too late; in [0.1, 60].
  double longest_wait = 5;
  double longest_coasting = 30;  ///< s of coasting until the state is discarded; in [0.1, 1e4]
  double longest_jump = 10;      ///< s, jump in time after which the state is kept with an inflated
                                 ///< covariance; in [0, 1e4]
  StartParameters start{};
  OdometerUse odometer{};
  StandstillUse standstill{};
  SourceWatchParameters gps{};
  SourceWatchParameters visual_pose{.agreeing = 3, .agreeing_time = 0.2, .drift_floor = 0.1};
  SourceWatchParameters heading{.agreeing = 5, .agreeing_time = 1, .drift_floor = 0.1};
  /// Welds are far apart: a few that are consistent with the distance between them are sufficient.
  SourceWatchParameters weld{.outage = 1000, .doubt_after = 2, .agreeing = 2, .agreeing_time = 0};
  /// Of non-holonomic factors; both 0: none. In {0} or [1e-6, 100].
  double lateral_deviation = 0;   ///< m/s
  double vertical_deviation = 0;  ///< m/s
  /// m, correlation length of the slip: one such factor per this distance, and none at standstill;
  /// 0: at each keyframe. In [0, 1000].
  double lateral_correlation = 0;
  /// The body follows this line, with this standard deviation in m per axis, in [1e-6, 100].
  std::optional<PipeCentreLine> centre_line{};
  double centre_line_deviation = 0.05;
  /// m, correlation length of the distance from the line: the line is used once per this distance,
  /// and not at standstill; 0: at each keyframe. In [0, 1000].
  double centre_line_correlation = 0;
  /// Chainages of all welds on the centre line, m, increasing. A weld with a wrong data association
  /// is associated again: if exactly one of these welds is within the uncertainty of the state, it
  /// is used as that one. Empty: such a weld is not used.
  std::vector<double> tally{};

  /// At most kOwnFactorKinds.
  std::vector<OwnSource> own_sources{};

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;

  /// With odometer, non-holonomic, standstill by odometer.
  [[nodiscard]] static StateEstimatorParameters ground_robot();
  /// Without odometer, hovers.
  [[nodiscard]] static StateEstimatorParameters uav();
  /// In a pipe: odometer, welds, heading along the route; strongly non-holonomic.
  [[nodiscard]] static StateEstimatorParameters crawler();
};

enum class Phase : std::uint8_t {
  kStarting,  ///< attitude unknown
  kAligning,  ///< levelled, dead reckoning in `odom`; position or heading in the map is unknown
  kRunning,
  kCoasting,  ///< running, but the IMU is silent
  kFault,     ///< gravity contradicts the mounting of the IMU in the parameters; not started
};
/// "starting", "aligning", "running", "coasting", "fault"; "unknown".
[[nodiscard]] std::string_view to_string(Phase phase) noexcept;

enum class WaitsFor : std::uint8_t {
  kNothing,
  kImu,       ///< no readings, or none for a long time
  kLevel,     ///< `levelling` seconds of readings
  kPlace,     ///< GPS, a visual pose, a weld or a given pose
  kHeading,   ///< a heading, visual pose, weld or given pose, or motion with GPS
  kMounting,  ///< a fault that a parameter can correct
};
/// "nothing", "imu", "level", "place", "heading", "mounting"; "unknown".
[[nodiscard]] std::string_view to_string(WaitsFor what) noexcept;

enum class RestartReason : std::uint8_t {
  kNone,
  kTimeJumpForwards,   ///< short: continues from the last state with an inflated covariance
  kTimeJumpBackwards,  ///< the same
  kNumericalFailure,   ///< the same
  kLost,               ///< a long jump in time or coasting for too long: initialises again
  kReacquired,  ///< a source returned within the possible error of dead reckoning, but outside that
                ///< of the state
  kTakenOver,   ///< the state was wrong: reset to a source that was consistent for a long time
};
inline constexpr std::size_t kRestartReasons = 7;
/// "none", "time_jump_forwards", "time_jump_backwards", "numerical_failure", "lost", "reacquired",
/// "taken_over"; "unknown".
[[nodiscard]] std::string_view to_string(RestartReason reason) noexcept;

struct SourceStatus {
  /// IMU, odometer, relative pose and weld: absent or trusted.
  SourceState state = SourceState::kAbsent;
  std::size_t accepted = 0;
  /// by the chi-square gate; of the odometer, also by its neighbouring readings
  std::size_t gated = 0;
  /// Welds that were gated or held, and then associated with another weld of the tally.
  std::size_t reassigned = 0;
  std::size_t held = 0;  ///< not used, because the source was not trusted
  /// m (rad for headings), of the newest one that was held while running, from the state.
  double held_distance = std::numeric_limits<double>::quiet_NaN();
  std::size_t refused = 0;  ///< invalid values, late, duplicate, no space, quarantined
  std::size_t waiting = 0;  ///< now, for the IMU to reach their time
  Outcome last_refusal = Outcome::kAccepted;                          ///< reason of the newest one
  double last_accepted = std::numeric_limits<double>::quiet_NaN();    ///< s, its time
  double last_chi_square = std::numeric_limits<double>::quiet_NaN();  ///< accepted or gated
  // Of sources that are watched: how their noise is taken now, stated or found on line.
  double correlation_time = 0;  ///< s, see SourceWatchParameters
  double deviation_factor = 1;  ///< on the stated standard deviations
};

/// Intervals longer than `largest_imu_gap` between the stamps of readings of the IMU, and how late
/// these come.
struct ImuGaps {
  std::size_t count = 0;
  double total = 0;    ///< s
  double longest = 0;  ///< s
  double bridged = 0;  ///< s of keyframes without the IMU: by the other sources, or by dead motion
  double behind = 0;  ///< s, of the IMU behind the newest other stamp: most within the last seconds
};

struct EstimatorStatus {
  Phase phase = Phase::kStarting;
  WaitsFor waits_for = WaitsFor::kImu;
  /// The missing input, the fault and the parameter that corrects it, or what is held out and how
  /// far it is from the state. Empty when all is well.
  std::string text{};
  std::array<SourceStatus, kSources> sources{};  ///< by Source
  /// As StateEstimatorParameters::own_sources; absent or trusted.
  std::array<SourceStatus, kOwnFactorKinds> own_sources{};
  ImuGaps imu_gaps{};
  std::array<std::size_t, kRestartReasons> restarts{};
  RestartReason last_restart = RestartReason::kNone;
  double last_restart_time = std::numeric_limits<double>::quiet_NaN();
  bool standing_still = false;
  /// s since a position (GPS, visual pose, weld) was accepted; NaN: never.
  double since_absolute_position = std::numeric_limits<double>::quiet_NaN();

  [[nodiscard]] const SourceStatus& of(Source source) const noexcept {
    return sources[static_cast<std::size_t>(source)];
  }
};

/// The state at one time.
struct Estimate {
  double time = 0;
  /// Whether `state` is in the map and T_map_odom is valid; else `state` is in `odom`.
  bool in_map = false;
  NavState state{};
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();  ///< rad/s, in the body, bias removed
  /// Continuous: corrections change only its velocity.
  geometry::SE3 T_odom_body{};
  geometry::SE3 T_map_odom{};  ///< state.T_map_body() * T_odom_body^-1; jumps
};

/// Runs a FixedLagSmoother: initialisation, keyframes, monitoring of absolute sources, restarts.
///
/// Driven by the times of measurements alone. A keyframe is added once the IMU covers its time.
/// What is ahead of the IMU waits for it, at most `longest_wait` and kMostWaiting of each source
/// (beyond that: kFull); an IMU that is known to come late is waited for that long. A keyframe is
/// added without the IMU once other measurements are `imu_silence` later than they were at its last
/// reading, or `longest_wait` later than that: it coasts, by the other sources or, without any, by
/// dead motion. Gaps between readings are bridged in the same way. Measurements may be late by up
/// to the smoother's lag.
///
/// Only the constructor throws. Deterministic. Not thread-safe: one thread at a time.
class StateEstimator {
 public:
  /// Measurements of one source that wait for the IMU; of the odometer, eight times as many.
  static constexpr std::size_t kMostWaiting = 256;

  /// Throws as StateEstimatorParameters::validate.
  explicit StateEstimator(const StateEstimatorParameters& parameters);
  ~StateEstimator();
  StateEstimator(StateEstimator&&) noexcept;
  StateEstimator& operator=(StateEstimator&&) noexcept;

  /// kWaiting, or the reason of a refusal. The later outcome is in the status and in `last_update`.
  Outcome add(const ImuReading& reading) noexcept;
  Outcome add(const OdometerReading& reading) noexcept;
  /// kAccepted; kNotFinite; kLate or kFuture as for the others.
  Outcome add(const WheelTurn& turn) noexcept;
  Outcome add(const GpsMeasurement& m) noexcept;
  Outcome add(const HeadingMeasurement& m) noexcept;
  Outcome add(const VisualPoseMeasurement& m) noexcept;
  Outcome add(const WeldMeasurement& m) noexcept;
  Outcome add(const RelativePoseMeasurement& m) noexcept;
  /// A factor of an own source. Held until the state is in the map if the factor needs that.
  /// kUninitialised: of no such source, or as for the others.
  Outcome add(const AnyFactor& factor) noexcept;
  Outcome add(const GivenPose& pose) noexcept;
  /// Discards the state, not the counts, and initialises again.
  void restart() noexcept;
  /// How the map lies on the Earth, once that is known; from the next keyframe on. Throws as
  /// Earth::validate.
  void set_earth(const Earth& earth);

  /// At the newest IMU reading (or keyframe while coasting); nothing before the levelling.
  [[nodiscard]] std::optional<Estimate> estimate() const noexcept;
  /// Covariance of the newest estimate; order and sides as NavState. Zero without an estimate.
  [[nodiscard]] StateMatrix covariance() const noexcept;

  /// Number of keyframes so far: when it changes, `last_update` and the smoother's states are new.
  [[nodiscard]] std::uint64_t updates() const noexcept;
  [[nodiscard]] const UpdateReport& last_update() const noexcept;
  /// For inspection: keyframes, global states, covariances, factor reports. While aligning its map
  /// is `odom`.
  [[nodiscard]] const FixedLagSmoother& smoother() const noexcept;
  [[nodiscard]] EstimatorStatus status() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::estimation
