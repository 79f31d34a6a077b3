// SPDX-License-Identifier: Apache-2.0
#include "odometer_intake.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::estimation {
namespace {

constexpr std::size_t kMostReadings = 512;

/// Part of the way from a to b at `time`.
double part(const OdometerReading& a, const OdometerReading& b, double time) {
  return std::clamp((time - a.time) / (b.time - a.time), 0.0, 1.0);
}

}  // namespace

OdometerIntake::OdometerIntake(const OdometerUse& use) : use_(use) {
  readings_.reserve(kMostReadings);
}

double OdometerIntake::newest() const noexcept {
  return readings_.empty() ? std::numeric_limits<double>::quiet_NaN() : readings_.back().time;
}

Outcome OdometerIntake::add(const OdometerReading& reading) noexcept {
  constexpr double kSame = 1e-6;
  if (!(std::isfinite(reading.time) && std::isfinite(reading.distance) &&
        std::isfinite(reading.variance))) {
    return Outcome::kNotFinite;
  }
  if (reading.variance < 0) {
    return Outcome::kBadCovariance;
  }
  auto place = readings_.end();
  while (place != readings_.begin() && (place - 1)->time > reading.time + kSame) {
    --place;
  }
  if (place != readings_.begin() && (place - 1)->time > reading.time - kSame) {
    return Outcome::kDuplicate;
  }
  if (readings_.size() == kMostReadings) {
    if (place == readings_.begin()) {
      return Outcome::kLate;
    }
    const auto moved = place - 1;
    std::move(readings_.begin() + 1, place, readings_.begin());
    *moved = reading;
  } else {
    readings_.insert(place, reading);
  }
  return Outcome::kWaiting;
}

bool OdometerIntake::joined(const OdometerReading& a, const OdometerReading& b) const noexcept {
  const auto usable = [&](const OdometerReading& r) {
    return r.status == OdometerStatus::kGood ||
           (r.status == OdometerStatus::kNoConsensus && use_.no_consensus_factor > 0);
  };
  const double duration = b.time - a.time;
  // A counter that starts again from zero may do so with the vehicle at any speed; steps of the
  // counter itself must not look like one.
  constexpr double kStep = 0.05;  // m
  return usable(a) && usable(b) && duration <= use_.largest_gap &&
         std::abs(b.distance - a.distance) <= use_.largest_speed * duration + kStep;
}

std::optional<OdometerIntake::Increment> OdometerIntake::between(double from,
                                                                 double to) const noexcept {
  // From the first reading after `from` to the first one not before `to`.
  const auto first = std::partition_point(readings_.begin(), readings_.end(),
                                          [&](const auto& r) { return r.time <= from; });
  const auto last =
      std::partition_point(first, readings_.end(), [&](const auto& r) { return r.time < to; });
  if (!(from < to) || first == readings_.begin() || last == readings_.end()) {
    return std::nullopt;
  }
  double distance = 0;
  double variance = 0;
  bool consensus = true;
  for (auto b = first; b <= last; ++b) {
    const OdometerReading& a = *(b - 1);
    if (!joined(a, *b)) {
      return std::nullopt;
    }
    const double share = part(a, *b, to) - part(a, *b, from);
    distance += share * (b->distance - a.distance);
    variance += share * std::max(b->variance - a.variance, 0.0);
    consensus = consensus && a.status == OdometerStatus::kGood && b->status == a.status;
  }
  const double proportional = use_.share * distance;
  double deviation =
      std::sqrt(variance + use_.deviation * use_.deviation + proportional * proportional);
  if (!consensus) {
    deviation *= use_.no_consensus_factor;
  }
  return Increment{distance, deviation};
}

std::optional<OdometerIntake::Motion> OdometerIntake::motion(double window) const noexcept {
  if (readings_.empty()) {
    return std::nullopt;
  }
  const double now = newest();
  const auto before = between(now - window, now - 0.5 * window);
  const auto after = between(now - 0.5 * window, now);
  if (!before || !after) {
    return std::nullopt;
  }
  const double half = 0.5 * window;
  const double acceleration = (after->distance - before->distance) / (half * half);
  return Motion{.speed = after->distance / half + 0.5 * half * acceleration,
                .acceleration = acceleration};
}

}  // namespace pipescout::estimation
