// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "odometer_stream_implementation.hpp"

namespace pipescout::odometry {

using internal::TickMark;
using internal::WindowEvidence;

namespace {

constexpr std::size_t kLeastOnCircumference = 3;  // wheels, of a distance and a bend
constexpr double kLargestBendProbability = 0.05;  // of windows that tell something of a wheel

double squared(double value) {
  return value * value;
}

}  // namespace

void OdometerStream::Implementation::fuse_tick(std::int64_t tick) {
  const double time = grid_.time(tick);
  ++state_.tick;
  state_.time = time;
  heading_ = turn_.at(time);
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    wheels_[i].monitor.note_time(time, wheels_[i].heard);
    state_.odometers[i].health = wheels_[i].monitor.health();
  }
  if (!anchored_) {
    begin(tick);
    return;
  }
  read_increments(tick);
  if (bends_) {
    window_.explanation = bends_->explain(sums_of(window_));
  }
  explain(fuse_window(window_));
  const double duration = time - anchor_time_;
  if (state_.status == StreamStatus::kNoData) {
    coast(duration);
  } else if (duration >= 2.0 * parameters_.tick_period) {
    state_.speed = window_.sum.distance / duration;
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
    anchor_heading_ = heading_;
    for (auto& wheel : wheels_) {
      wheel.track.set_anchor(tick);
    }
  }
}

void OdometerStream::Implementation::read_increments(std::int64_t tick) {
  window_ = {};
  window_.drifted = drifting_;
  window_.duration = state_.time - anchor_time_;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    const Wheel& wheel = wheels_[i];
    OdometerState& state = state_.odometers[i];
    state.increment = state.standard_deviation = std::numeric_limits<double>::quiet_NaN();
    const TickMark* mark = wheel.track.at(tick);
    state.measured = mark == nullptr ? state.measured : mark->measured;
    if (mark == nullptr || !wheel.track.spans(*mark)) {
      state.use = mark == nullptr ? OdometerUse::kAbsent : OdometerUse::kIncomplete;
      continue;
    }
    const TickMark& anchor = wheel.track.anchor();
    window_.sum.increment[i] = mark->position - anchor.position +
                               parameters_.odometers[i].lateral * (heading_ - anchor_heading_);
    window_.sum.path[i] = mark->path - anchor.path;
    window_.spanning.set(i);
    window_.usable.set(i, state.health != OdometerHealth::kStuck);
    window_.trusted.set(
        i, state.health == OdometerHealth::kOk || state.health == OdometerHealth::kWorn);
  }
  if (window_.usable.count() < kMinOdometers) {  // nobody is left to say that the others are stuck
    window_.usable = window_.spanning;
  }
  estimate_deviations();
}

/// All odometers went the same way, so all deviations are taken of the median path. Of its own one,
/// an odometer that errs to the long side would weigh less, and the fused distance come out short.
void OdometerStream::Implementation::estimate_deviations() {
  if (window_.usable.none()) {
    return;
  }
  const double path = median_of_usable(window_.sum.path);
  const double travelled = median_of_usable(window_.sum.increment);
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    if (window_.spanning[i]) {
      const double counting = squared(parameters_.odometers[i].resolution) / 6.0;  // at both ends
      const double scale = squared(travelled / wheels_[i].scale) * wheels_[i].scale_variance;
      window_.sum.path[i] = path;
      window_.sum.random[i] = squared(wheels_[i].monitor.sigma_per_sqrt_metre()) * path;
      window_.deviation[i] = std::sqrt(window_.sum.random[i] + counting + scale);
      state_.odometers[i].increment = window_.sum.increment[i];
      state_.odometers[i].standard_deviation = window_.deviation[i];
    }
  }
  window_.median = travelled;
}

ConsensusFusionResult OdometerStream::Implementation::fuse_window(Window& window) const {
  OdometerSet taking_part = window.usable & ~window.drifted;
  if (taking_part.none()) {
    taking_part = window.usable;
  }
  std::array<OdometerReading, kMaxOdometers> readings;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    readings[i] = {.distance = window.sum.increment[i],
                   .standard_deviation = parameters_.sigma_margin * window.deviation[i],
                   .valid = taking_part[i]};
  }
  const auto result = consensus_.fuse(std::span(readings).first(wheels_.size()));
  window.sum.weight.fill(0.0);
  window.sum.bias = 0.0;
  window.sum.agreed = result.status == FusionStatus::kOk;
  if (parameters_.rule == FusionRule::kAverage && window.spanning.any()) {
    average(window);
  } else if (bends_ && window.usable.count() >= kLeastOnCircumference &&
             window.explanation.consistent) {
    weigh(window);
  } else if (window.sum.agreed && !(bends_ && !window.explanation.consistent)) {
    agree(window, result.fusion_set, result.fused.distance);
  } else if (taking_part.any()) {
    window.sum.agreed = false;
    const OdometerSet trusted = taking_part & window.trusted;
    fall_back(window, trusted.any() ? trusted : taking_part);
  }
  return result;
}

void OdometerStream::Implementation::agree(Window& window, const OdometerSet& members,
                                           double distance) const {
  window.sum.distance = distance;
  const bool squares = parameters_.consensus.weighting == Weighting::kMaximumLikelihood;
  double total = 0.0;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    if (members[i]) {
      const double deviation = window.deviation[i];
      window.sum.weight[i] = 1.0 / (squares ? squared(deviation) : deviation);
      total += window.sum.weight[i];
    }
  }
  for (double& weight : window.sum.weight) {
    weight /= total;
  }
}

void OdometerStream::Implementation::average(Window& window) {
  const auto count = static_cast<double>(window.spanning.count());
  window.sum.agreed = true;
  window.sum.distance = 0.0;
  for (std::size_t i = 0; i < kMaxOdometers; ++i) {
    if (window.spanning[i]) {
      window.sum.weight[i] = 1.0 / count;
      window.sum.distance += window.sum.increment[i] / count;
    }
  }
}

internal::WheelSums OdometerStream::Implementation::sums_of(const Window& window) const {
  return {.wheels = window.usable,
          .increment = window.sum.increment,
          .random = window.sum.random,
          .travelled = window.median,
          .duration = window.duration};
}

void OdometerStream::Implementation::weigh(Window& window) const {
  const auto weights =
      bends_->circumference().weigh(window.explanation, sums_of(window), window.deviation);
  window.sum.agreed = true;
  window.sum.weight = weights.weight;
  window.sum.distance = weights.distance;
  window.sum.bias = weights.bias;
}

/// `begin`: m, fused distance at the begin of the window that was closed last.
void OdometerStream::Implementation::judge_bends(double begin) {
  const auto judged = bends_->note(sums_of(closed_.back()), begin);
  for (const auto& judgement : std::span(judged.judged).first(judged.judgements)) {
    apply(judgement);
  }
  for (const FoundBend& found : std::span(judged.found).first(judged.bends)) {
    ++state_.bends;
    state_.bend = found;
    state_.bend.direction = std::remainder(found.direction + roll_, 2.0 * std::numbers::pi);
  }
}

/// To as many of its windows as are not final.
void OdometerStream::Implementation::apply(const internal::BendFinder::Judgement& judgement) {
  const std::size_t end = closed_.size() - std::min(judgement.later, closed_.size());
  for (std::size_t w = end - std::min(judgement.windows, end); w < end; ++w) {
    closed_[w].explanation = judgement.explanation;
    static_cast<void>(fuse_window(closed_[w]));
  }
}

void OdometerStream::Implementation::fall_back(Window& window, const OdometerSet& chosen) const {
  std::array<std::size_t, kMaxOdometers> order{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    if (chosen[i]) {
      order[count++] = i;
    }
  }
  const auto& increment = window.sum.increment;
  std::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count),
            [&increment](std::size_t a, std::size_t b) {
              return increment[a] != increment[b] ? increment[a] < increment[b] : a < b;
            });
  const std::size_t lower = order[(count - 1) / 2];
  const std::size_t upper = order[count / 2];
  window.sum.weight[lower] += 0.5;
  window.sum.weight[upper] += 0.5;
  const double middle = 0.5 * (increment[lower] + increment[upper]);
  window.sum.distance = middle;
  window.sum.bias =
      count == 1 ? parameters_.unverified_ratio * window.sum.path[lower]
                 : std::max(increment[order[count - 1]] - middle, middle - increment[order[0]]);
}

void OdometerStream::Implementation::explain(const ConsensusFusionResult& result) {
  state_.consensus = result;
  state_.in_bend = bends_ ? window_.explanation.bend : 0.0;
  state_.status = window_.sum.agreed     ? StreamStatus::kOk
                  : window_.usable.any() ? StreamStatus::kNoConsensus
                                         : StreamStatus::kNoData;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    if (!window_.spanning[i]) {
      continue;
    }
    const bool weighs = window_.sum.weight[i] > 0.0;
    state_.odometers[i].use = weighs && window_.sum.agreed ? OdometerUse::kFused
                              : weighs                     ? OdometerUse::kFallback
                              : !window_.usable[i]         ? OdometerUse::kStuck
                              : window_.drifted[i]         ? OdometerUse::kDrifted
                                                           : OdometerUse::kUnsupported;
  }
}

void OdometerStream::Implementation::coast(double duration) {
  // The time may be that of a clock that was set, so the speed is not believed for longer than what
  // counts as a gap.
  window_.sum.distance = state_.speed * std::min(duration, parameters_.maximum_gap);
  window_.sum.gap_variance = squared(parameters_.maximum_speed * duration) / 3.0;
}

/// The second largest increment counts: one odometer that spins must not cut windows short.
bool OdometerStream::Implementation::anchor_is_due(std::int64_t tick) const {
  double largest = 0.0;
  double second = 0.0;
  bool joins = false;  // one could take part, but for the anchor
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    const double travelled = std::abs(window_.sum.increment[i]);
    second = std::max(second, std::min(largest, travelled));
    largest = std::max(largest, travelled);
    joins = joins || (!window_.spanning[i] && wheels_[i].track.at(tick) != nullptr);
  }
  if (window_.spanning.none()) {
    return joins;
  }
  const bool quorum = window_.spanning.count() > wheels_.size() / 2;
  return (window_.spanning.count() == 1 ? largest : second) >= parameters_.window_distance ||
         state_.time - anchor_time_ >= parameters_.window_time || (joins && !quorum);
}

void OdometerStream::Implementation::anchor(std::int64_t tick) {
  judge_window();
  ++state_.windows;
  state_.uneven_windows += window_.explanation.straight < 0.5 ? 1 : 0;
  state_.windows_no_consensus += state_.status == StreamStatus::kNoConsensus ? 1 : 0;
  state_.windows_no_data += state_.status == StreamStatus::kNoData ? 1 : 0;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    wheels_[i].track.set_anchor(tick);
    state_.odometers[i].unsupported += state_.odometers[i].use == OdometerUse::kUnsupported ? 1 : 0;
  }
  anchor_time_ = state_.time;
  anchor_heading_ = heading_;
  window_open_ = false;
  closed_.push_back(window_);
  if (bends_) {
    judge_bends(ahead_.distance({}));
  } else if (parameters_.rule == FusionRule::kConsensus) {
    look_back();
  }
  // What is left of the window is its weights: they hold the last reading of each member.
  window_ = {};
  window_.sum.weight = closed_.back().sum.weight;
  window_.sum.agreed = closed_.back().sum.agreed;
  if (closed_.size() > parameters_.lookback_windows) {
    book_.commit(closed_.front().sum);
    closed_.erase(closed_.begin());
  }
  ahead_ = book_;
  for (const auto& window : closed_) {
    ahead_.commit(window.sum);
  }
}

double OdometerStream::Implementation::median_of_usable(
    const std::array<double, kMaxOdometers>& values) const {
  std::array<double, kMaxOdometers> chosen{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    if (window_.usable[i]) {
      chosen[count++] = values[i];
    }
  }
  return internal::median(chosen.data(), count);
}

/// A slip too small to show in one window shows over several: an odometer is left out, afterwards
/// too, of the windows over which it has gone furthest from the median odometer.
void OdometerStream::Implementation::look_back() {
  drifting_.reset();
  if (parameters_.lookback_windows == 0) {
    return;
  }
  const OdometerSet assumed = std::exchange(closed_.back().drifted, {});
  std::bitset<kMostWindows> changed;
  changed.set(closed_.size() - 1, assumed.any());
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    const Drift drift = find_drift(i);
    for (std::size_t w = drift.begin; w < drift.end; ++w) {
      changed.set(w, changed[w] || !closed_[w].drifted[i]);
      closed_[w].drifted.set(i);
    }
    drifting_.set(i, drift.begin < drift.end && drift.end == closed_.size());
  }
  for (std::size_t w = 0; w < closed_.size(); ++w) {
    if (changed[w] && closed_[w].spanning.any()) {
      static_cast<void>(fuse_window(closed_[w]));
    }
  }
}

OdometerStream::Implementation::Drift OdometerStream::Implementation::find_drift(
    std::size_t odometer) const {
  Drift worst;
  double worst_share = 1.0;  // of what is allowed
  for (std::size_t begin = 0; begin < closed_.size(); ++begin) {
    double off = 0.0;
    double travelled = 0.0;
    double variance = 0.0;
    for (std::size_t end = begin; end < closed_.size(); ++end) {
      const Window& window = closed_[end];
      if (window.usable.count() < 3 || !window.usable[odometer]) {
        break;
      }
      off += window.sum.increment[odometer] - window.median;
      travelled += window.median;
      variance += squared(window.deviation[odometer]);
      const double allowed = std::max(parameters_.lookback_sigmas * std::sqrt(variance),
                                      parameters_.health.slip_ratio * std::abs(travelled));
      if (std::abs(off) > worst_share * allowed) {
        worst_share = std::abs(off) / allowed;
        worst = {.begin = begin, .end = end + 1};
      }
    }
  }
  return worst;
}

/// Makes the distance so far final.
void OdometerStream::Implementation::settle() {
  if (window_open_) {
    anchor(next_ - 1);
  }
  book_ = ahead_;
  closed_.clear();
  drifting_.reset();
}

void OdometerStream::Implementation::judge_window() {
  double fused_variance = 0.0;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    if (window_.sum.weight[i] > 0.0) {
      fused_variance += squared(window_.sum.weight[i] * state_.odometers[i].standard_deviation);
    }
  }
  std::array<double, kMaxOdometers> scales{};
  std::size_t known = 0;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    auto& monitor = wheels_[i].monitor;
    // In a bend they differ by right.
    const bool comparable = window_.explanation.bend < kLargestBendProbability;
    if (comparable && window_.spanning[i] && window_.spanning.count() >= kMinOdometers) {
      monitor.note_window({.increment = window_.sum.increment[i],
                           .deviation = state_.odometers[i].standard_deviation,
                           .path = window_.sum.path[i],
                           .fused = window_.sum.distance,
                           .fused_deviation = std::sqrt(fused_variance),
                           .agreed = window_.sum.agreed});
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
  state_.distance = ahead_.distance(window_.sum);
  state_.random_variance = ahead_.random_variance(window_.sum);
  state_.variance = ahead_.variance(window_.sum);
  state_.window_increment = window_.sum.distance;
}

}  // namespace pipescout::odometry
