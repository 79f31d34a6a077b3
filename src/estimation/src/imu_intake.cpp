// SPDX-License-Identifier: Apache-2.0
#include "imu_intake.hpp"

#include <algorithm>

namespace pipescout::estimation {
namespace {

constexpr double kFirstStep = 0.02;      // of a spike, until it is known
constexpr double kLeastStep = 1e-4;      // of a spike: the mean must be able to grow again
constexpr std::size_t kMostDropped = 8;  // then it is the motion that is violent

}  // namespace

ImuIntake::ImuIntake(const StateEstimatorParameters& parameters)
    : R_body_imu_(parameters.R_body_imu),
      scale_(parameters.specific_force_scale),
      largest_rate_(parameters.largest_rate),
      largest_force_(parameters.largest_force),
      spike_rate_(parameters.spike_rate),
      spike_force_(parameters.spike_force),
      rate_step_(kFirstStep * parameters.spike_rate),
      force_step_(kFirstStep * parameters.spike_force),
      largest_gap_(parameters.largest_imu_gap),
      clock_(parameters.smoother.max_step) {}

void ImuIntake::forget() noexcept {
  clock_.forget();
  last_.reset();
  held_.reset();
  dropped_ = 0;
}

bool ImuIntake::near(const ImuReading& a, const ImuReading& b) const noexcept {
  // So many times the mean step from reading to reading; of white noise 12 standard deviations.
  constexpr double kSteps = 5;
  constexpr double kLeastRate = 0.05;  // rad/s
  constexpr double kLeastForce = 0.5;  // m/s^2
  constexpr double kYielding = 1.3;    // for each reading that was dropped
  // What a vehicle that turns in or brakes does between two readings of a slow IMU; at 100 Hz it is
  // the least above.
  constexpr double kAngularAcceleration = 5;  // rad/s^2
  constexpr double kJerk = 50;                // m/s^3
  const double elapsed = std::abs(b.time - a.time);
  const double least_rate =
      std::min(std::max(kLeastRate, kAngularAcceleration * elapsed), spike_rate_);
  const double least_force = std::min(std::max(kLeastForce, kJerk * elapsed), spike_force_);
  const double steps = kSteps * std::pow(kYielding, static_cast<double>(dropped_));
  return (a.angular_rate - b.angular_rate).norm() <=
             std::clamp(steps * rate_step_, least_rate, spike_rate_) &&
         (a.specific_force - b.specific_force).norm() <=
             std::clamp(steps * force_step_, least_force, spike_force_);
}

void ImuIntake::join(const ImuReading& to, Taken& taken) noexcept {
  constexpr double kLearning = 0.02;
  constexpr double kMost = 3;  // times the mean: what is not much of a step may still be wrong
  const double duration = to.time - last_->time;
  if (duration > largest_gap_) {
    taken.gap = duration;
  } else {
    taken.samples[taken.count++] = {last_->time, duration,
                                    0.5 * (last_->angular_rate + to.angular_rate),
                                    0.5 * (last_->specific_force + to.specific_force)};
  }
  const double rate_step = (to.angular_rate - last_->angular_rate).norm();
  const double force_step = (to.specific_force - last_->specific_force).norm();
  rate_step_ += kLearning * (std::min(rate_step, kMost * rate_step_) - rate_step_);
  force_step_ += kLearning * (std::min(force_step, kMost * force_step_) - force_step_);
  rate_step_ = std::max(rate_step_, kLeastStep * spike_rate_);
  force_step_ = std::max(force_step_, kLeastStep * spike_force_);
  last_ = to;
}

void ImuIntake::begin(const ImuReading& now, Taken& taken) noexcept {
  if (!held_) {
    held_ = now;
    return;
  }
  if (!near(*held_, now) && dropped_ < kMostDropped) {
    ++dropped_;
    taken.outcome = Outcome::kGated;
    held_ = now;
    return;
  }
  last_ = held_;
  held_.reset();
  dropped_ = 0;
  join(now, taken);
}

bool ImuIntake::is_gap(double from, double to, double others) noexcept {
  constexpr double kShare = 0.5;  // of the step: a sensor may be slow, and late
  return to > from && others - from > kShare * (to - from);
}

bool ImuIntake::is_dead(const ImuReading& reading) noexcept {
  // Noise changes some digit of each reading. Drivers that publish faster than the sensor measures
  // repeat readings too, but for a shorter time, and a gyro of one axis has zeros in the others.
  constexpr double kLongestRepetition = 0.25;  // s
  constexpr std::size_t kFewestRepeats = 10;
  if (reading.angular_rate != repeated_rate_) {
    repeated_rate_ = reading.angular_rate;
    repeated_since_ = reading.time;
    repeats_ = 0;
  } else {
    ++repeats_;
  }
  const bool frozen = (reading.angular_rate.array() != 0).all() && repeats_ >= kFewestRepeats &&
                      reading.time - repeated_since_ >= kLongestRepetition;
  return frozen || reading.specific_force.isZero(0);
}

ImuIntake::Taken ImuIntake::add(const ImuReading& reading, double others) noexcept {
  if (!(std::isfinite(reading.time) && reading.angular_rate.allFinite() &&
        reading.specific_force.allFinite())) {
    return {.outcome = Outcome::kNotFinite};
  }
  if (is_dead(reading)) {
    return {.outcome = Outcome::kDead};
  }
  const ImuReading now = {reading.time, R_body_imu_ * (scale_ * reading.specific_force),
                          R_body_imu_ * reading.angular_rate};
  if (now.specific_force.norm() > largest_force_ || now.angular_rate.norm() > largest_rate_) {
    return {.outcome = Outcome::kGated};
  }
  // One stamp may be wrong, two in a row are not while other sensors agree.
  constexpr std::size_t kConfirmedByOthers = 2;
  constexpr std::size_t kConfirmed = 5;
  const double before = clock_.newest();
  const bool gap = is_gap(before, now.time, others);
  Taken taken;
  switch (clock_.judge(now.time, gap ? kConfirmedByOthers : kConfirmed)) {
    case ClockWatch::Step::kNext:
      break;
    case ClockWatch::Step::kLate:
      return {.outcome = Outcome::kLate};
    case ClockWatch::Step::kDuplicate:
      return {.outcome = Outcome::kDuplicate};
    case ClockWatch::Step::kSuspicious:
      return {.outcome = now.time > clock_.newest() ? Outcome::kFuture : Outcome::kLate};
    case ClockWatch::Step::kJump:
      last_.reset();
      held_ = now;
      dropped_ = 0;
      taken.jumped = true;
      taken.gap = gap ? now.time - before : 0;
      return taken;
  }
  if (!last_) {
    begin(now, taken);
    return taken;
  }
  if (held_ && near(*held_, now)) {
    join(*held_, taken);
  } else if (!near(*last_, now) && dropped_ < kMostDropped) {
    dropped_ += held_ ? 1 : 0;
    taken.outcome = held_ ? Outcome::kGated : Outcome::kWaiting;
    held_ = now;
    return taken;
  } else if (held_) {
    taken.outcome = Outcome::kGated;
  }
  held_.reset();
  if (dropped_ == kMostDropped && !near(*last_, now)) {
    rate_step_ = std::min((now.angular_rate - last_->angular_rate).norm(), spike_rate_);
    force_step_ = std::min((now.specific_force - last_->specific_force).norm(), spike_force_);
    last_ = now;  // none of the last readings is to be joined to this one
  } else {
    join(now, taken);
  }
  dropped_ = 0;
  return taken;
}

}  // namespace pipescout::estimation
