// SPDX-License-Identifier: Apache-2.0
#include "pipe_bends.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace pipescout::odometry::internal {
namespace {

constexpr double kFirstSpread = 0.1;    // of the logarithm of the speed, before any is known
constexpr double kLeastSpread = 0.01;   // counts and noise of a window
constexpr double kSpreadGain = 0.1;     // about ten windows
constexpr double kLargestChange = 0.5;  // of the logarithm of the speed: a stop, not a change
constexpr double kTurnSigmas = 4.0;     // beyond which a window belongs to another event
constexpr double kTurnShare = 0.15;     // rad, about: the crawler may roll within a bend
constexpr double kChangeShare =
    0.05;  // of the curvature: its mean over parts of a bend is the same
constexpr std::size_t kLeastToDivide =
    4;  // windows: two within, and those where it begins and ends

constexpr double kSameDirection = 0.866;  // cosine of 30 degrees: parts of one bend

// Of a bend vector to the distance: a bend is no ideal arc.
constexpr double kRatioDeviation = 0.01;

double sum_of(const std::array<double, kMaxOdometers>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

double speed_of(const WheelSums& window) {
  return window.duration > 0.0 ? std::abs(window.travelled) / window.duration : 0.0;
}

}  // namespace

BendFinder::BendFinder(const OdometerStreamParameters& parameters)
    : circumference_(parameters),
      smallest_bend_(parameters.circumference.smallest_bend),
      speed_spread_(kFirstSpread) {}

/// Whether the window's bend vector points where that of the event does.
bool BendFinder::goes_on(const Event& event, const WheelSums& window) const {
  WheelSums joint = event.sums;
  joint.add(window);
  if (joint.wheels.count() < 3 || event.sums.travelled * window.travelled <= 0.0) {
    return false;
  }
  const auto before = circumference_.bend_vector(event.sums);
  const auto now = circumference_.bend_vector(window);
  const double length = before.value.norm();
  const double along = before.value.dot(now.value) / length;
  const double across =
      std::abs(before.value[0] * now.value[1] - before.value[1] * now.value[0]) / length;
  // The direction of the event is known as well as its length allows.
  const double deviation = std::hypot(now.deviation, along / length * before.deviation);
  return along > -kTurnSigmas * now.deviation &&
         across <= kTurnSigmas * deviation + kTurnShare * std::abs(along);
}

/// Not known of an event that is no bend, or too short to have a window that is all within it.
BendBefore BendFinder::bend_of(const Event& event) const {
  const Explanation explanation = explain(event, false);
  if (explanation.bend < 0.5) {
    return event.before;
  }
  const WheelSums& inner = event.windows > 2 ? event.inner : event.latest;
  if (event.windows < 2 || inner.travelled == 0.0) {
    return {};
  }
  const auto vector = circumference_.bend_vector(inner);
  return {.known = true,
          .ratio = vector.value / inner.travelled,
          .deviation = vector.deviation / std::abs(inner.travelled) + kRatioDeviation};
}

Explanation BendFinder::explain(const Event& event, bool complete) const {
  return circumference_.explain(event.sums, event.speeds, event.before,
                                complete && !event.before.known);
}

Explanation BendFinder::explain(const WheelSums& window) const {
  const Circumference::Speeds speeds{
      .before = last_speed_, .first = window, .spread = speed_spread_};
  const Explanation alone = circumference_.explain(window, speeds, {}, false);
  if (!event_ || alone.straight > 0.5) {
    return alone;
  }
  if (!goes_on(*event_, window)) {
    return circumference_.explain(window, {}, bend_of(*event_), false);
  }
  WheelSums sums = event_->sums;
  sums.add(window);
  return circumference_.explain(sums, event_->speeds, event_->before, false);
}

void BendFinder::join(const WheelSums& window, double begin) {
  Event& event = *event_;
  if (event.windows == 0) {
    event.sums = window;
  } else {
    event.sums.add(window);
  }
  // The first and the last window may reach out of the event, so that the speeds of its ends are
  // those of the windows next to them.
  if (event.windows < 2) {
    event.speeds.first = event.sums;
    event.speeds.last = event.sums;
  } else {
    event.speeds.last = event.latest;
  }
  if (event.windows == 2) {
    event.inner = event.latest;
    event.speeds.first = event.latest;
  } else if (event.windows > 2) {
    event.inner.add(event.latest);
  }
  event.latest = window;
  if (event.windows < kMostEventWindows) {
    event.all[event.windows] = {window, begin};
  }
  ++event.windows;
  const double length = circumference_.bend_vector(window).value.norm();
  const double middle = begin + 0.5 * window.travelled;
  event.mass += length;
  event.moment += length * middle;
  event.second += length * middle * middle;
  event.spacing = std::abs(window.travelled);
}

void BendFinder::Judgements::judge(const Judgement& judgement) {
  if (judgements < judged.size()) {
    judged[judgements++] = judgement;
  }
}

void BendFinder::Judgements::find(const std::optional<FoundBend>& bend) {
  if (bend && bends < found.size()) {
    found[bends++] = *bend;
  }
}

/// Where a fault begins or ends within a bend, whose curvature is constant: the first window after
/// the change that is most significant; 0: none. The windows where the bend begins and ends are
/// parts of it, and do not count.
std::size_t BendFinder::find_change(const Event& event) const {
  if (event.windows < kLeastToDivide || event.windows > kMostEventWindows) {
    return 0;
  }
  std::size_t change = 0;
  double most = 1.0;  // of what is allowed
  WheelSums before = event.all[1].sums;
  for (std::size_t k = 2; k + 1 < event.windows; ++k) {
    WheelSums after = event.all[k].sums;
    for (std::size_t l = k + 1; l + 1 < event.windows; ++l) {
      after.add(event.all[l].sums);
    }
    if (before.wheels.count() >= 3 && after.wheels.count() >= 3 &&
        before.travelled * after.travelled > 0.0) {
      const auto one = circumference_.bend_vector(before);
      const auto other = circumference_.bend_vector(after);
      const Eigen::Vector2d ratio = one.value / before.travelled;
      const double difference = (other.value / after.travelled - ratio).norm();
      const double deviation =
          std::hypot(one.deviation / before.travelled, other.deviation / after.travelled);
      const double share = difference / (kTurnSigmas * deviation + kChangeShare * ratio.norm());
      if (share > most) {
        most = share;
        change = k;
      }
    }
    before.add(event.all[k].sums);
  }
  return change;
}

/// `later`: windows after the event, as `Judgement` has them.
void BendFinder::finish(double speed_after, std::size_t later, Judgements& result) {
  if (const std::size_t first = find_change(*event_); first > 0) {
    divide(first, speed_after, later, result);
    return;
  }
  event_->speeds.after = speed_after;
  const Explanation explanation = explain(*event_, true);
  if (!previous_ || !revise(*event_, explanation, later, result)) {
    result.judge({.explanation = explanation, .windows = event_->windows, .later = later});
    before_ = bend_of(*event_);
    passage_before_previous_ = passage_;
    pass(*event_, explanation, result);
  }
  previous_ = std::exchange(event_, std::nullopt);
  last_speed_ = 0.0;
}

/// Into two events, the second of which begins with the window `first`.
void BendFinder::divide(std::size_t first, double speed_after, std::size_t later,
                        Judgements& result) {
  const Event whole = *event_;
  const auto take = [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      join(whole.all[k].sums, whole.all[k].begin);
    }
  };
  event_.emplace();
  event_->before = whole.before;
  event_->speeds.before = whole.speeds.before;
  event_->speeds.spread = whole.speeds.spread;
  take(0, first);
  finish(0.0, later + whole.windows - first, result);
  start_event();
  take(first, whole.windows);
  finish(speed_after, later, result);
}

/// A fault may have ended within a bend: then the event before it is the bend of this one and a
/// fault. A wheel that slips loses, so that one of the two orders explains the change.
bool BendFinder::revise(const Event& event, const Explanation& explanation, std::size_t later,
                        Judgements& result) {
  Event alone = event;
  alone.before = {};
  const Explanation bent = explain(alone, true);
  const BendBefore after = bend_of(alone);
  if (bent.bend < 0.5 || !event.before.known || !after.known) {
    return false;
  }
  Event former = *previous_;
  former.before = after;
  const Explanation revised = explain(former, true);
  if (sum_of(revised.both) <= std::max(0.5, sum_of(explanation.both)) || !revised.consistent) {
    return false;
  }
  result.judge({.explanation = revised, .windows = former.windows, .later = later + event.windows});
  result.judge({.explanation = bent, .windows = event.windows, .later = later});
  before_ = after;
  passage_ = passage_before_previous_;
  pass(former, revised, result);
  passage_before_previous_ = passage_;
  pass(alone, bent, result);
  return true;
}

void BendFinder::start_event() {
  event_.emplace();
  event_->before = before_;
  event_->speeds.before = last_speed_;
  event_->speeds.spread = speed_spread_;
}

/// Adds an event to the bend that it is part of.
void BendFinder::pass(const Event& event, const Explanation& explanation, Judgements& result) {
  const double bent = explanation.bend + sum_of(explanation.both);
  if (!(bent > 0.5) || !explanation.consistent || event.mass <= 0.0) {
    return;
  }
  const auto vector = circumference_.bend_vector(event.sums, explanation);
  // Of bend vectors of a reversing crawler the sign is that of the travel.
  const Eigen::Vector2d value = event.sums.travelled < 0.0 ? -vector.value : vector.value;
  if (passage_ &&
      passage_->vector.dot(value) < kSameDirection * passage_->vector.norm() * value.norm()) {
    result.find(end_passage());
  }
  if (!passage_) {
    passage_.emplace();
  }
  const double share = value.norm() / event.mass;
  passage_->vector += value;
  passage_->variance += vector.deviation * vector.deviation;
  passage_->mass += share * event.mass;
  passage_->moment += share * event.moment;
  passage_->second += share * event.second;
  passage_->spacing = event.spacing;
  passage_->probability = std::min(passage_->probability, bent);
}

std::optional<FoundBend> BendFinder::end_passage() {
  if (!passage_) {
    return std::nullopt;
  }
  const Passage passage = *passage_;
  passage_.reset();
  const double radius = circumference_.radius();
  const double angle = passage.vector.norm() / radius;
  if (angle < smallest_bend_) {
    return std::nullopt;
  }
  FoundBend bend;
  bend.angle = angle;
  bend.angle_standard_deviation = std::sqrt(passage.variance) / radius;
  bend.direction = std::atan2(passage.vector[1], passage.vector[0]);
  bend.middle = passage.moment / passage.mass;
  // A bend of constant curvature has the second moment L^2 / 12; each window adds its own.
  const double moment = passage.second / passage.mass - bend.middle * bend.middle -
                        passage.spacing * passage.spacing / 12.0;
  bend.length = std::max(std::sqrt(12.0 * std::max(0.0, moment)),
                         angle * radius / circumference_.largest_ratio());
  bend.middle_standard_deviation = passage.spacing / std::sqrt(12.0);
  bend.probability = passage.probability;
  return bend;
}

BendFinder::Judgements BendFinder::note(const WheelSums& window, double begin) {
  Judgements result;
  const double speed = speed_of(window);
  const Circumference::Speeds speeds{
      .before = last_speed_, .first = window, .spread = speed_spread_};
  const Explanation alone = circumference_.explain(window, speeds, {}, false);
  const bool plain = alone.straight > 0.5 || window.wheels.count() < 3;
  if (event_ && (plain || !goes_on(*event_, window))) {
    finish(plain ? speed : 0.0, 1, result);
  }
  if (plain) {
    before_ = {};
    previous_.reset();
    result.find(end_passage());
    if (last_speed_ > 0.0 && speed > 0.0) {
      const double change = std::abs(std::log(speed / last_speed_));
      if (change < kLargestChange) {
        speed_spread_ =
            std::max(kLeastSpread, speed_spread_ + kSpreadGain * (change - speed_spread_));
      }
    }
    last_speed_ = speed;
    result.judge({.explanation = alone, .windows = 1});
    return result;
  }
  if (!event_) {
    start_event();
  }
  join(window, begin);
  result.judge({.explanation = explain(*event_, false), .windows = event_->windows});
  return result;
}

}  // namespace pipescout::odometry::internal
