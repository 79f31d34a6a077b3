// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "odometer_stream_implementation.hpp"

namespace pipescout::odometry {

using internal::TickMark;
using internal::WindowEvidence;
using internal::WindowSum;

namespace {

double squared(double value) {
  return value * value;
}

}  // namespace

void OdometerStream::Implementation::fuse_tick(std::int64_t tick) {
  const double time = grid_.time(tick);
  ++state_.tick;
  state_.time = time;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    wheels_[i].monitor.note_time(time, wheels_[i].heard);
    state_.odometers[i].health = wheels_[i].monitor.health();
  }
  if (!anchored_) {
    begin(tick);
    return;
  }
  read_increments(tick);
  fuse_increments();
  const double duration = time - anchor_time_;
  if (state_.status == StreamStatus::kNoData) {
    coast(duration);
  } else if (duration >= 2.0 * parameters_.tick_period) {
    state_.speed = window_.distance / duration;
  }
  window_open_ = true;
  publish();
  if (anchor_is_due(tick)) {
    anchor(tick);
  }
}

/// The distance starts where all odometers have a position, or where one has when the others have
/// had the time to come.
void OdometerStream::Implementation::begin(std::int64_t tick) {
  const auto present = std::count_if(wheels_.begin(), wheels_.end(), [tick](const Wheel& wheel) {
    return wheel.track.at(tick) != nullptr;
  });
  const bool all = static_cast<std::size_t>(present) == wheels_.size();
  if (all || (present > 0 && state_.time - origin_ >= parameters_.silent_after)) {
    anchored_ = true;
    anchor_time_ = state_.time;
    for (auto& wheel : wheels_) {
      wheel.track.set_anchor(tick);
    }
  }
}

void OdometerStream::Implementation::read_increments(std::int64_t tick) {
  window_ = {};
  usable_.reset();
  spanning_.reset();
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    const Wheel& wheel = wheels_[i];
    OdometerState& state = state_.odometers[i];
    state.increment = state.standard_deviation = std::numeric_limits<double>::quiet_NaN();
    const TickMark* mark = wheel.track.at(tick);
    if (mark == nullptr || !wheel.track.spans(*mark)) {
      state.use = mark == nullptr ? OdometerUse::kAbsent : OdometerUse::kIncomplete;
      continue;
    }
    const TickMark& anchor = wheel.track.anchor();
    const double increment = mark->position - anchor.position;
    const double path = mark->path - anchor.path;
    const double random = squared(wheel.monitor.sigma_per_sqrt_metre()) * path;
    const double counting = squared(parameters_.odometers[i].resolution) / 6.0;  // at both ends
    const double scale = squared(increment / wheel.scale) * wheel.scale_variance;
    window_.increment[i] = increment;
    window_.path[i] = path;
    window_.random[i] = random;
    state.increment = increment;
    state.standard_deviation = std::sqrt(random + counting + scale);
    spanning_.set(i);
    usable_.set(i, state.health != OdometerHealth::kStuck);
  }
  if (usable_.count() < kMinOdometers) {  // nobody is left to say that the others are stuck
    usable_ = spanning_;
  }
}

void OdometerStream::Implementation::fuse_increments() {
  std::array<OdometerReading, kMaxOdometers> readings;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    const OdometerState& state = state_.odometers[i];
    readings[i] = {.distance = state.increment,
                   .standard_deviation = parameters_.sigma_margin * state.standard_deviation,
                   .valid = usable_[i]};
  }
  state_.consensus = consensus_.fuse(std::span(readings).first(wheels_.size()));
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    if (spanning_[i]) {
      state_.odometers[i].use = !usable_[i]                      ? OdometerUse::kStuck
                                : state_.consensus.fusion_set[i] ? OdometerUse::kFused
                                                                 : OdometerUse::kUnsupported;
    }
  }
  if (state_.consensus.status == FusionStatus::kOk) {
    state_.status = StreamStatus::kOk;
    agree();
  } else if (usable_.any()) {
    state_.status = StreamStatus::kNoConsensus;
    fall_back();
  } else {
    state_.status = StreamStatus::kNoData;
  }
}

void OdometerStream::Implementation::agree() {
  window_.agreed = true;
  window_.distance = state_.consensus.fused.distance;
  const bool squares = parameters_.consensus.weighting == Weighting::kMaximumLikelihood;
  double sum = 0.0;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    if (state_.consensus.fusion_set[i]) {
      const double deviation = state_.odometers[i].standard_deviation;
      window_.weight[i] = 1.0 / (squares ? squared(deviation) : deviation);
      sum += window_.weight[i];
    }
  }
  for (double& weight : window_.weight) {
    weight /= sum;
  }
}

void OdometerStream::Implementation::fall_back() {
  OdometerSet chosen;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    const OdometerHealth health = state_.odometers[i].health;
    chosen.set(i, usable_[i] && (health == OdometerHealth::kOk || health == OdometerHealth::kWorn));
  }
  if (chosen.none()) {
    chosen = usable_;
  }
  std::array<std::size_t, kMaxOdometers> order{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    if (chosen[i]) {
      order[count++] = i;
      state_.odometers[i].use = OdometerUse::kFallback;
    }
  }
  std::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count),
            [this](std::size_t a, std::size_t b) {
              const double x = window_.increment[a];
              const double y = window_.increment[b];
              return x != y ? x < y : a < b;
            });
  window_.weight[order[(count - 1) / 2]] += 0.5;
  window_.weight[order[count / 2]] += 0.5;
  window_.distance =
      0.5 * (window_.increment[order[(count - 1) / 2]] + window_.increment[order[count / 2]]);
  window_.bias = count == 1 ? parameters_.unverified_ratio * window_.path[order[0]]
                            : std::max(window_.increment[order[count - 1]] - window_.distance,
                                       window_.distance - window_.increment[order[0]]);
}

void OdometerStream::Implementation::coast(double duration) {
  // The time may be that of a clock that was set, so the speed is not believed for longer than what
  // counts as a gap.
  window_.distance = state_.speed * std::min(duration, parameters_.maximum_gap);
  window_.gap_variance = squared(parameters_.maximum_speed * duration) / 3.0;
}

/// The second largest increment counts: one odometer that spins must not cut windows short.
bool OdometerStream::Implementation::anchor_is_due(std::int64_t tick) const {
  double largest = 0.0;
  double second = 0.0;
  bool joins = false;  // one could take part, but for the anchor
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    const double travelled = std::abs(window_.increment[i]);
    second = std::max(second, std::min(largest, travelled));
    largest = std::max(largest, travelled);
    joins = joins || (!spanning_[i] && wheels_[i].track.at(tick) != nullptr);
  }
  if (spanning_.none()) {
    return joins;
  }
  const bool quorum = spanning_.count() > wheels_.size() / 2;
  return (spanning_.count() == 1 ? largest : second) >= parameters_.window_distance ||
         state_.time - anchor_time_ >= parameters_.window_time || (joins && !quorum);
}

void OdometerStream::Implementation::anchor(std::int64_t tick) {
  judge_window();
  book_.commit(window_);
  ++state_.windows;
  state_.windows_no_consensus += state_.status == StreamStatus::kNoConsensus ? 1 : 0;
  state_.windows_no_data += state_.status == StreamStatus::kNoData ? 1 : 0;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    wheels_[i].track.set_anchor(tick);
    state_.odometers[i].unsupported += state_.odometers[i].use == OdometerUse::kUnsupported ? 1 : 0;
  }
  anchor_time_ = state_.time;
  // What is left of the window is its weights: they hold the last reading of each member.
  const WindowSum committed = window_;
  window_ = {.weight = committed.weight, .agreed = committed.agreed};
  window_open_ = false;
}

void OdometerStream::Implementation::judge_window() {
  double fused_variance = 0.0;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    if (window_.weight[i] > 0.0) {
      fused_variance += squared(window_.weight[i] * state_.odometers[i].standard_deviation);
    }
  }
  std::array<double, kMaxOdometers> scales{};
  std::size_t known = 0;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    auto& monitor = wheels_[i].monitor;
    if (spanning_[i] && spanning_.count() >= kMinOdometers) {
      monitor.note_window({.increment = window_.increment[i],
                           .deviation = state_.odometers[i].standard_deviation,
                           .path = window_.path[i],
                           .fused = window_.distance,
                           .fused_deviation = std::sqrt(fused_variance),
                           .agreed = window_.agreed});
    }
    if (monitor.scale_known()) {
      scales[known++] = monitor.scale();
    }
  }
  const double reference = known < kMinOdometers ? 1.0 : internal::median(scales.data(), known);
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    auto& monitor = wheels_[i].monitor;
    monitor.judge_wear(reference);
    OdometerState& state = state_.odometers[i];
    state.health = monitor.health();
    state.relative_scale = monitor.scale() / reference;
    state.sigma_per_sqrt_metre = monitor.sigma_per_sqrt_metre();
  }
}

void OdometerStream::Implementation::publish() {
  state_.distance = book_.distance(window_);
  state_.random_variance = book_.random_variance(window_);
  state_.variance = book_.variance(window_);
  state_.window_increment = window_.distance;
}

}  // namespace pipescout::odometry
