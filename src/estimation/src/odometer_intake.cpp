// SPDX-License-Identifier: Apache-2.0
#include "odometer_intake.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::estimation {
namespace {

constexpr std::size_t kMostReadings = 8 * StateEstimator::kMostWaiting;
/// Forgotten at once, so that few are moved on average.
constexpr std::size_t kForgotten = kMostReadings / 8;

/// Part of the way from a to b at `time`.
double part(const OdometerReading& a, const OdometerReading& b, double time) {
  return std::clamp((time - a.time) / (b.time - a.time), 0.0, 1.0);
}

}  // namespace

OdometerIntake::OdometerIntake(const OdometerUse& use) : use_(use) {
  readings_.reserve(kMostReadings);
}

double OdometerIntake::newest() const noexcept {
  auto place = readings_.end();
  while (place != readings_.begin()) {
    if (!left_out(--place)) {
      return place->time;
    }
  }
  return std::numeric_limits<double>::quiet_NaN();
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
  if (reading.time <= forgotten_ + kSame) {
    return Outcome::kLate;
  }
  auto place = readings_.end();
  while (place != readings_.begin() && (place - 1)->time > reading.time + kSame) {
    --place;
  }
  if (place != readings_.begin() && (place - 1)->time > reading.time - kSame) {
    return Outcome::kDuplicate;
  }
  if (readings_.size() == kMostReadings) {
    constexpr auto kFew = static_cast<std::ptrdiff_t>(kForgotten);
    if (place - readings_.begin() < kFew) {
      return Outcome::kLate;
    }
    forgotten_ = readings_[kForgotten - 1].time;
    place = readings_.erase(readings_.begin(), readings_.begin() + kFew) +
            (place - readings_.begin() - kFew);
  }
  readings_.insert(place, reading);
  return Outcome::kWaiting;
}

bool OdometerIntake::usable(const OdometerReading& r) const noexcept {
  return r.status == OdometerStatus::kGood ||
         (r.status == OdometerStatus::kNoConsensus && use_.no_consensus_factor > 0);
}

bool OdometerIntake::agree(const OdometerReading& a, const OdometerReading& b) const noexcept {
  const double duration = b.time - a.time;
  // A counter that starts again from zero may do so with the vehicle at any speed; steps of the
  // counter itself must not look like one.
  constexpr double kStep = 0.05;  // m
  return duration <= use_.largest_gap &&
         std::abs(b.distance - a.distance) <= use_.largest_speed * duration + kStep;
}

bool OdometerIntake::joined(const OdometerReading& a, const OdometerReading& b) const noexcept {
  return usable(a) && usable(b) && agree(a, b);
}

bool OdometerIntake::left_out(Place reading) const noexcept {
  constexpr std::ptrdiff_t kNeighbours = 2;  // to either side
  if (!usable(*reading)) {
    return false;
  }
  int against = 0;
  const auto ask = [&](const OdometerReading& a, const OdometerReading& b) {
    if (usable(a) && usable(b) && b.time - a.time <= use_.largest_gap) {
      against += agree(a, b) ? -1 : 1;
    }
  };
  const std::ptrdiff_t before = std::min(kNeighbours, reading - readings_.begin());
  const std::ptrdiff_t after = std::min(kNeighbours, readings_.end() - reading - 1);
  for (std::ptrdiff_t k = 1; k <= before; ++k) {
    ask(*(reading - k), *reading);
  }
  for (std::ptrdiff_t k = 1; k <= after; ++k) {
    ask(*reading, *(reading + k));
  }
  return against > 0;
}

std::optional<OdometerIntake::Increment> OdometerIntake::between(double from,
                                                                 double to) const noexcept {
  // From the last reading up to `from` to the first one not before `to`.
  auto b = std::partition_point(readings_.begin(), readings_.end(),
                                [&](const auto& r) { return r.time <= from; });
  auto a = b;
  do {
    if (a == readings_.begin()) {
      return std::nullopt;
    }
    --a;
  } while (left_out(a));
  if (!(from < to)) {
    return std::nullopt;
  }
  Increment sum;
  double variance = 0;
  bool consensus = true;
  for (; b != readings_.end(); ++b) {
    if (left_out(b)) {
      sum.left_out += b->time <= to ? 1 : 0;
      continue;
    }
    if (!joined(*a, *b)) {
      return std::nullopt;
    }
    const double share = part(*a, *b, to) - part(*a, *b, from);
    sum.distance += share * (b->distance - a->distance);
    variance += share * std::max(b->variance - a->variance, 0.0);
    consensus = consensus && a->status == OdometerStatus::kGood && b->status == a->status;
    if (b->time >= to) {
      const double proportional = use_.share * sum.distance;
      sum.deviation =
          std::sqrt(variance + use_.deviation * use_.deviation + proportional * proportional);
      if (!consensus) {
        sum.deviation *= use_.no_consensus_factor;
      }
      return sum;
    }
    a = b;
  }
  return std::nullopt;
}

std::size_t OdometerIntake::after(double time) const noexcept {
  const auto first = std::ranges::upper_bound(readings_, time, {}, &OdometerReading::time);
  return static_cast<std::size_t>(readings_.end() - first);
}

bool OdometerIntake::is_full_after(double time) const noexcept {
  return readings_.size() == kMostReadings && readings_[kForgotten - 1].time > time;
}

std::optional<OdometerIntake::Motion> OdometerIntake::motion(double now,
                                                             double window) const noexcept {
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
