// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/absolute_source_watch.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipescout/statistics/chi_square.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::estimation {
namespace {

using validation::require;

/// What a position or a heading has at most.
constexpr int kDegrees = 3;
/// Beyond it what an IMU has reckoned is told by the covariance of the state.
constexpr double kLongestDrift = 20;  // s

double square(double x) {
  return x * x;
}

TrackPair pair_of(const WatchedFix& fix) {
  return {.time = fix.time,
          .measured = fix.measured,
          .reckoned = fix.reckoned,
          .deviation = fix.deviation,
          .way = fix.way};
}

}  // namespace

std::string_view to_string(SourceState state) noexcept {
  constexpr std::array<std::string_view, 4> kNames = {"absent", "candidate", "trusted", "doubted"};
  const auto i = static_cast<std::size_t>(state);
  return i < kNames.size() ? kNames[i] : "unknown";
}

void SourceWatchParameters::validate() const {
  const auto within = [](const char* field, double value, double low, double high,
                         const char* range) {
    require(field, value, value >= low && value <= high, range);
  };
  within("correlation_time", correlation_time, 0, 1000, "[0, 1000]");
  within("shortest_correlation_time", shortest_correlation_time, 0, 1000, "[0, 1000]");
  within("height_correlation_time", height_correlation_time, 0, 1000, "[0, 1000]");
  within("largest_deviation_factor", largest_deviation_factor, 1, 100, "[1, 100]");
  within("outage", outage, 0.1, 1000, "[0.1, 1000]");
  within("doubt_after", static_cast<double>(doubt_after), 1, 1e4, "[1, 10000]");
  within("agreeing", static_cast<double>(agreeing), 2, 1e4, "[2, 10000]");
  within("agreeing_time", agreeing_time, 0, 1000, "[0, 1000]");
  require("gate_probability", gate_probability, gate_probability > 0.5 && gate_probability < 1,
          "(0.5, 1)");
  within("drift_share", drift_share, 0, 1, "[0, 1]");
  within("drift_floor", drift_floor, 0, 1000, "[0, 1000]");
  within("drift_speed", drift_speed, 0, 100, "[0, 100]");
  within("takeover", takeover, 1, 1e6, "[1, 1e6]");
  within("confirmed_takeover", confirmed_takeover, 1, 1e6, "[1, 1e6]");
  within("confirmation", confirmation, 0, 1e6, "[0, 1e6]");
}

double covariance_factor(double correlation_time, double spacing) noexcept {
  if (!(correlation_time > 0)) {
    return 1;
  }
  const double half = 0.5 * spacing / correlation_time;
  return 1 / std::tanh(half);
}

AbsoluteSourceWatch::AbsoluteSourceWatch(const SourceWatchParameters& parameters)
    : parameters_(parameters) {
  parameters.validate();
  gate_ = statistics::chi_square_quantile(parameters.gate_probability, kDegrees);
}

double AbsoluteSourceWatch::drift_speed(const WatchedFix& fix) const noexcept {
  constexpr double kShaken = 5;
  if (fix.witnessed) {
    return fix.shaken ? parameters_.drift_speed : 0;
  }
  return parameters_.drift_speed * (fix.shaken ? kShaken : 1);
}

double AbsoluteSourceWatch::drift(const WatchedFix& fix) const noexcept {
  const double way = parameters_.drift_share * std::max(fix.way - trusted_way_, 0.0);
  double drift = std::max(parameters_.drift_floor, way);
  if (std::isfinite(trusted_since_)) {
    const double silent = std::clamp(fix.time - trusted_since_, 0.0, kLongestDrift);
    drift = std::max(drift, drift_speed(fix) * silent);
  }
  return drift;
}

bool AbsoluteSourceWatch::within_reach(const WatchedFix& fix) const noexcept {
  return (fix.measured - fix.predicted).squaredNorm() <=
         gate_ * (square(fix.deviation) + square(fix.predicted_deviation) + square(drift(fix)));
}

bool AbsoluteSourceWatch::goes_on(const WatchedFix& fix) const noexcept {
  return ask_witness(pair_of(fix), fix.yaw).value_or(false);
}

std::optional<bool> AbsoluteSourceWatch::ask_witness(const TrackPair& pair,
                                                     double yaw) const noexcept {
  return witness_.bears_out(pair, yaw, gate_, parameters_.drift_share, parameters_.drift_floor);
}

bool AbsoluteSourceWatch::bears_state_out(const WatchedFix& fix) const noexcept {
  return state_ == SourceState::kDoubted && fix.witnessed && !fix.shaken &&
         (fix.measured - fix.predicted).squaredNorm() <=
             gate_ * (square(fix.deviation) + square(fix.predicted_deviation));
}

bool AbsoluteSourceWatch::agrees_with_motion(const WatchedFix& fix) const noexcept {
  // Whatever the yaw between the two frames, and without it: how far it is from the first.
  const double measured = (fix.measured - first_.measured).norm();
  const double reckoned = (fix.reckoned - first_.reckoned).norm();
  const double elapsed = fix.time - first_.time;
  const double drift = drift_speed(fix) * elapsed;
  return square(measured - reckoned) <=
         gate_ * (square(fix.deviation) + square(first_.deviation) +
                  square(parameters_.drift_share * (fix.way - first_.way)) + square(drift) +
                  square(fix.velocity_deviation * elapsed) + square(witness_.parts_by(elapsed)));
}

void AbsoluteSourceWatch::begin_candidate(const WatchedFix& fix) noexcept {
  first_ = fix;
  strayed_ = 0;
  within_ = 0;
  const double speed = std::hypot(fix.velocity_deviation, drift_speed(fix));
  track_ = TrackAlignment(speed, parameters_.drift_share);
  track_.add(fix.time, fix.measured, fix.reckoned, fix.deviation);
}

void AbsoluteSourceWatch::compare(const WatchedFix& fix) noexcept {
  if (track_.pairs() > 0 && fix.time <= track_.newest_time()) {
    return;
  }
  last_seen_ = fix.time;
  if (track_.pairs() == 0) {
    begin_candidate(fix);
  } else if (agrees_with_motion(fix)) {
    strayed_ = 0;
    track_.add(fix.time, fix.measured, fix.reckoned, fix.deviation);
  } else if (++strayed_ == parameters_.agreeing) {
    begin_candidate(fix);
  } else {
    return;
  }
  if (!within_reach(fix) && !goes_on(fix)) {
    within_ = 0;
  } else if (++within_ == 1) {
    first_within_ = fix.time;
  }
}

Verdict AbsoluteSourceWatch::judge(const WatchedFix& fix) noexcept {
  expire(fix.time);
  if (state_ == SourceState::kTrusted) {
    last_seen_ = std::isfinite(last_seen_) ? std::max(last_seen_, fix.time) : fix.time;
    return Verdict::kUse;
  }
  if (state_ == SourceState::kAbsent) {
    state_ = SourceState::kCandidate;
    track_ = TrackAlignment();
  }
  const std::size_t pairs = track_.pairs();
  compare(fix);
  if (track_.pairs() <= pairs) {
    return Verdict::kHold;
  }
  if (within_ >= parameters_.agreeing && fix.time - first_within_ >= parameters_.agreeing_time) {
    trust(fix.time, fix.way);
    return Verdict::kAcquire;
  }
  const bool borne_out = fix.borne_out >= parameters_.confirmation;
  const double needed = borne_out ? parameters_.confirmed_takeover : parameters_.takeover;
  if (within_ == 0 && !fix.contested && agreed_for() >= needed &&
      track_.pairs() >= parameters_.agreeing) {
    return Verdict::kTakeOver;
  }
  return bears_state_out(fix) ? Verdict::kUse : Verdict::kHold;
}

void AbsoluteSourceWatch::offer(const TrackPair& pair, double yaw,
                                const Eigen::Vector2d& innovation) noexcept {
  offered_[next_offered_] = {pair, yaw, innovation};
  next_offered_ = (next_offered_ + 1) % offered_.size();
}

void AbsoluteSourceWatch::note_accepted(double time, double way) noexcept {
  gated_running_ = 0;
  for (Offered& offered : offered_) {
    if (offered.pair.time == time) {
      witness_.learn(offered.pair, offered.yaw);
      correlation_.add(time, offered.innovation / offered.pair.deviation);
    }
  }
  last_accepted_ = std::isfinite(last_accepted_) ? std::max(last_accepted_, time) : time;
  if (state_ == SourceState::kTrusted) {
    trusted_since_ = last_accepted_;
    trusted_way_ = way;
  }
}

void AbsoluteSourceWatch::note_gated() noexcept {
  if (state_ == SourceState::kTrusted && ++gated_running_ >= parameters_.doubt_after) {
    state_ = SourceState::kDoubted;
    track_ = TrackAlignment();
    gated_running_ = 0;
  }
}

void AbsoluteSourceWatch::note_misfit(double time, double chi_square_per_degree) noexcept {
  // Slow, so that a few outliers change little; what is expected is below 1.
  constexpr double kRate = 0.05;
  constexpr double kUsual = 2;
  constexpr double kLargest = 5;
  const auto offered =
      std::ranges::find(offered_, time, [](const Offered& one) { return one.pair.time; });
  if (offered != offered_.end() && !ask_witness(offered->pair, offered->yaw).value_or(true)) {
    return;  // it goes elsewhere: that is no noise
  }
  const double misfit = std::min(chi_square_per_degree, kLargest);
  log_scale_ = std::clamp(log_scale_ + kRate * (misfit - kUsual), 0.0,
                          2 * std::log(parameters_.largest_deviation_factor));
}

double AbsoluteSourceWatch::covariance_scale(double spacing) const noexcept {
  return covariance_factor(correlation_time(), spacing) * std::exp(log_scale_);
}

double AbsoluteSourceWatch::correlation_time() const noexcept {
  return correlation_.time(parameters_.shortest_correlation_time, parameters_.correlation_time);
}

CorrelationFinding AbsoluteSourceWatch::correlation() const noexcept {
  return {.shortest = parameters_.shortest_correlation_time,
          .longest = parameters_.correlation_time,
          .used = correlation_time(),
          .most = correlation_.time(0, parameters_.correlation_time),
          .seen = correlation_.seen()};
}

double AbsoluteSourceWatch::deviation_factor() const noexcept {
  return std::exp(0.5 * log_scale_);
}

void AbsoluteSourceWatch::trust(double time, double way) noexcept {
  state_ = SourceState::kTrusted;
  last_seen_ = time;
  trusted_since_ = time;
  trusted_way_ = way;
  gated_running_ = 0;
  track_ = TrackAlignment();
  within_ = 0;
}

void AbsoluteSourceWatch::distrust(double time, double way) noexcept {
  state_ = SourceState::kAbsent;
  trusted_since_ = time;
  trusted_way_ = way;
  gated_running_ = 0;
  track_ = TrackAlignment();
  within_ = 0;
  witness_.forget();
}

void AbsoluteSourceWatch::expire(double time) noexcept {
  const double since = state_ == SourceState::kTrusted ? trusted_since_ : last_seen_;
  if (state_ != SourceState::kAbsent && time - since > parameters_.outage) {
    state_ = SourceState::kAbsent;
    track_ = TrackAlignment();
    within_ = 0;
  }
}

double AbsoluteSourceWatch::agreed_for() const noexcept {
  return track_.pairs() > 0 ? track_.newest_time() - track_.first_time() : 0;
}

}  // namespace pipescout::estimation
