// SPDX-License-Identifier: Apache-2.0
// One keyframe: what goes into it, and what is learnt from it.
#include <algorithm>
#include <cmath>

#include "estimator_implementation.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;

constexpr double kSameTime = 1e-4;  // s
constexpr double kGust = 1;         // s: how it hovers now says how it does so soon after

/// No IMU is as wrong as the biases of a state that has gone astray.
bool is_possible(const NavState& state) {
  constexpr double kGyroBias = 2;            // rad/s
  constexpr double kAccelerometerBias = 20;  // m/s^2
  return state.gyro_bias.norm() < kGyroBias && state.accelerometer_bias.norm() < kAccelerometerBias;
}

void note_accepted(SourceStatus& status, const FactorReport& factor) {
  ++status.accepted;
  status.last_accepted = std::isfinite(status.last_accepted)
                             ? std::max(status.last_accepted, factor.time)
                             : factor.time;
  status.last_chi_square = factor.chi_square;
}

std::optional<Source> source_of(FactorKind kind) {
  switch (kind) {
    case FactorKind::kGps:
      return Source::kGps;
    case FactorKind::kHeading:
      return Source::kHeading;
    case FactorKind::kVisualPose:
      return Source::kVisualPose;
    case FactorKind::kWeld:
      return Source::kWeld;
    case FactorKind::kOdometer:
      return Source::kOdometer;
    case FactorKind::kRelativePose:
      return Source::kRelativePose;
    default:
      return std::nullopt;
  }
}

}  // namespace

SourceStatus* StateEstimator::Implementation::status_of(FactorKind kind) noexcept {
  if (const auto source = source_of(kind)) {
    return &status_of(*source);
  }
  return is_own(kind) ? &status_.own_sources[own_index_of(kind)] : nullptr;
}

void StateEstimator::Implementation::keyframe(double time) {
  // What has come up to that time, in the order in which it came; the rest stays.
  const auto feed_due = [&](auto& waiting, auto&& time_of) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < waiting.size(); ++i) {
      if (time_of(waiting[i]) <= time + kSameTime) {
        feed(waiting[i]);
      } else {
        if (kept != i) {
          waiting[kept] = waiting[i];
        }
        ++kept;
      }
    }
    waiting.erase(waiting.begin() + static_cast<std::ptrdiff_t>(kept), waiting.end());
  };
  feed_due(pending_, [](const Pending& pending) { return pending.time; });
  feed_due(own_pending_, [](const AnyFactor& factor) { return factor.to_time(); });
  if (!reckons()) {
    return;
  }
  status_.standing_still = stands_still(time);
  add_own_factors(time);
  window_.next_interval();

  const NavState before = newest_state();
  const FixedLagSmoother::Propagated shown = *smoother_.propagated();
  SE3 pose = odom_.smooth(shown.time, shown.state);
  const Vector3d velocity = SO3::about_z(-odom_.yaw()) * shown.state.velocity;

  report_ = &smoother_.update(time);
  ++updates_;
  status_.imu_gaps.bridged += report_->coasted;
  if (report_->coasted > 0) {
    gps_counted_ = 0;  // nothing tells the motion since the fixes before
  }
  if (report_->reset != ResetReason::kNone || smoother_.keyframes() < 2 ||
      !newest_state().is_finite()) {
    recover(pose);
    return;
  }
  if (!is_possible(newest_state())) {
    lose(RestartReason::kNumericalFailure);
    return;
  }
  odom_.correct(before, smoother_.state(smoother_.keyframes() - 2));
  odom_.record(time, newest_state(), status_.standing_still);
  const FixedLagSmoother::Propagated now = *smoother_.propagated();
  pose = SE3(pose.rotation(), pose.translation() + (now.time - shown.time) * velocity);
  odom_.make_up(now.time, now.state, pose);
  note(*report_);
  good_time_ = time;
  good_state_ = newest_state();
  good_covariance_ = smoother_.covariance(smoother_.keyframes() - 1);
  if (phase_ == Phase::kAligning) {
    align();
    if (phase_ == Phase::kAligning) {
      forget_heading();
    }
  }
}

void StateEstimator::Implementation::add_own_factors(double time) {
  add_odometer(time);
  if (status_.standing_still) {
    // An odometer is late, and tells a motion some way after it has begun.
    const StandstillUse& use = parameters_.standstill;
    const double stood = std::min(odometer_.newest(), time) - 0.5 * use.window;
    smoother_.add(ZeroVelocityMeasurement{use.by_odometer && std::isfinite(stood) ? stood : time,
                                          use.velocity_deviation});
    smoother_.add(ZeroAngularRateMeasurement{time, window_.sums().mean_rate(),
                                             parameters_.standstill.rate_deviation});
  } else if (phase_ == Phase::kAligning && parameters_.start.hover_speed > 0 &&
             !(time - hover_used_ < kGust)) {
    hover_used_ = time;
    smoother_.add(ZeroVelocityMeasurement{time, parameters_.start.hover_speed});
  }
  // How it slips lasts for some way, and is no news before.
  if (parameters_.lateral_deviation > 0 &&
      !(odom_.way() - slip_used_ < parameters_.lateral_correlation)) {
    slip_used_ = odom_.way();
    smoother_.add(NonHolonomicMeasurement{time, parameters_.lateral_deviation,
                                          parameters_.vertical_deviation,
                                          parameters_.odometer.sensor, last_rate_});
  }
  if (parameters_.centre_line && in_map()) {
    add_centre_line(time);
  }
}

void StateEstimator::Implementation::add_odometer(double time) {
  const std::size_t size = smoother_.keyframes();
  std::size_t k = size;
  while (k > 0 && smoother_.time(k - 1) >= odometer_until_ - kSameTime) {
    --k;
  }
  for (; k < size; ++k) {
    const double from = smoother_.time(k);
    const double to = k + 1 < size ? smoother_.time(k + 1) : time;
    if (!(odometer_.newest() >= to)) {
      return;
    }
    odometer_until_ = to;
    if (const auto moved = odometer_.between(from, to)) {
      status_of(Source::kOdometer).gated += moved->left_out;
      const Outcome outcome = smoother_.add(
          OdometerMeasurement{from, to, moved->distance, moved->deviation,
                              parameters_.odometer.across_deviation, parameters_.odometer.sensor});
      if (outcome != Outcome::kWaiting) {
        refuse(Source::kOdometer, outcome);
      }
    } else {
      fault_time_ = to;
    }
  }
}

bool StateEstimator::Implementation::stands_still(double time) const {
  constexpr double kFresh = 0.3;  // s
  const StandstillUse& use = parameters_.standstill;
  const ImuSums sums = window_.sums();
  if (sums.count < 2 || sums.duration < use.window || phase_ == Phase::kCoasting) {
    return false;
  }
  const Vector3d turning = sums.mean_rate() - newest_state().gyro_bias;
  if (sums.rate_deviation() > use.still_rate || turning.norm() > use.still_rate) {
    return false;
  }
  if (wheels_turn(time - use.window, time)) {
    return false;  // on the spot, as slowly as a gyro's bias
  }
  // Those that wait for the IMU tell of a later time.
  const double newest = std::min(odometer_.newest(), time);
  const auto moved = odometer_.between(newest - use.window, newest);
  const bool odometer_there = moved && time - newest < kFresh;
  if (odometer_there && std::abs(moved->distance) > use.still_distance) {
    return false;
  }
  const bool quiet = sums.force_deviation() <= use.still_force;
  // What has stood still since its start, and is not in the map yet, has not taken off.
  const bool at_start = phase_ == Phase::kAligning && still_since_start_;
  return (use.by_odometer && odometer_there) || ((use.by_imu || at_start) && quiet);
}

void StateEstimator::Implementation::add_centre_line(double time) {
  const PipeCentreLine& line = *parameters_.centre_line;
  chainage_ = line.chainage_of(newest_state().position, chainage_);
  const double chainage = chainage_ + line.at(chainage_)->direction.dot(newest_state().velocity) *
                                          (time - newest_time());
  if (std::abs(chainage - centre_line_used_) < parameters_.centre_line_correlation) {
    return;
  }
  if (const auto place = line.at(chainage)) {
    centre_line_used_ = chainage;
    smoother_.add(CentreLineMeasurement{time, place->position, place->direction,
                                        parameters_.centre_line_deviation});
  }
}

void StateEstimator::Implementation::note_own(SourceStatus& status, const FactorReport& factor) {
  switch (factor.outcome) {
    case Outcome::kAccepted:
      note_accepted(status, factor);
      break;
    case Outcome::kGated:
      ++status.gated;
      status.last_chi_square = factor.chi_square;
      break;
    default:
      refuse(status, factor.outcome);
  }
}

void StateEstimator::Implementation::note(const UpdateReport& report) {
  constexpr double kLongest = 1;  // s, that one position stands for
  for (const FactorReport& factor : report.factors) {
    const auto source = source_of(factor.kind);
    if (!source) {
      if (is_own(factor.kind)) {
        note_own(*status_of(factor.kind), factor);
      }
      continue;
    }
    SourceStatus& status = status_of(*source);
    if (factor.kind == FactorKind::kWeld && factor.time == reassigned_time_) {
      // Chosen by the state, it bears out neither the state nor the source.
      status.reassigned += factor.outcome == Outcome::kAccepted ? 1 : 0;
      continue;
    }
    switch (factor.outcome) {
      case Outcome::kAccepted:
        note_accepted(status, factor);
        watch_of(*source).note_misfit(factor.time, factor.chi_square / factor.degrees);
        watch_of(*source).note_accepted(factor.time, odom_.way());
        if (*source == Source::kGps || *source == Source::kVisualPose || *source == Source::kWeld) {
          const double since = std::clamp(factor.time - last_position_, 0.0, kLongest);
          borne_out_ += std::isfinite(last_position_) ? since : 0;
          last_position_ =
              std::isfinite(last_position_) ? std::max(last_position_, factor.time) : factor.time;
        }
        break;
      case Outcome::kGated:
        ++status.gated;
        status.last_chi_square = factor.chi_square;
        watch_of(*source).note_gated();
        watch_of(*source).note_misfit(factor.time, factor.chi_square / factor.degrees);
        contradicted_[index_of(*source)] |= watch_of(*source).state() == SourceState::kDoubted;
        if (*source == Source::kWeld && claimed_weld_ && factor.time == claimed_weld_->time) {
          reassign(*claimed_weld_);
        }
        break;
      default:
        refuse(*source, factor.outcome);
    }
  }
}

void StateEstimator::Implementation::recover(const SE3& pose) {
  // Half a metre, a tenth of a radian and so on: what a single update may have spoilt.
  StateVector spoilt;
  spoilt << Vector3d::Constant(0.5), Vector3d::Constant(0.1), Vector3d::Constant(0.5),
      Vector3d::Constant(0.01), Vector3d::Constant(0.1);
  // What fails twice from the same keyframe always will.
  const bool again = recovered_time_ == good_time_;
  if (again || !good_state_.is_finite() || !good_covariance_.allFinite()) {
    lose(RestartReason::kNumericalFailure);
    return;
  }
  StateMatrix covariance = good_covariance_;
  covariance.diagonal() += spoilt.cwiseAbs2();
  smoother_.initialise(good_time_, good_state_, covariance);
  gps_counted_ = 0;
  odom_.make_up(good_time_, good_state_, pose);
  odometer_until_ = good_time_;
  recovered_time_ = good_time_;
  note_restart(RestartReason::kNumericalFailure, good_time_);
}

void StateEstimator::Implementation::note_restart(RestartReason reason, double time) noexcept {
  ++status_.restarts[static_cast<std::size_t>(reason)];
  status_.last_restart = reason;
  status_.last_restart_time = time;
}

void StateEstimator::Implementation::anchor(double time, const NavState& mean,
                                            const StateMatrix& covariance, RestartReason reason) {
  const FixedLagSmoother::Propagated shown = *smoother_.propagated();
  const SE3 pose = odom_.smooth(shown.time, shown.state);
  const bool moved_in_time = time != newest_time();
  odom_.correct(newest_state(), mean);
  smoother_.restart(time, mean, covariance);
  gps_counted_ = 0;
  if (moved_in_time) {
    odom_.forget_records();
    odom_.record(time, mean, true);
    for (AbsoluteSourceWatch& watch : watches_) {
      watch.distrust(time, odom_.way());
    }
  }
  const FixedLagSmoother::Propagated now = *smoother_.propagated();
  odom_.make_up(now.time, now.state, pose);
  good_time_ = time;
  good_state_ = mean;
  good_covariance_ = covariance;
  odometer_until_ = std::max(odometer_until_, time);
  if (reason != RestartReason::kNone) {
    note_restart(reason, time);
  }
}

void StateEstimator::Implementation::lose(RestartReason reason) noexcept {
  if (reckons() && smoother_.initialised()) {
    const FixedLagSmoother::Propagated shown = *smoother_.propagated();
    if (shown.state.is_finite()) {
      last_odom_ = odom_.smooth(shown.time, shown.state);
      odom_ended_ = shown.time;
      if (shown.time > newest_time()) {
        odom_.record(shown.time, shown.state, status_.standing_still);
      }
    }
  }
  if (reason != RestartReason::kNone) {
    note_restart(reason, imu_end_);
    odom_ended_ = std::numeric_limits<double>::quiet_NaN();
  }
  phase_ = Phase::kStarting;
  recovered_time_ = std::numeric_limits<double>::quiet_NaN();
  fault_.clear();
  status_.standing_still = false;
  levelling_ = {};
  pending_.clear();
  own_pending_.clear();
  in_motion_.end();
  given_.reset();
  given_fault_ = nullptr;
  seen_place_.reset();
  seen_yaw_.reset();
  passed_place_.reset();
  passed_yaw_.reset();
  centre_line_used_ = std::numeric_limits<double>::quiet_NaN();
  slip_used_ = std::numeric_limits<double>::quiet_NaN();
  hover_used_ = std::numeric_limits<double>::quiet_NaN();
  claimed_weld_.reset();
  reassigned_time_ = std::numeric_limits<double>::quiet_NaN();
  contradicted_ = {};
  borne_out_ = 0;
  gps_counted_ = 0;
  last_position_ = std::numeric_limits<double>::quiet_NaN();
  for (AbsoluteSourceWatch& watch : watches_) {
    watch.distrust(imu_end_, odom_.way());
  }
}

}  // namespace pipescout::estimation
