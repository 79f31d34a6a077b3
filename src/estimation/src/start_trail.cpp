// SPDX-License-Identifier: Apache-2.0
#include "start_trail.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::estimation {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;

namespace {

constexpr double kStep = 0.1;  // s
constexpr std::size_t kMostSteps = 640;
/// Forgotten at once, so that few are moved on average: what is left is a minute.
constexpr std::size_t kForgottenSteps = 40;
constexpr double kLongestTrailGap = 0.2;  // s
constexpr double kCreeping = 0.05;        // m/s
constexpr double kTurning = 0.05;         // rad/s, more than noise and bias of a gyro

}  // namespace

StartTrail::StartTrail() {
  steps_.reserve(kMostSteps);
}

void StartTrail::forget() noexcept {
  steps_.clear();
  settled_ = false;
}

void StartTrail::add(const ImuSample& sample) {
  if (settled_ || (!empty() && !(std::abs(sample.time - end_) <= kLongestTrailGap))) {
    forget();
  }
  if (empty()) {
    end_ = sample.time;
  }
  const double until = sample.time + sample.duration;
  if (empty() || steps_.back().duration >= kStep) {
    if (steps_.size() == kMostSteps) {
      steps_.erase(steps_.begin(), steps_.begin() + kForgottenSteps);
    }
    steps_.push_back({.time = end_});
  }
  Step& step = steps_.back();
  // Over a short gap it goes on turning.
  step.turn = step.turn * SO3::exp((until - end_) * sample.angular_rate);
  step.duration = until - step.time;
  end_ = until;
}

StartTrail::Way StartTrail::way_of(const Step& step, const Motion& motion,
                                   const OdometerIntake& odometer) {
  const double end = step.time + step.duration;
  const bool stands = step.time >= motion.stands_from;
  if (const auto moved = odometer.between(step.time, end)) {
    const double scale = motion.odometer_scale;
    return {.distance = scale * moved->distance,
            .variance = stands ? 0 : scale * scale * moved->deviation * moved->deviation};
  }
  if (stands) {
    return {};
  }
  const double speed = motion.speed.value_or(0);
  if (end > odometer.newest()) {  // it comes a little late
    return {.distance = speed * step.duration, .deviation = motion.speed_deviation * step.duration};
  }
  return {.distance = speed * step.duration,
          .deviation = std::max(motion.speed_deviation, std::abs(speed)) * step.duration};
}

void StartTrail::settle(const SE3& end, const Motion& motion, const OdometerIntake& odometer) {
  settled_ = true;
  last_ = {.pose = end};
  Place next = last_;
  double variance = 0;
  double shared = 0;
  for (std::size_t i = steps_.size(); i-- > 0;) {
    Step& step = steps_[i];
    const Way way = way_of(step, motion, odometer);
    const SO3 turn = step.turn * SO3::exp(-step.duration * motion.gyro_bias);
    const SO3& after = next.pose.rotation();
    const SO3 before = after * turn.inverse();
    const SO3 middle = before * SO3::exp(0.5 * turn.log());
    const Vector3d wheel =
        next.pose.translation() + after * motion.sensor - way.distance * (middle * motion.travel);
    const double turned = step.duration * motion.gyro_bias_deviation;
    variance += way.variance;
    shared += way.deviation;
    next = {.pose = SE3(before, wheel - before * motion.sensor),
            .position_deviation = std::sqrt(variance) + shared,
            .heading_deviation = next.heading_deviation + turned};
    step.begin = next;
    if (i == 0) {
      const double speed =
          (std::abs(way.distance) + std::sqrt(way.variance) + way.deviation) / step.duration;
      const double rate = turn.log().norm() / step.duration;
      const bool parked = way.deviation == 0 &&
                          std::abs(way.distance) <= kCreeping * step.duration &&
                          (step.time >= motion.stands_from || rate <= kTurning);
      speed_before_ = parked ? 0 : speed;
      rate_before_ = parked ? 0 : rate + motion.gyro_bias_deviation;
    }
  }
}

void StartTrail::move(const SE3& by) {
  for (Step& step : steps_) {
    step.begin.pose = by * step.begin.pose;
  }
  last_.pose = by * last_.pose;
}

std::optional<StartTrail::Place> StartTrail::at(double time) const {
  if (!settled_ || empty() || !(time <= end_)) {
    return std::nullopt;
  }
  if (time < begins()) {
    Place place = steps_.front().begin;
    place.position_deviation += (begins() - time) * speed_before_;
    place.heading_deviation += (begins() - time) * rate_before_;
    return place;
  }
  const auto after = std::ranges::upper_bound(steps_, time, {}, &Step::time);
  const Place& a = (after - 1)->begin;
  const Place& b = after == steps_.end() ? last_ : after->begin;
  const double part = std::clamp((time - (after - 1)->time) / (after - 1)->duration, 0.0, 1.0);
  const auto between = [part](double from, double to) { return (1 - part) * from + part * to; };
  const SO3 turn = SO3::exp(part * (a.pose.rotation().inverse() * b.pose.rotation()).log());
  return Place{.pose = SE3(a.pose.rotation() * turn,
                           (1 - part) * a.pose.translation() + part * b.pose.translation()),
               .position_deviation = between(a.position_deviation, b.position_deviation),
               .heading_deviation = between(a.heading_deviation, b.heading_deviation)};
}

}  // namespace pipescout::estimation
