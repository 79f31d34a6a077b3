// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "pipescout/statistics/draw.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

using statistics::exponential;
using statistics::make_engine;
using statistics::uniform;
using validation::check_above;
using validation::check_within;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kShortestDrive = 0.01;  // m
constexpr double kLargestSpeed = 1e3;    // m/s

double gone(const MotionPiece& piece, double since) {
  return (piece.speed + 0.5 * piece.acceleration * since) * since;
}

}  // namespace

Motion::Motion(const std::vector<MotionLeg>& legs, double acceleration) {
  check_above("legs", static_cast<double>(legs.size()), 0, kInfinity);
  check_above("acceleration", acceleration, 0.0, kInfinity);
  double speed = 0.0;
  for (std::size_t i = 0; i < legs.size(); ++i) {
    const std::string prefix = "legs[" + std::to_string(i) + "].";
    check_within(prefix + "speed", legs[i].speed, -kLargestSpeed, kLargestSpeed);
    check_above(prefix + "duration", legs[i].duration, 0.0, kInfinity);
    double left = legs[i].duration;
    if (speed * legs[i].speed < 0.0) {  // through zero: two pieces
      const double braking = std::min(left, std::abs(speed) / acceleration);
      add(braking, speed > 0.0 ? -acceleration : acceleration);
      left -= braking;
      speed = left > 0.0 ? 0.0 : speed + pieces_.back().acceleration * braking;
    }
    const double change = legs[i].speed - speed;
    const double changing = std::min(left, std::abs(change) / acceleration);
    add(changing, change > 0.0 ? acceleration : -acceleration);
    left -= changing;
    // Set, not added up: a leg that is long enough has exactly its speed.
    speed = left > 0.0 ? legs[i].speed
                       : speed + (change > 0.0 ? acceleration : -acceleration) * changing;
    if (left > 0.0) {
      add(left, 0.0);
      pieces_.back().speed = legs[i].speed;
    }
  }
}

void Motion::add(double duration, double acceleration) {
  if (duration <= 0.0) {
    return;
  }
  MotionPiece piece{.begin = duration_, .duration = duration, .acceleration = acceleration};
  if (!pieces_.empty()) {
    const MotionPiece& last = pieces_.back();
    const double step = gone(last, last.duration);
    piece.distance = last.distance + step;
    piece.path = last.path + std::abs(step);
    piece.speed = last.speed + last.acceleration * last.duration;
  }
  // A piece that starts from rest must not start with what rounding left of the speed before.
  if (std::abs(piece.speed) < 1e-12) {
    piece.speed = 0.0;
  }
  pieces_.push_back(piece);
  duration_ += duration;
}

std::size_t Motion::piece_at(double time) const noexcept {
  const auto after =
      std::upper_bound(pieces_.begin(), pieces_.end(), time,
                       [](double value, const MotionPiece& piece) { return value < piece.begin; });
  return after == pieces_.begin() ? 0 : static_cast<std::size_t>(after - pieces_.begin()) - 1;
}

double Motion::distance(double time) const noexcept {
  const MotionPiece& piece = pieces_[piece_at(time)];
  const double since = std::clamp(time - piece.begin, 0.0, piece.duration);
  const double beyond = std::max(0.0, time - duration_);
  return piece.distance + gone(piece, since) + beyond * speed(duration_);
}

double Motion::path(double time) const noexcept {
  const MotionPiece& piece = pieces_[piece_at(time)];
  const double since = std::clamp(time - piece.begin, 0.0, piece.duration);
  const double beyond = std::max(0.0, time - duration_);
  return piece.path + std::abs(gone(piece, since)) + beyond * std::abs(speed(duration_));
}

double Motion::speed(double time) const noexcept {
  const MotionPiece& piece = pieces_[piece_at(time)];
  return piece.speed + piece.acceleration * std::clamp(time - piece.begin, 0.0, piece.duration);
}

void InspectionParameters::validate() const {
  check_above("length", length, 0.0, kInfinity);
  check_above("speed", speed, 0.0, kLargestSpeed);
  check_within("speed_spread", speed_spread, 0.0, 0.5);
  check_above("acceleration", acceleration, 0.0, kInfinity);
  check_above("stop_spacing", stop_spacing, 0.0, kInfinity);
  check_above("stop_duration", stop_duration, 0.0, kInfinity);
  check_within("reverse_share", reverse_share, 0.0, 0.9);
  check_above("reverse_distance", reverse_distance, 0.0, kInfinity);
}

Motion draw_inspection(const InspectionParameters& parameters, std::uint64_t seed) {
  parameters.validate();
  auto engine = make_engine(seed, 4);
  std::vector<MotionLeg> legs;
  double ahead = 0.0;  // m
  const auto drive = [&](double distance) {
    const double speed =
        parameters.speed * (1.0 + uniform(engine, -1.0, 1.0) * parameters.speed_spread);
    // Braking, which the stop that follows begins with, makes good what getting up to speed costs.
    const double duration = std::max(std::abs(distance) / speed,
                                     std::sqrt(std::abs(distance) / parameters.acceleration));
    legs.push_back({.speed = distance < 0.0 ? -speed : speed, .duration = duration});
    ahead += distance;
  };
  while (ahead < parameters.length) {
    drive(std::min(parameters.stop_spacing * exponential(engine) + kShortestDrive,
                   parameters.length - ahead));
    legs.push_back({.speed = 0.0,
                    .duration = parameters.stop_duration * exponential(engine) +
                                2.0 * parameters.speed / parameters.acceleration});
    if (uniform(engine) < parameters.reverse_share) {
      drive(-std::min(parameters.reverse_distance * exponential(engine) + kShortestDrive,
                      0.5 * ahead));
      legs.push_back({.speed = 0.0, .duration = 2.0 * parameters.speed / parameters.acceleration});
    }
  }
  return Motion(legs, parameters.acceleration);
}

}  // namespace pipescout::simulation
