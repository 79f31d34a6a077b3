// SPDX-License-Identifier: Apache-2.0
// What comes in, and what drives the keyframes.
#include <algorithm>
#include <cmath>
#include <exception>

#include "estimator_implementation.hpp"

namespace pipescout::estimation {
namespace {

constexpr std::size_t kWaitingSources = 5;  // all but the IMU and the odometer
/// Longest step of the clock of all sensors but the IMU, s: one of them may be slow.
constexpr double kOthersStep = 2.5;

double time_of(const RelativePoseMeasurement& m) {
  return m.to_time;
}
template <class Measurement>
double time_of(const Measurement& m) {
  return m.time;
}

std::size_t intervals(double duration, double period) {
  return static_cast<std::size_t>(std::ceil(duration / period));
}

}  // namespace

StateEstimator::Implementation::Implementation(const StateEstimatorParameters& parameters)
    : parameters_(parameters),
      smoother_(parameters.smoother),
      report_(&no_report_),
      imu_(parameters),
      window_(intervals(parameters.standstill.window, parameters.keyframe_period) + 1),
      turns_(parameters.keyframe_period,
             intervals(parameters.standstill.window + parameters.longest_wait +
                           parameters.smoother.max_step,
                       parameters.keyframe_period)),
      in_motion_(parameters.smoother.imu_integration(), parameters.smoother.max_imu_samples),
      odometer_(parameters.odometer),
      odom_(intervals(parameters.smoother.lag, parameters.keyframe_period) + 2),
      watches_{AbsoluteSourceWatch({}),
               AbsoluteSourceWatch({}),
               AbsoluteSourceWatch({}),
               AbsoluteSourceWatch(parameters.gps),
               AbsoluteSourceWatch(parameters.visual_pose),
               AbsoluteSourceWatch(parameters.heading),
               AbsoluteSourceWatch(parameters.weld)},
      others_(kOthersStep) {
  pending_.reserve(kWaitingSources * kMostWaiting);
  own_pending_.reserve(parameters.own_sources.size() * kMostWaiting);
  if (parameters.centre_line) {
    chainage_ = parameters.centre_line->first_chainage();
  }
}

Outcome StateEstimator::Implementation::refuse(SourceStatus& status, Outcome outcome) noexcept {
  ++status.refused;
  status.last_refusal = outcome;
  return outcome;
}

Outcome StateEstimator::Implementation::add(const ImuReading& reading) noexcept {
  try {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    const ImuIntake::Taken taken = imu_.add(reading, others_jumped_ ? kNan : others_.newest());
    if (taken.gap > 0) {
      ImuGaps& gaps = status_.imu_gaps;
      ++gaps.count;
      gaps.total += taken.gap;
      gaps.longest = std::max(gaps.longest, taken.gap);
    }
    if (taken.jumped) {
      if (taken.gap > 0) {
        bridge(reading.time);
      } else {
        others_.forget();
        imu_lag_ = 0;
        jump(reading.time);
      }
    }
    for (std::size_t i = 0; i < taken.count; ++i) {
      take(taken.samples[i]);
    }
    if (taken.outcome == Outcome::kWaiting) {
      note_lag(reading);
    }
    if (taken.outcome == Outcome::kGated || taken.outcome == Outcome::kNotFinite ||
        taken.outcome == Outcome::kDead) {
      fault_time_ = imu_end_;
    }
    if (taken.outcome != Outcome::kWaiting) {
      return refuse(Source::kImu, taken.outcome);
    }
    SourceStatus& status = status_of(Source::kImu);
    ++status.accepted;
    status.last_accepted = reading.time;
    return Outcome::kWaiting;
  } catch (const std::exception&) {
    lose(RestartReason::kNumericalFailure);
    return refuse(Source::kImu, Outcome::kQuarantined);
  }
}

void StateEstimator::Implementation::take(const ImuSample& sample) {
  imu_end_ = sample.time + sample.duration;
  last_rate_ = sample.angular_rate;
  if (!reckons()) {
    gather(sample);
    return;
  }
  advance(sample.time);  // over what is missing before it
  if (!reckons()) {
    return;
  }
  if (phase_ == Phase::kCoasting && imu_end_ > newest_time()) {
    phase_ = Phase::kRunning;
  }
  window_.add(sample);
  if (in_motion_.begun()) {
    in_motion_.add(sample);
  }
  smoother_.add(sample);
  advance(imu_end_);
}

void StateEstimator::Implementation::advance(double until) {
  constexpr double kCovered = 1e-6;
  while (reckons() && until >= newest_time() + parameters_.keyframe_period - kCovered) {
    keyframe(newest_time() + parameters_.keyframe_period);
  }
}

void StateEstimator::Implementation::note_lag(const ImuReading& reading) noexcept {
  // What has come so late may do so again for some time.
  constexpr double kRemembered = 10;  // s, time constant
  const double elapsed = others_.newest() - others_at_imu_;
  others_at_imu_ = others_.newest();
  others_jumped_ = false;
  const double lag = others_.newest() - reading.time;
  if (!std::isfinite(lag)) {
    return;
  }
  imu_lag_ *= elapsed > 0 ? std::exp(-elapsed / kRemembered) : 1;
  imu_lag_ = std::clamp(lag, imu_lag_, std::max(imu_lag_, parameters_.longest_wait));
}

Outcome StateEstimator::Implementation::check_time(double time) noexcept {
  switch (others_.judge(time)) {
    case ClockWatch::Step::kNext:
    case ClockWatch::Step::kLate:
    case ClockWatch::Step::kDuplicate:
      break;
    case ClockWatch::Step::kSuspicious:
      return time > others_.newest() ? Outcome::kFuture : Outcome::kLate;
    case ClockWatch::Step::kJump:
      others_at_imu_ = time;
      others_jumped_ = true;
      break;
  }
  if (std::isnan(others_at_imu_)) {
    others_at_imu_ = others_.newest();
  }
  if (!reckons()) {
    return Outcome::kUninitialised;
  }
  return newest_time() - time > parameters_.smoother.lag ? Outcome::kLate : Outcome::kWaiting;
}

Outcome StateEstimator::Implementation::add(const OdometerReading& reading) noexcept {
  if (!std::isfinite(reading.time)) {
    return refuse(Source::kOdometer, Outcome::kNotFinite);
  }
  const Outcome in_time = check_time(reading.time);
  if (in_time != Outcome::kWaiting && in_time != Outcome::kUninitialised) {
    return refuse(Source::kOdometer, in_time);
  }
  if (reckons() && odometer_.is_full_after(odometer_until_)) {
    return refuse(Source::kOdometer, Outcome::kFull);
  }
  const Outcome outcome = odometer_.add(reading);
  if (outcome != Outcome::kWaiting) {
    return refuse(Source::kOdometer, outcome);
  }
  coast();
  return outcome;
}

Outcome StateEstimator::Implementation::add(const WheelTurn& turn) noexcept {
  if (!std::isfinite(turn.time) || !std::isfinite(turn.yaw_rate)) {
    return Outcome::kNotFinite;
  }
  const Outcome in_time = check_time(turn.time);
  if (in_time != Outcome::kWaiting && in_time != Outcome::kUninitialised) {
    return in_time;
  }
  turns_.add(turn.time, turn.yaw_rate);
  return Outcome::kAccepted;
}

template <class Measurement>
Outcome StateEstimator::Implementation::add_measurement(const Measurement& m) noexcept {
  const Source source = source_of(m);
  const InputFault fault = check(m);
  if (fault != InputFault::kNone) {
    return refuse(source, outcome_of(fault, Outcome::kWaiting));
  }
  const Outcome in_time = check_time(time_of(m));
  if (in_time == Outcome::kUninitialised) {
    ++status_of(source).held;
    return in_time;
  }
  if (in_time != Outcome::kWaiting) {
    return refuse(source, in_time);
  }
  if (waiting(source) >= kMostWaiting) {
    return refuse(source, Outcome::kFull);
  }
  pending_.push_back({time_of(m), m});
  coast();
  return Outcome::kWaiting;
}

template Outcome StateEstimator::Implementation::add_measurement(const GpsMeasurement&) noexcept;
template Outcome StateEstimator::Implementation::add_measurement(
    const HeadingMeasurement&) noexcept;
template Outcome StateEstimator::Implementation::add_measurement(
    const VisualPoseMeasurement&) noexcept;
template Outcome StateEstimator::Implementation::add_measurement(const WeldMeasurement&) noexcept;
template Outcome StateEstimator::Implementation::add_measurement(
    const RelativePoseMeasurement&) noexcept;

Outcome StateEstimator::Implementation::add(const GivenPose& pose) noexcept {
  const auto within = [](double value, double low, double high) {
    return value >= low && value <= high;
  };
  if (!std::isfinite(pose.time) || (pose.position && !pose.position->allFinite()) ||
      (pose.heading && !std::isfinite(*pose.heading))) {
    return Outcome::kNotFinite;
  }
  if ((pose.position && !within(pose.position_deviation, 1e-3, 1e4)) ||
      (pose.heading && !within(pose.heading_deviation, 1e-4, 1))) {
    return Outcome::kBadCovariance;
  }
  if (in_map()) {
    return Outcome::kWaiting;
  }
  try {
    given_ = Given{.pose = pose};
    given_fault_ = nullptr;
    if (reckons()) {
      place_given();
    } else if (last_odom_ && pose.time >= odom_.begins() && pose.time <= odom_ended_) {
      const geometry::SE3 since =
          odom_.at(odom_ended_).T_odom_body.inverse() * odom_.at(pose.time).T_odom_body;
      given_->T_odom_body = *last_odom_ * since;
    }
    return Outcome::kWaiting;
  } catch (const std::exception&) {
    given_.reset();
    return Outcome::kQuarantined;
  }
}

Outcome StateEstimator::Implementation::add(const AnyFactor& factor) noexcept {
  const FactorKind kind = factor.kind();
  if (!is_own(kind) || own_index_of(kind) >= parameters_.own_sources.size()) {
    return Outcome::kUninitialised;
  }
  SourceStatus& status = *status_of(kind);
  const InputFault fault = factor.fault();
  if (fault != InputFault::kNone) {
    return refuse(status, outcome_of(fault, Outcome::kWaiting));
  }
  const Outcome in_time = check_time(factor.to_time());
  if (in_time == Outcome::kUninitialised) {
    ++status.held;
    return in_time;
  }
  if (in_time != Outcome::kWaiting) {
    return refuse(status, in_time);
  }
  const auto waiting = std::ranges::count(own_pending_, kind, &AnyFactor::kind);
  if (static_cast<std::size_t>(waiting) >= kMostWaiting) {
    return refuse(status, Outcome::kFull);
  }
  own_pending_.push_back(factor);
  coast();
  return Outcome::kWaiting;
}

std::size_t StateEstimator::Implementation::waiting(Source source) const noexcept {
  if (source == Source::kOdometer) {
    return reckons() ? odometer_.after(newest_time()) : 0;
  }
  return static_cast<std::size_t>(std::ranges::count_if(pending_, [&](const Pending& pending) {
    return std::visit([](const auto& m) { return source_of(m); }, pending.measurement) == source;
  }));
}

void StateEstimator::Implementation::coast() {
  if (!reckons()) {
    return;
  }
  const double now = others_.newest();
  const bool silent = now - others_at_imu_ > parameters_.imu_silence;
  // A late IMU may still come for what is not longer ago than it has been late.
  const double until = now - (silent ? imu_lag_ : parameters_.longest_wait);
  const bool aligning = phase_ == Phase::kAligning;
  try {
    if (silent) {
      const double longest =
          aligning ? parameters_.smoother.max_step : parameters_.longest_coasting;
      if (until - imu_end_ > longest) {
        lose(RestartReason::kLost);
        return;
      }
    }
    if (aligning || !(until >= newest_time() + parameters_.keyframe_period)) {
      return;
    }
    phase_ = Phase::kCoasting;
    fault_time_ = now;
    advance(until);
  } catch (const std::exception&) {
    lose(RestartReason::kNumericalFailure);
  }
}

void StateEstimator::Implementation::bridge(double until) {
  if (phase_ == Phase::kAligning) {
    lose(RestartReason::kLost);
    return;
  }
  fault_time_ = until;
  advance(until);
}

void StateEstimator::Implementation::jump(double time) {
  levelling_ = {};
  trail_.forget();
  odom_ended_ = std::numeric_limits<double>::quiet_NaN();
  turns_.forget();
  if (!reckons()) {
    odometer_.forget();
    return;
  }
  const double step = time - newest_time();
  if (step > 0 && step <= parameters_.smoother.max_step) {
    return;  // keyframes have gone on without the IMU
  }
  odometer_.forget();
  if (std::abs(step) > parameters_.longest_jump || phase_ == Phase::kAligning) {
    lose(RestartReason::kLost);
    return;
  }
  pending_.clear();
  own_pending_.clear();
  window_.forget();
  odometer_until_ = time;
  last_position_ = std::min(last_position_, time);
  const FixedLagSmootherParameters& p = parameters_.smoother;
  const NavState mean = newest_state();
  const double elapsed = std::abs(step);
  const double turned = p.coasting_angular_rate * p.coasting_angular_rate * elapsed;
  const double gained = p.coasting_acceleration * p.coasting_acceleration * elapsed;
  StateMatrix covariance = smoother_.covariance(smoother_.keyframes() - 1);
  covariance.diagonal().segment<3>(kPosition).array() +=
      elapsed * elapsed * (mean.velocity.squaredNorm() + gained);
  covariance.diagonal().segment<3>(kRotation).array() += turned;
  covariance.diagonal().segment<3>(kVelocity).array() += gained + mean.velocity.squaredNorm();
  anchor(time, mean, covariance,
         step > 0 ? RestartReason::kTimeJumpForwards : RestartReason::kTimeJumpBackwards);
}

void StateEstimator::Implementation::restart() noexcept {
  lose(RestartReason::kNone);
}

}  // namespace pipescout::estimation
