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

/// From plain measurements, in any order and of any quality, to one state of a vehicle.
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
  kNoConsensus,  ///< the odometers contradict each other: used with `no_consensus_factor`
  kNoData,       ///< extrapolated: not used
};

/// Distance travelled since any zero, forwards positive.
struct OdometerReading {
  double time = 0;
  double distance = 0;  ///< m
  /// m^2, accumulated: errors of increments are independent, so that the variance of an increment
  /// is the difference of two of these.
  double variance = 0;
  OdometerStatus status = OdometerStatus::kGood;
};

/// "Start here": what somebody knows, in the map. Used for a start; ignored while running.
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
  double levelling = 1;  ///< s of IMU readings that gravity is taken from; in [0.1, 60]
  /// What counts as standing still over the levelling: standard deviations of the readings.
  double still_rate = 0.02;  ///< rad/s, in [1e-6, 10]
  double still_force = 0.3;  ///< m/s^2, in [1e-6, 100]
  /// A mean rate above this is a turn, or a bias that no sound gyro has; rad/s, in [1e-6, 1].
  double largest_gyro_bias = 0.02;
  double accelerometer_bias_deviation = 0.1;  ///< m/s^2, in [1e-6, 10]
  double largest_tilt = 0.8;                  ///< rad, of body z from the vertical; in [0.01, pi/2]
  double gravity_tolerance = 0.1;      ///< share that the mean force may differ from gravity by; in
                                       ///< [0.01, 0.5]
  double moving_tilt_deviation = 0.1;  ///< rad, when it does not stand still; in [1e-3, 1]
  double largest_speed = 5;  ///< m/s, a vehicle that does not stand still may have; in [0, 100]
  /// m/s, standard deviation of the velocity of a vehicle that hovers in its place until it is in
  /// the map: that makes its level finer. In {0} (it may go anywhere) or [1e-3, 10].
  double hover_speed = 0;
  double heading_deviation = 0.15;  ///< rad, that a heading from motion needs; in [1e-3, 1]
  std::size_t position_fixes = 5;   ///< GPS positions that must agree first; in [1, 1000]
  double longest_alignment = 120;   ///< s, after which a heading from motion is sought afresh;
                                    ///< in [1, 10000]
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
  double largest_speed = 30;        ///< m/s; more between two readings is a reset of the counter;
                                    ///< in [0.1, 1000]
  double largest_gap = 0.5;         ///< s between readings that are interpolated; in [0.01, 10]
  /// m, in the body: the point whose way is measured, and which keeps to the direction of travel.
  Eigen::Vector3d sensor = Eigen::Vector3d::Zero();
};

struct StandstillUse {
  bool by_odometer = false;      ///< distance unchanged and the gyro quiet
  bool by_imu = false;           ///< gyro and accelerometer quiet: for vehicles that cannot hover
  double window = 0.5;           ///< s for which it must be so; in [0.05, 10]
  double still_distance = 2e-3;  ///< m, in [1e-9, 1]
  double still_rate = 0.01;      ///< rad/s, standard deviation and mean less bias; in [1e-6, 10]
  double still_force = 0.1;      ///< m/s^2, standard deviation; in [1e-6, 100]
  double velocity_deviation = 0.01;  ///< m/s, of the zero velocity; in [1e-6, 10]
  double rate_deviation = 2e-3;      ///< rad/s, of the zero angular rate; in [1e-6, 10]
};

struct StateEstimatorParameters {
  FixedLagSmootherParameters smoother{};
  geometry::SO3 R_body_imu{};       ///< from the axes of the IMU to those of the body
  double specific_force_scale = 1;  ///< what makes m/s^2 of the readings: 9.80665 for an IMU in g;
                                    ///< in [1e-3, 1e3]
  double largest_rate = 40;         ///< rad/s; readings above it are refused; in [0.1, 1e4]
  double largest_force = 400;       ///< m/s^2, the same; in [1, 1e6]
  /// A reading that differs from the one before by more, or by several times more than readings
  /// lately do, is used when the next bears it out.
  double spike_rate = 3;          ///< rad/s, in [0.01, 1e4]
  double spike_force = 15;        ///< m/s^2, in [0.1, 1e6]
  double largest_imu_gap = 0.05;  ///< s between readings that are joined, in [1e-4, 1]
  double keyframe_period = 0.1;   ///< s, in [0.005, 10]
  double imu_silence = 0.3;       ///< s without readings, then it coasts; in [0.01, 10]
  double longest_coasting = 30;   ///< s of it before the state is given up; in [0.1, 1e4]
  double longest_jump = 10;       ///< s, of time: the state goes on, widened; in [0, 1e4]
  StartParameters start{};
  OdometerUse odometer{};
  StandstillUse standstill{};
  SourceWatchParameters gps{};
  SourceWatchParameters visual_pose{.agreeing = 3, .agreeing_time = 0.2, .drift_floor = 0.1};
  SourceWatchParameters heading{.agreeing = 5, .agreeing_time = 1, .drift_floor = 0.1};
  /// Welds are far apart: a few that agree with the way between them are enough.
  SourceWatchParameters weld{.outage = 1000, .doubt_after = 2, .agreeing = 2, .agreeing_time = 0};
  /// Of non-holonomic factors; both 0: none. In {0} or [1e-6, 100].
  double lateral_deviation = 0;   ///< m/s
  double vertical_deviation = 0;  ///< m/s
  /// m of way over which the body slips much the same: there is one such factor in so much, and
  /// none while the body stands; 0: at each keyframe. In [0, 1000].
  double lateral_correlation = 0;
  /// The body keeps to this line, as near as so many m per axis, in [1e-6, 100].
  std::optional<PipeCentreLine> centre_line{};
  double centre_line_deviation = 0.05;
  /// m of way over which its distance from the line stays much the same: the line is used once in
  /// so much, and not while the body stands; 0: at each keyframe. In [0, 1000].
  double centre_line_correlation = 0;
  /// Chainages of all welds on the centre line, m, each above the one before. A weld that is not
  /// where it was said to be has been passed all the same: where just one of these lies within
  /// reach of the state it is taken for that one. Empty: such a weld is not used.
  std::vector<double> tally{};

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;

  /// With odometer, non-holonomic, standing still by odometer.
  [[nodiscard]] static StateEstimatorParameters ground_robot();
  /// Without odometer, hovers.
  [[nodiscard]] static StateEstimatorParameters uav();
  /// In a pipe: odometer, welds, heading along the route; strongly non-holonomic.
  [[nodiscard]] static StateEstimatorParameters crawler();
};

enum class Phase : std::uint8_t {
  kStarting,  ///< no attitude yet
  kAligning,  ///< level, dead reckoning in `odom`; place or heading in the map are unknown
  kRunning,
  kCoasting,  ///< running, but the IMU is silent
  kFault,     ///< gravity shows that the IMU is not mounted as the parameters say; not started
};
/// "starting", "aligning", "running", "coasting", "fault"; "unknown".
[[nodiscard]] std::string_view to_string(Phase phase) noexcept;

enum class WaitsFor : std::uint8_t {
  kNothing,
  kImu,       ///< no readings, or none for long
  kLevel,     ///< `levelling` seconds of readings
  kPlace,     ///< GPS, a visual pose, a weld or a given pose
  kHeading,   ///< a heading, visual pose, weld or given pose, or motion with GPS
  kMounting,  ///< a fault that a parameter mends
};
/// "nothing", "imu", "level", "place", "heading", "mounting"; "unknown".
[[nodiscard]] std::string_view to_string(WaitsFor what) noexcept;

enum class RestartReason : std::uint8_t {
  kNone,
  kTimeJumpForwards,   ///< short enough: goes on from the last state, widened
  kTimeJumpBackwards,  ///< the same
  kNumericalFailure,   ///< the same
  kLost,               ///< a long jump of time or coasting for too long: starts again
  kReacquired,         ///< a source came back within reach of dead reckoning, but not of the state
  kTakenOver,          ///< the state was wrong: moved to where a source has long said it is
};
inline constexpr std::size_t kRestartReasons = 7;
/// "none", "time_jump_forwards", "time_jump_backwards", "numerical_failure", "lost", "reacquired",
/// "taken_over"; "unknown".
[[nodiscard]] std::string_view to_string(RestartReason reason) noexcept;

struct SourceStatus {
  /// IMU, odometer, relative pose and weld: absent or trusted.
  SourceState state = SourceState::kAbsent;
  std::size_t accepted = 0;
  std::size_t gated = 0;  ///< by the consistency gate; of the odometer, by its other readings too
  /// Welds that were gated or held, and used as the one of the tally that was passed.
  std::size_t reassigned = 0;
  std::size_t held = 0;                       ///< not used, for the source was not trusted
  std::size_t refused = 0;                    ///< bad numbers, late, twice, no room, quarantined
  Outcome last_refusal = Outcome::kAccepted;  ///< why the newest of these was
  double last_accepted = std::numeric_limits<double>::quiet_NaN();    ///< s, its time
  double last_chi_square = std::numeric_limits<double>::quiet_NaN();  ///< accepted or gated
};

struct EstimatorStatus {
  Phase phase = Phase::kStarting;
  WaitsFor waits_for = WaitsFor::kImu;
  std::string text{};  ///< what it waits for, or what is wrong and which parameter mends it
  std::array<SourceStatus, kSources> sources{};  ///< by Source
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
  /// Whether `state` is in the map and T_map_odom of use; else `state` is in `odom`.
  bool in_map = false;
  NavState state{};
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();  ///< rad/s, in the body, bias removed
  /// Continuous: corrections reach it as a change of its speed only.
  geometry::SE3 T_odom_body{};
  geometry::SE3 T_map_odom{};  ///< state.T_map_body() * T_odom_body^-1; jumps
};

/// Runs a FixedLagSmoother: start, keyframes, absolute sources that are watched, restarts.
///
/// Driven by the times of measurements alone. A keyframe is added once the IMU covers its time, or
/// once other measurements have gone `imu_silence` beyond the last reading. Measurements may be
/// late by up to the smoother's lag.
///
/// Nothing but the constructor throws. Deterministic. Not thread-safe: one thread at a time.
class StateEstimator {
 public:
  /// Throws as StateEstimatorParameters::validate.
  explicit StateEstimator(const StateEstimatorParameters& parameters);
  ~StateEstimator();
  StateEstimator(StateEstimator&&) noexcept;
  StateEstimator& operator=(StateEstimator&&) noexcept;

  /// kWaiting: taken in, or why it is refused. What becomes of it later is in the status and in
  /// `last_update`.
  Outcome add(const ImuReading& reading) noexcept;
  Outcome add(const OdometerReading& reading) noexcept;
  Outcome add(const GpsMeasurement& m) noexcept;
  Outcome add(const HeadingMeasurement& m) noexcept;
  Outcome add(const VisualPoseMeasurement& m) noexcept;
  Outcome add(const WeldMeasurement& m) noexcept;
  Outcome add(const RelativePoseMeasurement& m) noexcept;
  Outcome add(const GivenPose& pose) noexcept;
  /// Forgets the state, not the counts, and starts again.
  void restart() noexcept;

  /// At the newest IMU reading (or keyframe while coasting); nothing before the levelling.
  [[nodiscard]] std::optional<Estimate> estimate() const noexcept;
  /// Of the newest estimate's state; order and sides as NavState. Zero without an estimate.
  [[nodiscard]] StateMatrix covariance() const noexcept;

  /// Keyframes so far: when it has changed, `last_update` and the smoother's states are new.
  [[nodiscard]] std::uint64_t updates() const noexcept;
  [[nodiscard]] const UpdateReport& last_update() const noexcept;
  /// To look at: keyframes, global states, covariances, factor reports. While aligning its map is
  /// `odom`.
  [[nodiscard]] const FixedLagSmoother& smoother() const noexcept;
  [[nodiscard]] EstimatorStatus status() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::estimation
