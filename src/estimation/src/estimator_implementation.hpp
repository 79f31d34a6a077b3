// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "clock_watch.hpp"
#include "imu_intake.hpp"
#include "imu_window.hpp"
#include "odom_frame.hpp"
#include "odometer_intake.hpp"
#include "pipescout/estimation/in_motion_alignment.hpp"
#include "pipescout/estimation/state_estimator.hpp"
#include "start_trail.hpp"
#include "turn_window.hpp"

namespace pipescout::estimation {

/// Place of a source in arrays over all of them.
[[nodiscard]] constexpr std::size_t index_of(Source source) {
  return static_cast<std::size_t>(source);
}
[[nodiscard]] constexpr Source source_of(const GpsMeasurement&) {
  return Source::kGps;
}
[[nodiscard]] constexpr Source source_of(const HeadingMeasurement&) {
  return Source::kHeading;
}
[[nodiscard]] constexpr Source source_of(const VisualPoseMeasurement&) {
  return Source::kVisualPose;
}
[[nodiscard]] constexpr Source source_of(const WeldMeasurement&) {
  return Source::kWeld;
}
[[nodiscard]] constexpr Source source_of(const RelativePoseMeasurement&) {
  return Source::kRelativePose;
}

/// Place of a kind in `own_sources`.
[[nodiscard]] constexpr std::size_t own_index_of(FactorKind kind) {
  return static_cast<std::size_t>(kind) - static_cast<std::size_t>(FactorKind::kOwn);
}
[[nodiscard]] constexpr bool is_own(FactorKind kind) {
  return kind >= FactorKind::kOwn && own_index_of(kind) < kOwnFactorKinds;
}

[[nodiscard]] inline double yaw_of(const geometry::SO3& rotation) noexcept {
  return rotation.roll_pitch_yaw().z();
}

class StateEstimator::Implementation {
 public:
  explicit Implementation(const StateEstimatorParameters& parameters);

  // estimator_input.cpp
  Outcome add(const ImuReading& reading) noexcept;
  Outcome add(const OdometerReading& reading) noexcept;
  Outcome add(const WheelTurn& turn) noexcept;
  Outcome add(const GivenPose& pose) noexcept;
  Outcome add(const AnyFactor& factor) noexcept;
  template <class Measurement>
  Outcome add_measurement(const Measurement& m) noexcept;
  void restart() noexcept;
  void set_earth(const Earth& earth) { smoother_.set_earth(earth); }

  // estimator_output.cpp
  [[nodiscard]] std::optional<Estimate> estimate() const noexcept;
  [[nodiscard]] StateMatrix covariance() const noexcept;
  [[nodiscard]] EstimatorStatus status() const;
  [[nodiscard]] CorrelationFinding correlation_of(Source source) const noexcept {
    const bool is_watched = source == Source::kGps || source == Source::kVisualPose;
    return is_watched ? watch_of(source).correlation() : CorrelationFinding{};
  }
  [[nodiscard]] std::uint64_t updates() const noexcept { return updates_; }
  [[nodiscard]] const UpdateReport& last_update() const noexcept { return *report_; }
  [[nodiscard]] const FixedLagSmoother& smoother() const noexcept { return smoother_; }

 private:
  struct Pending {
    double time = 0;
    std::variant<GpsMeasurement, HeadingMeasurement, VisualPoseMeasurement, WeldMeasurement,
                 RelativePoseMeasurement>
        measurement{};
  };
  /// Where the body is to be in the map.
  struct Placement {
    double yaw = 0;  // map from odom, about z
    double yaw_deviation = 0;
    Eigen::Vector3d offset = Eigen::Vector3d::Zero();  // map = Rz(yaw) odom + offset
    double offset_deviation = 0;
    Eigen::Vector3d drift = Eigen::Vector3d::Zero();  // of the velocity
    double drift_deviation = 0;
  };
  struct Angle {
    double value = 0;
    double deviation = 0;
  };
  struct Point {
    Eigen::Vector3d measured = Eigen::Vector3d::Zero();  // in the map
    Eigen::Vector3d reckoned = Eigen::Vector3d::Zero();  // in odom
    double deviation = 0;
    bool has_height = true;
  };

  struct Given {
    GivenPose pose{};
    /// Where the body was at its time; its deviations are part of those of the pose.
    std::optional<geometry::SE3> T_odom_body{};
  };

  /// Whether the odometer tells how the body moves.
  [[nodiscard]] bool has_odometer(double time) const noexcept {
    constexpr double kWitnessAge = 1;  // s, of the newest reading
    return time - odometer_.newest() < kWitnessAge;
  }
  /// Whether the wheels say that the body turns; not where they say nothing.
  [[nodiscard]] bool wheels_turn(double from, double to) const noexcept {
    return std::abs(turns_.mean(from, to)) > parameters_.standstill.wheel_rate;
  }
  [[nodiscard]] bool reckons() const noexcept {
    return phase_ != Phase::kStarting && phase_ != Phase::kFault;
  }
  [[nodiscard]] bool in_map() const noexcept {
    return phase_ == Phase::kRunning || phase_ == Phase::kCoasting;
  }
  [[nodiscard]] double newest_time() const noexcept {
    return smoother_.time(smoother_.keyframes() - 1);
  }
  [[nodiscard]] const NavState& newest_state() const noexcept {
    return smoother_.state(smoother_.keyframes() - 1);
  }
  [[nodiscard]] SourceStatus& status_of(Source source) noexcept {
    return status_.sources[index_of(source)];
  }
  /// Of a source or an own source, by the kind of its factors; null: of neither.
  [[nodiscard]] SourceStatus* status_of(FactorKind kind) noexcept;
  /// By Source; those of sources that are not watched are not used.
  [[nodiscard]] AbsoluteSourceWatch& watch_of(Source source) noexcept {
    return watches_[index_of(source)];
  }
  [[nodiscard]] const AbsoluteSourceWatch& watch_of(Source source) const noexcept {
    return watches_[index_of(source)];
  }

  // estimator_input.cpp
  Outcome refuse(Source source, Outcome outcome) noexcept {
    return refuse(status_of(source), outcome);
  }
  static Outcome refuse(SourceStatus& status, Outcome outcome) noexcept;
  /// kWaiting, or why a measurement of that time cannot be.
  [[nodiscard]] Outcome check_time(double time) noexcept;
  void take(const ImuSample& sample);
  /// How far behind the others the IMU is, from a reading of it.
  void note_lag(const ImuReading& reading) noexcept;
  /// Adds keyframes up to a time.
  void advance(double until);
  void coast();
  void jump(double time);
  /// Readings of the IMU are missing up to a time.
  void bridge(double until);
  [[nodiscard]] std::size_t waiting(Source source) const noexcept;

  // estimator_start.cpp
  void gather(const ImuSample& sample);
  /// What is wrong with gravity, in words; empty when nothing is.
  [[nodiscard]] std::string fault_of(const Eigen::Vector3d& mean_force, bool still) const;
  /// How the odometer says that it moves at the end of the levelling.
  [[nodiscard]] std::optional<OdometerIntake::Motion> motion_at(double time) const noexcept;
  void begin_reckoning(double time, bool still);
  /// What it may be doing; `seeming` is what the smoother begins with.
  void begin_in_motion(double time, const NavState& seeming, const StateVector& deviations,
                       bool still);
  void align();
  /// Whether the state is in the map now, from GPS and IMU.
  [[nodiscard]] bool align_in_motion();
  /// The state is in the map.
  void run();
  /// Before it is in the map, place and heading are in axes of no meaning. An uncertain heading
  /// turns the velocity and all that is known with it by angles for which nothing is linear any
  /// more: then the axes become those in which the body is where it is and heads where it heads.
  void forget_heading();
  void level_again() noexcept;
  /// Puts the trail of the levelling where odom ended before. Where odom goes on after it.
  [[nodiscard]] geometry::SE3 continue_odom();
  /// Looks where in odom the body was at the time of the given pose, unless that is known, or that
  /// time is still to come.
  void place_given();
  /// By standard deviations, m and rad.
  void widen_given(double position, double heading);
  void give_up_given(const char* why) noexcept;
  [[nodiscard]] std::optional<Angle> start_yaw() const;
  [[nodiscard]] std::optional<Placement> start_place(const Angle& yaw) const;

  // estimator_keyframe.cpp
  void keyframe(double time);
  void add_own_factors(double time);
  void add_odometer(double time);
  [[nodiscard]] bool stands_still(double time) const;
  void add_centre_line(double time);
  /// Of a weld that is not where it was said to be: takes it for the one of the tally that lies
  /// where the state has its sensor, if there is just one.
  void reassign(const WeldMeasurement& m);
  void note(const UpdateReport& report);
  static void note_own(SourceStatus& status, const FactorReport& factor);
  /// After a failed update: from the last sound keyframe, with odom going on at `pose`.
  void recover(const geometry::SE3& pose);
  /// Goes on from this; the body stays where it is in odom.
  void anchor(double time, const NavState& mean, const StateMatrix& covariance,
              RestartReason reason);
  void note_restart(RestartReason reason, double time) noexcept;
  /// Starts again.
  void lose(RestartReason reason) noexcept;

  // estimator_sources.cpp
  void feed(const Pending& pending);
  void feed(const AnyFactor& factor);
  template <class Measurement>
  void use(Measurement m) noexcept;
  /// Of an absolute measurement that is about to be used, see SourceWatchParameters.
  [[nodiscard]] double covariance_factor_of(Source source, double time) noexcept;
  /// The same of a fix. However alike the errors of fixes are, one alone tells the place as well as
  /// it states: a state that is less sure (variance P, the fix's R) becomes as sure as the fix by
  /// the factor P / (P - R). All that count so are worth one fix in all, beside the share that each
  /// has by its correlation time: whatever tells the motion between them later makes them one mean.
  /// Not those that come together: each would be used so.
  [[nodiscard]] double covariance_factor_of(const GpsMeasurement& m);
  /// Of a fix `spacing` s after the one before, whose covariance counts by this factor: by which
  /// its height counts in addition, see SourceWatchParameters::height_correlation_time.
  [[nodiscard]] double height_factor_of(const GpsMeasurement& m, double factor,
                                        double spacing) const;
  [[nodiscard]] Point point_of(const GpsMeasurement& m) const;
  [[nodiscard]] Point point_of(const VisualPoseMeasurement& m) const;
  [[nodiscard]] WatchedFix fix_of(double time, const Point& point,
                                  double prediction_variance) const;
  [[nodiscard]] WatchedFix fix_of(const GpsMeasurement& m) const;
  [[nodiscard]] WatchedFix fix_of(const HeadingMeasurement& m) const;
  [[nodiscard]] WatchedFix fix_of(const VisualPoseMeasurement& m) const;
  [[nodiscard]] WatchedFix fix_of(const WeldMeasurement& m) const;
  /// Of the start of a vehicle without odometer.
  void hear_in_motion(GpsMeasurement m);
  /// Of positions: the watch learns from it if it is accepted.
  template <class Measurement>
  void offer(const Measurement& m) noexcept;
  template <class Measurement>
  void judge(const Measurement& m);
  void see(const GpsMeasurement& /*m*/, const WatchedFix& /*fix*/) noexcept {}
  void see(const HeadingMeasurement& /*m*/, const WatchedFix& /*fix*/) noexcept {}
  void see(const VisualPoseMeasurement& m, const WatchedFix& fix);
  void see(const WeldMeasurement& m, const WatchedFix& fix);
  void widen(const WatchedFix& fix, const AbsoluteSourceWatch& watch);
  /// Turns the state about the vertical.
  void turn(const Angle& by, RestartReason reason);
  /// Whether the state has been moved.
  [[nodiscard]] bool take_over(Source source, const WatchedFix& fix);
  [[nodiscard]] std::optional<Placement> placement_of(const TrackAlignment& track) const;
  void place(const Placement& placement, RestartReason reason);
  [[nodiscard]] bool another_agrees(Source source) const;
  [[nodiscard]] bool contested(Source source, double time) const;

  StateEstimatorParameters parameters_;
  FixedLagSmoother smoother_;
  const UpdateReport* report_;
  UpdateReport no_report_{};
  ImuIntake imu_;
  ImuWindow window_;
  TurnWindow turns_;
  InMotionAlignment in_motion_;
  OdometerIntake odometer_;
  OdomFrame odom_;
  std::array<AbsoluteSourceWatch, kSources> watches_;
  std::array<bool, kSources> contradicted_{};  // since it was last accepted
  std::vector<Pending> pending_{};
  std::vector<AnyFactor> own_pending_{};
  ClockWatch others_;  // of all sensors but the IMU
  double others_at_imu_ = std::numeric_limits<double>::quiet_NaN();
  bool others_jumped_ = false;  // since the last reading of the IMU
  double imu_lag_ = 0;          // s, behind the others: largest lately
  double imu_end_ = 0;          // of the newest sample
  double fault_time_ = -std::numeric_limits<double>::infinity();  // IMU, odometer
  std::uint64_t gps_used_at_ = 0;  // number of the update that the newest fix goes into
  // What the state knows of errors that fixes have in common, in fixes: 1, as sure as one of them.
  double gps_counted_ = 0;
  std::array<double, kSources> last_used_{};  // s, times of absolute measurements
  std::array<double, kOwnFactorKinds> own_last_used_{};
  Eigen::Vector3d last_rate_ = Eigen::Vector3d::Zero();

  Phase phase_ = Phase::kStarting;
  std::string fault_{};
  EstimatorStatus status_{};  // but for what is made up when it is asked for
  std::uint64_t updates_ = 0;
  ImuSums levelling_{};
  double levelling_end_ = 0;
  double reckons_since_ = 0;
  bool still_since_start_ = false;
  bool seems_still_ = false;  // at its start, by an IMU that feels the same on a straight flight
  // Of the start in motion: a position has come; positions contradict it; what is known by now.
  bool told_in_motion_ = false;
  bool contradicted_in_motion_ = false;
  double heading_deviation_ = std::numeric_limits<double>::quiet_NaN();
  std::optional<Given> given_{};
  const char* given_fault_ = nullptr;  // why a given pose is not used
  StartTrail trail_{};
  // s, where odom ended when a restart was asked for; NaN: it did not, or is of another time.
  double odom_ended_ = std::numeric_limits<double>::quiet_NaN();
  bool height_is_known_ = false;  // that of the map: some position had one
  // While aligning: by the newest visual pose, and by the newest weld.
  std::optional<Point> seen_place_{};
  std::optional<Angle> seen_yaw_{};
  std::optional<Point> passed_place_{};
  std::optional<Angle> passed_yaw_{};
  std::optional<geometry::SE3> last_odom_{};  // where odom goes on after a new start
  double odometer_until_ = 0;                 // increments up to it are in the smoother
  double chainage_ = 0;                       // of the body on the centre line
  // Where the centre line was used last; NaN: nowhere.
  double centre_line_used_ = std::numeric_limits<double>::quiet_NaN();
  // m, way after which a non-holonomic factor was used last; NaN: none was.
  double slip_used_ = std::numeric_limits<double>::quiet_NaN();
  // s, of the newest keyframe that was said to hover; NaN: none was.
  double hover_used_ = std::numeric_limits<double>::quiet_NaN();
  std::optional<WeldMeasurement> claimed_weld_{};  // the newest that the smoother was given
  // s, of the newest that was taken for another one; NaN: none.
  double reassigned_time_ = std::numeric_limits<double>::quiet_NaN();
  double last_position_ = std::numeric_limits<double>::quiet_NaN();  // s, accepted
  double borne_out_ = 0;  // s with accepted positions since the state was placed
  double good_time_ = 0;  // of the newest sound keyframe
  // s, of the one from which the newest recovery began; NaN: none was, or all began again since.
  double recovered_time_ = std::numeric_limits<double>::quiet_NaN();
  NavState good_state_{};
  StateMatrix good_covariance_ = StateMatrix::Zero();
};

}  // namespace pipescout::estimation
