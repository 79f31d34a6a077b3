// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry/odometer_stream.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "odometer_stream_implementation.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::odometry {

using internal::OdometerMonitor;
using internal::OdometerTrack;

namespace {

constexpr int kLeapConfirmations = 5;  // samples of one odometer while the others are silent

std::size_t index(SampleOutcome outcome) {
  return static_cast<std::size_t>(outcome);
}

}  // namespace

OdometerStream::Implementation::Implementation(OdometerStreamParameters parameters)
    : parameters_((parameters.validate(), std::move(parameters))),
      consensus_(parameters_.consensus),
      book_(parameters_),
      ahead_(book_),
      turn_(parameters_.maximum_gap) {
  closed_.reserve(parameters_.lookback_windows + 1);
  if (parameters_.rule == FusionRule::kCircumference) {
    bends_.emplace(parameters_);
  }
  for (const auto& odometer : parameters_.odometers) {
    wheels_.push_back({.track = OdometerTrack(odometer, parameters_),
                       .monitor = OdometerMonitor(odometer, parameters_),
                       .scale = odometer.correction.scale,
                       .scale_variance = odometer.correction.covariance(0, 0)});
  }
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    state_.odometers[i].correction = parameters_.odometers[i].correction;
    state_.odometers[i].sigma_per_sqrt_metre = parameters_.odometers[i].sigma_per_sqrt_metre;
  }
  const auto m = static_cast<Eigen::Index>(wheels_.size());
  state_.consensus.confidence_distance.setOnes(m, m);
  state_.consensus.relation.setZero(m, m);
}

SampleOutcome OdometerStream::Implementation::push(const OdometerSample& sample) {
  if (sample.odometer >= wheels_.size()) {
    ++state_.unknown_odometer;
    return SampleOutcome::kUnknownOdometer;
  }
  const SampleOutcome outcome = judge(sample);
  OdometerState& state = state_.odometers[sample.odometer];
  ++state.samples[index(outcome)];
  state.gaps = wheels_[sample.odometer].track.gaps();
  return outcome;
}

SampleOutcome OdometerStream::Implementation::judge(const OdometerSample& sample) {
  Wheel& wheel = wheels_[sample.odometer];
  if (!std::isfinite(sample.time)) {
    wheel.monitor.note_sample(false);
    wheel.track.note_unusable();
    return SampleOutcome::kBadStamp;
  }
  if (!started_) {
    started_ = true;
    origin_ = newest_ = sample.time;
    grid_ = {.origin = sample.time, .period = parameters_.tick_period};
  } else if (!near_the_others(sample)) {
    wheel.track.note_unusable();
    return SampleOutcome::kStampLeap;
  }
  newest_ = std::max(newest_, sample.time);
  wheel.heard = std::max(wheel.heard, sample.time);
  if (!sample.valid || !std::isfinite(sample.value)) {
    wheel.monitor.note_sample(false);
    wheel.track.note_unusable();
    fuse_due();
    return sample.valid ? SampleOutcome::kNotANumber : SampleOutcome::kMarkedInvalid;
  }

  const SampleOutcome outcome = wheel.track.take(sample.time, sample.value, grid_);
  if (outcome == SampleOutcome::kDuplicateStamp) {  // the same sample again, nothing is lost
    return outcome;
  }
  if (outcome == SampleOutcome::kOutOfOrder) {
    wheel.track.note_unusable();
    return outcome;
  }
  wheel.monitor.note_sample(outcome == SampleOutcome::kAccepted);
  const std::int64_t last = wheel.track.last_tick();
  std::int64_t tick = wheel.track.first_tick();
  // Where a late odometer was when the distance was anchored is still of use; at older ticks, not.
  const std::int64_t wanted = wheel.track.anchor_wanted();
  if (tick <= wanted && wanted <= last && wanted < next_) {
    wheel.track.mark(wanted, grid_);
  }
  for (tick = std::max(tick, next_); tick <= last; ++tick) {
    while (tick - next_ >= OdometerTrack::kRing - 1) {
      fuse_tick(next_++);
    }
    wheel.track.mark(tick, grid_);
  }
  fuse_due();
  return outcome;
}

/// Whether the stamp can be compared with those of the other odometers; follows a leap that is
/// confirmed. One wrong stamp must not carry the grid away, nor a clock that was set stop it.
bool OdometerStream::Implementation::near_the_others(const OdometerSample& sample) {
  if (std::abs(sample.time - newest_) <= parameters_.maximum_gap) {
    leap_.samples = 0;
    return true;
  }
  const bool goes_on =
      leap_.samples > 0 && std::abs(sample.time - leap_.time) <= parameters_.maximum_gap;
  const bool another = goes_on && sample.odometer != leap_.odometer;
  leap_ = {
      .time = sample.time, .odometer = sample.odometer, .samples = goes_on ? leap_.samples + 1 : 1};
  if (!another && leap_.samples < kLeapConfirmations) {
    return false;
  }
  follow_leap(sample.time);
  return true;
}

void OdometerStream::Implementation::follow_leap(double time) {
  flush();
  const double leap = time - newest_;
  const double before = time - parameters_.tick_period;
  for (auto& wheel : wheels_) {
    wheel.track.resume(time, leap, next_);
    wheel.heard = std::min(wheel.heard, before);
  }
  turn_.shift(leap);
  grid_.origin = time - static_cast<double>(next_) * parameters_.tick_period;
  anchor_time_ = leap > 0.0 ? anchor_time_ : before;
  origin_ = newest_ = time;
  leap_ = {};
  ++state_.leaps;
}

void OdometerStream::Implementation::flush() {
  std::int64_t last = next_ - 1;
  for (const auto& wheel : wheels_) {
    last = wheel.track.started() ? std::max(last, wheel.track.last_tick()) : last;
  }
  while (next_ <= last) {
    fuse_tick(next_++);
  }
}

bool OdometerStream::Implementation::awaited(const Wheel& wheel, std::int64_t tick) const {
  if (!wheel.track.started()) {
    return newest_ - origin_ <= parameters_.silent_after;
  }
  return wheel.track.last_tick() < tick && newest_ - wheel.track.time() <= parameters_.silent_after;
}

void OdometerStream::Implementation::fuse_due() {
  while (newest_ >= grid_.time(next_)) {
    const bool in_time = newest_ < grid_.time(next_) + parameters_.maximum_delay;
    if (in_time && std::any_of(wheels_.begin(), wheels_.end(),
                               [this](const Wheel& wheel) { return awaited(wheel, next_); })) {
      return;
    }
    fuse_tick(next_++);
  }
}

void OdometerStream::Implementation::set_correction(std::size_t odometer,
                                                    const OdometerCorrection& correction) {
  if (odometer >= wheels_.size()) {
    validation::refuse("odometer: ", odometer, " is outside [0, ", wheels_.size() - 1, "]");
  }
  correction.validate();
  settle();
  Wheel& wheel = wheels_[odometer];
  wheel.track.set_scale(correction.scale);
  wheel.scale = correction.scale;
  wheel.scale_variance = correction.covariance(0, 0);
  wheel.monitor.restart_scale();
  if (bends_) {
    bends_->circumference().set_scale_variance(
        odometer, correction.covariance(0, 0) / (correction.scale * correction.scale));
  }
  book_.set_correction(odometer, correction);
  ahead_ = book_;
  state_.odometers[odometer].correction = correction;
  publish();
}

void OdometerStream::Implementation::end_segment() {
  settle();
  book_.end_segment();
  ahead_ = book_;
  publish();
}

void OdometerStream::Implementation::set_roll(double roll) {
  roll_ = std::isfinite(roll) ? roll : roll_;
}

OdometerStream::OdometerStream(OdometerStreamParameters parameters)
    : implementation_(std::make_unique<Implementation>(std::move(parameters))) {}

OdometerStream::OdometerStream(OdometerStream&& other) noexcept = default;
OdometerStream& OdometerStream::operator=(OdometerStream&& other) noexcept = default;
OdometerStream::~OdometerStream() = default;

PushResult OdometerStream::push(const OdometerSample& sample) noexcept {
  const std::uint64_t before = implementation_->state().tick;
  const SampleOutcome outcome = implementation_->push(sample);
  return {.outcome = outcome,
          .ticks = static_cast<std::size_t>(implementation_->state().tick - before)};
}

std::size_t OdometerStream::flush() noexcept {
  const std::uint64_t before = implementation_->state().tick;
  implementation_->flush();
  return static_cast<std::size_t>(implementation_->state().tick - before);
}

void OdometerStream::set_correction(std::size_t odometer, const OdometerCorrection& correction) {
  implementation_->set_correction(odometer, correction);
}

void OdometerStream::end_segment() noexcept {
  implementation_->end_segment();
}

void OdometerStream::push_yaw_rate(double time, double rate) noexcept {
  implementation_->push_yaw_rate(time, rate);
}

void OdometerStream::set_roll(double roll) noexcept {
  implementation_->set_roll(roll);
}

const FusedStream& OdometerStream::state() const noexcept {
  return implementation_->state();
}

const OdometerStreamParameters& OdometerStream::parameters() const noexcept {
  return implementation_->parameters();
}

}  // namespace pipescout::odometry
