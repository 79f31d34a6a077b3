// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry_study/elbow_score.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "pipescout/simulation/crawler.hpp"
#include "pipescout/statistics/draw.hpp"
#include "pipescout/statistics/normal.hpp"

namespace pipescout::odometry_study {
namespace {

using simulation::MotionLeg;
using simulation::PipeBend;
using statistics::Draw;
using std::numbers::pi;

constexpr double kSpeed = 0.3;          // m/s
constexpr double kAcceleration = 0.2;   // m/s^2
constexpr double kStraight = 15.0;      // m, on each side of the bend
constexpr double kClear = 3.0;          // m, between a bend and a slip
constexpr double kSamplePeriod = 0.05;  // s, of a wheel
constexpr std::uint64_t kDraws = 31;    // purpose of its random numbers

PipeBend draw_bend(const ElbowSettings& settings, Draw& draw) {
  PipeBend bend{.begin = kStraight + draw.uniform(0.0, 2.0)};
  bend.radius = settings.pipe_diameter * draw.uniform(settings.tightest, settings.widest);
  bend.angle = draw.happens(settings.standard_share) ? pi / 2 : draw.uniform(pi / 9, pi / 2);
  bend.direction = draw.uniform(-pi, pi);
  return bend;
}

/// Legs of a few metres, each with its speed; slower through the bend.
simulation::Motion draw_motion(const ElbowSettings& settings, const PipeBend& bend, Draw& draw) {
  std::vector<MotionLeg> legs;
  const double end = bend.end() + kStraight;
  const double in_bend =
      draw.happens(settings.slows_share) ? draw.uniform(settings.slowest_in_bend, 1.0) : 1.0;
  for (double at = 0.0; at < end;) {
    double length = draw.uniform(1.5, 4.5);
    const bool bent = at >= bend.begin && at < bend.end();
    if (at < bend.begin) {
      length = std::min(length, bend.begin - at + 1e-6);
    } else if (bent) {
      length = std::min(length, bend.end() - at + 1e-6);
    }
    const double speed =
        kSpeed * (bent ? in_bend : 1.0) * (1.0 + settings.speed_spread * draw.uniform(-1.0, 1.0));
    legs.push_back({.speed = speed, .duration = length / speed});
    at += length;
  }
  return {legs, kAcceleration};
}

std::vector<simulation::WheelFault> draw_slips(const ElbowSettings& settings, const PipeBend& bend,
                                               Draw& draw) {
  std::vector<simulation::WheelFault> slips;
  const auto burst = [&](double begin, double length) {
    slips.push_back({.wheel = draw.index(settings.wheels),
                     .begin = begin,
                     .length = length,
                     .ratio = draw.uniform(0.0, settings.slip_most)});
  };
  for (std::size_t i = 0; i < settings.slip_in_bend; ++i) {
    const double length = draw.uniform(0.3, 0.9) * bend.length();
    burst(bend.begin + draw.uniform(0.0, bend.length() - length), length);
  }
  if (settings.slip_every <= 0.0) {
    return slips;
  }
  for (double at = settings.slip_every * draw.exponential(); at < bend.end() + kStraight;) {
    const double length = draw.uniform(0.5, settings.slip_longest);
    const bool clear = at + length < bend.begin - kClear || at > bend.end() + kClear;
    if (clear || settings.slips_in_bends) {
      burst(at, length);
    }
    at += length + settings.slip_every * draw.exponential();
  }
  return slips;
}

struct Wheels {
  simulation::CrawlerParameters simulated;
  odometry::OdometerStreamParameters fused;
};

Wheels make_wheels(const ElbowSettings& settings, const PipeBend& bend, Draw& draw) {
  Wheels wheels;
  wheels.fused.rule = settings.rule;
  wheels.fused.circumference = {.radius = 0.5 * settings.pipe_diameter,
                                .clock_sigma = settings.clock_error};
  // Half a diameter: several windows in the tightest bend.
  wheels.fused.window_distance = std::clamp(0.5 * settings.pipe_diameter, 0.2, 1.0);
  wheels.fused.lookback_windows = settings.rule == odometry::FusionRule::kCircumference ? 16 : 8;
  for (std::size_t i = 0; i < settings.wheels; ++i) {
    const double clock = 2.0 * pi * static_cast<double>(i) / static_cast<double>(settings.wheels);
    wheels.simulated.wheels.push_back(
        {.period = kSamplePeriod,
         .start = kSamplePeriod * static_cast<double>(i) / static_cast<double>(settings.wheels),
         .scale_error = settings.scale_error * draw.normal(),
         .noise_per_sqrt_metre = settings.wheel_noise,
         .clock = clock + settings.clock_error * draw.normal(),
         .ahead = settings.out_of_plane * draw.normal()});
    odometry::OdometerParameters odometer{.resolution = wheels.simulated.wheels.back().resolution,
                                          .sigma_per_sqrt_metre = settings.wheel_noise,
                                          .clock = clock};
    odometer.correction.covariance(0, 0) = settings.scale_error * settings.scale_error;
    wheels.fused.odometers.push_back(odometer);
  }
  wheels.simulated.fittings = {.radius = 0.5 * settings.pipe_diameter, .bends = {bend}};
  wheels.simulated.roll = draw.uniform(-pi, pi);
  wheels.simulated.roll_per_metre = settings.roll_per_metre * draw.normal();
  return wheels;
}

void judge(const odometry::FoundBend& found, const PipeBend& bend, double window,
           ElbowScore& score) {
  constexpr double kLargestAngleError = pi / 18;
  const double middle_error = found.middle - bend.begin - 0.5 * bend.length();
  const double angle_error = found.angle - bend.angle;
  if (!score.found && std::abs(middle_error) < std::max(0.5 * bend.length(), window) &&
      std::abs(angle_error) < kLargestAngleError) {
    score.found = true;
    score.middle_error = middle_error;
    score.angle_error = angle_error;
  } else {
    ++score.others;
  }
}

}  // namespace

ElbowScore run_elbow(const ElbowSettings& settings, std::uint64_t seed) {
  Draw draw(seed, kDraws);
  const PipeBend bend = draw_bend(settings, draw);
  const auto motion = draw_motion(settings, bend, draw);
  const auto slips = draw_slips(settings, bend, draw);
  const Wheels wheels = make_wheels(settings, bend, draw);
  const simulation::JointedPipe pipe({.joints = 5, .bend_share = 0.0, .slope_share = 0.0}, seed);
  simulation::Crawler crawler(pipe, motion, wheels.simulated, seed, slips);
  odometry::OdometerStream stream(wheels.fused);
  const double window = wheels.fused.window_distance;
  const double from = bend.begin - 0.5;
  const double to = bend.end() + 2.0 * window + 0.2;

  struct Moment {
    double truth;
    double distance;
    double variance;
  };
  std::optional<Moment> first;
  std::optional<Moment> last;
  ElbowScore score;
  std::uint64_t bends = 0;
  while (const auto sample = crawler.next()) {
    if (stream.push({.odometer = sample->wheel, .time = sample->time, .value = sample->value})
            .ticks == 0) {
      continue;
    }
    const auto& state = stream.state();
    const Moment now{motion.distance(state.time), state.distance, state.random_variance};
    if (now.truth >= from && !first) {
      first = now;
    }
    if (now.truth >= to && !last) {
      last = now;
    }
    for (; bends < state.bends; ++bends) {
      judge(state.recent_bends[bends % odometry::kRecentBends], bend, window, score);
    }
    score.driven = now.truth;
  }
  const double truth = last->truth - first->truth;
  score.error = last->distance - first->distance - truth;
  // Scales err alike over the whole stretch.
  const double scale = settings.scale_error * truth;
  score.standard_deviation = std::sqrt(std::max(0.0, last->variance - first->variance) +
                                       scale * scale / static_cast<double>(settings.wheels));
  return score;
}

ElbowScores& ElbowScores::operator+=(const ElbowScores& other) {
  errors.insert(errors.end(), other.errors.begin(), other.errors.end());
  inside += other.inside;
  found += other.found;
  others += other.others;
  driven += other.driven;
  return *this;
}

ElbowScores run_elbows(const ElbowSettings& settings, std::uint64_t seed, std::size_t count) {
  Draw draw(seed, kDraws);
  ElbowScores scores;
  for (std::size_t i = 0; i < count; ++i) {
    const ElbowScore score = run_elbow(settings, draw.seed());
    const double error = std::abs(score.error);
    scores += {.errors = {error},
               .inside = error <= statistics::kNormal95 * score.standard_deviation ? 1U : 0U,
               .found = score.found ? 1U : 0U,
               .others = score.others,
               .driven = score.driven};
  }
  return scores;
}

}  // namespace pipescout::odometry_study
