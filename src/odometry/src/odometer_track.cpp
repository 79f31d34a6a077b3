// SPDX-License-Identifier: Apache-2.0
#include "odometer_track.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::odometry::internal {
namespace {

constexpr double kTickTolerance = 1e-6;  // of a period
constexpr double kLatePeriods = 1.5;  // an increment that comes later than this follows a lost one
constexpr double kAway = 10.0;        // windows from zero, see `returned_to_zero`

/// Whether a counter that was switched off and on, rather than the crawler, went back to zero.
bool returned_to_zero(double before, double now, double window) {
  return std::abs(before) > kAway * window && std::abs(now) < window;
}

}  // namespace

std::int64_t TickGrid::at(double time) const {
  return static_cast<std::int64_t>(std::floor((time - origin) / period + kTickTolerance));
}

OdometerTrack::OdometerTrack(const OdometerParameters& parameters,
                             const OdometerStreamParameters& stream)
    : kind_(parameters.kind),
      wrap_(parameters.wrap),
      period_(parameters.period),
      maximum_gap_(stream.maximum_gap),
      maximum_speed_(stream.maximum_speed),
      tick_period_(stream.tick_period),
      window_distance_(stream.window_distance),
      scale_(parameters.correction.scale) {}

OdometerTrack::Step OdometerTrack::step_of(double time, double value) const {
  const double duration = time - time_;
  const double reach =
      maximum_speed_ * (std::max(duration, tick_period_) + (resumed_ ? std::abs(leap_) : 0.0));
  Step step;
  if (kind_ == OdometerKind::kIncrement) {
    step.distance = value;
    step.known = !lost_ && !resumed_ && duration <= maximum_gap_ &&
                 (period_ == 0.0 || duration <= kLatePeriods * period_);
  } else {
    step.distance = value - value_;
    if (wrap_ > 0.0) {
      step.distance = std::remainder(step.distance, wrap_);
    }
    step.known = duration <= maximum_gap_;
    if (resumed_ && wrap_ == 0.0 && returned_to_zero(value_, value, window_distance_)) {
      step.plausible = false;
    }
  }
  // Negated: a difference of huge values is not a number.
  if (!(std::abs(step.distance) <= reach)) {
    step.plausible = false;
  }
  return step;
}

void OdometerTrack::begin_epoch() {
  ++epoch_;
  ++gaps_;
}

SampleOutcome OdometerTrack::take(double time, double value, const TickGrid& grid) {
  if (!started_) {
    started_ = true;
    value_ = value;
    time_ = before_time_ = time;
    last_tick_ = grid.at(time);
    const bool on_tick = std::abs(grid.time(last_tick_) - time) <= kTickTolerance * grid.period;
    first_tick_ = on_tick ? last_tick_ : last_tick_ + 1;
    return SampleOutcome::kAccepted;
  }
  if (time <= time_) {
    return time == time_ ? SampleOutcome::kDuplicateStamp : SampleOutcome::kOutOfOrder;
  }
  const Step step = step_of(time, value);
  if (kind_ == OdometerKind::kIncrement && !step.plausible) {
    lost_ = true;
    return SampleOutcome::kImplausible;
  }
  const bool known = step.known && step.plausible;
  before_time_ = time_;
  before_position_ = position_;
  before_measured_ = measured_;
  value_ = value;
  time_ = time;
  if (step.plausible) {
    position_ += scale_ * step.distance;
    measured_ += step.distance;
  }
  if (resumed_) {  // the distance of the gap lies before the ticks that follow it
    before_position_ = position_;
    before_measured_ = measured_;
  }
  resumed_ = lost_ = false;
  first_tick_ = last_tick_ + 1;
  last_tick_ = std::max(last_tick_, grid.at(time));
  if (!known) {
    begin_epoch();
    first_tick_ = last_tick_ + 1;
  }
  return step.plausible ? SampleOutcome::kAccepted : SampleOutcome::kImplausible;
}

void OdometerTrack::note_unusable() {
  lost_ = lost_ || kind_ == OdometerKind::kIncrement;
}

void OdometerTrack::resume(double time, double leap, std::int64_t next) {
  if (started_) {
    time_ = time - tick_period_;
    leap_ = leap;
    resumed_ = true;
    last_tick_ = next - 1;
  }
}

void OdometerTrack::mark(std::int64_t tick, const TickGrid& grid) {
  const double duration = time_ - before_time_;
  const double share =
      duration > 0.0 ? std::clamp((grid.time(tick) - before_time_) / duration, 0.0, 1.0) : 1.0;
  const double position = before_position_ + share * (position_ - before_position_);
  path_ += std::abs(position - marked_position_);
  marked_position_ = position;
  const TickMark mark{.tick = tick,
                      .epoch = epoch_,
                      .position = position,
                      .measured = before_measured_ + share * (measured_ - before_measured_),
                      .path = path_};
  ring_[static_cast<std::size_t>(tick % kRing)] = mark;
  if (tick == anchor_wanted_) {
    anchor_ = mark;
    anchor_wanted_ = -1;
  }
}

const TickMark* OdometerTrack::at(std::int64_t tick) const {
  const TickMark& mark = ring_[static_cast<std::size_t>(tick % kRing)];
  return mark.tick == tick ? &mark : nullptr;
}

void OdometerTrack::set_anchor(std::int64_t tick) {
  const TickMark* known = at(tick);
  anchor_wanted_ = known == nullptr ? tick : -1;
  anchor_ = known == nullptr ? TickMark{} : *known;
}

}  // namespace pipescout::odometry::internal
