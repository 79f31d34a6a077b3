// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "pipescout/simulation/crawler.hpp"
#include "pipescout/simulation/pipe_weave.hpp"
#include "wheel_fusion.hpp"

namespace pipescout::estimation_study {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;

constexpr std::size_t kCrawlerWheels = 3;
constexpr double kStanding = 5;            // s
constexpr double kLatency = 0.02;          // s, of a wheel's sample
constexpr double kWeldLatency = 0.3;       // s: a weld is known some way after it
constexpr double kWeldDeviation = 0.01;    // m
constexpr double kAcrossDeviation = 0.02;  // m
constexpr double kEase = 0.8;              // m, the crawler's length
constexpr double kStart = 3;               // m, chainage at which it stands
constexpr double kCommonScale = 0.003;     // of all wheels' scales, deviation
constexpr double kOwnScale = 0.002;        // of each, beside that
constexpr double kWheelNoise = 0.004;      // m per square root of metre
const Vector3d kWeldSensor(-0.3, 0, 0);    // m, in the body
constexpr simulation::PipeWeaveParameters kWeave{};

simulation::Motion drive(double duration, internal::Draw& draw) {
  std::vector<simulation::MotionLeg> legs{{.speed = 0, .duration = kStanding}};
  double sum = kStanding;
  while (sum < duration + 1) {
    legs.push_back({.speed = draw.uniform(0.25, 0.45), .duration = draw.uniform(30, 60)});
    sum += legs.back().duration;
    if (draw.happens(0.5)) {
      legs.push_back({.speed = 0, .duration = draw.uniform(3, 10)});
      sum += legs.back().duration;
    }
    if (draw.happens(0.2)) {
      legs.push_back({.speed = -0.3, .duration = draw.uniform(3, 8)});
      sum += legs.back().duration;
    }
  }
  return simulation::Motion(legs, 0.2);
}

simulation::CrawlerParameters wheels(internal::Draw& draw) {
  simulation::CrawlerParameters p;
  const double common = kCommonScale * draw.normal();
  for (std::size_t i = 0; i < kCrawlerWheels; ++i) {
    p.wheels.push_back({.period = 0.05,
                        .start = 0.005 * static_cast<double>(i),
                        .scale_error = common + kOwnScale * draw.normal(),
                        .noise_per_sqrt_metre = kWheelNoise,
                        .gravity_slip = 0.005});
  }
  p.slip_spacing = 50;
  p.slip_shortest = 0.5;
  p.slip_longest = 5;
  p.slip_least = 0.05;
  p.slip_most = 0.3;
  return p;
}

odometry::OdometerStreamParameters fusion() {
  odometry::OdometerStreamParameters p;
  p.odometers.assign(kCrawlerWheels,
                     {.resolution = 0.001, .sigma_per_sqrt_metre = kWheelNoise, .period = 0.05});
  p.window_distance = 0.5;
  p.lookback_windows = 0;
  p.maximum_delay = 0.2;
  return p;
}

/// The pieces of the motion with a chainage, m, at which it stands at the end: times of welds.
double time_at(const simulation::Motion& motion, double distance, double from, double to) {
  constexpr int kHalvings = 60;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (from + to) / 2;
    (motion.distance(middle) < distance ? from : to) = middle;
  }
  return (from + to) / 2;
}

}  // namespace

VehicleRun crawler_run(const RunOptions& options, std::uint64_t seed) {
  options.validate();
  VehicleRun run;
  run.vehicle = Vehicle::kCrawler;
  internal::Draw draw = internal::make_draw(seed, 13);
  internal::Recorder recorder(options, run, seed);
  const simulation::Motion motion = drive(options.duration, draw);
  const auto joints =
      static_cast<std::size_t>(std::ceil((motion.path(motion.duration()) + 20) / 11)) + 2;
  const simulation::JointedPipe pipe({.joints = joints, .bend_share = 0.2, .slope_share = 0.15},
                                     seed);
  const simulation::PipeRoute route(simulation::route_pieces(pipe), kEase, {0, 0, -2},
                                    draw.uniform(-3, 3));
  const simulation::PipeWeave weave(kWeave, seed);
  run.route = route.polyline(0.25);
  run.route_deviation = kWeave.deviation;
  run.route_correlation = kWeave.shortest_wavelength / 2;
  run.crab_deviation = kWeave.crab_deviation;
  run.odometer_scale_deviation =
      std::hypot(kCommonScale, kOwnScale / std::sqrt(static_cast<double>(kCrawlerWheels)));
  // Off along the pipe by the tally and by the detector.
  internal::Draw tally_draw = internal::make_draw(seed, 14);
  for (const simulation::Joint& joint : pipe.joints()) {
    run.tally.push_back(std::max(0.0, joint.begin + kWeldDeviation * tally_draw.normal()));
  }
  const auto body_at = [&](double time) {
    const double acceleration = motion.pieces()[motion.piece_at(time)].acceleration;
    simulation::BodyMotion body =
        weave.motion(route, kStart + motion.distance(time), motion.speed(time), acceleration);
    body.time = time;
    return body;
  };

  const SE3 begin = body_at(0).T_map_body;
  recorder.given({.time = 0,
                  .position = begin.translation() + 0.02 * draw.normals(),
                  .position_deviation = 0.02,
                  .heading = begin.rotation().roll_pitch_yaw()[2] + 0.01 * draw.normal(),
                  .heading_deviation = 0.01});

  simulation::CrawlerParameters crawler_parameters = wheels(draw);
  crawler_parameters.slip_spacing /= options.world ? options.world->slip : 1;
  simulation::Crawler crawler(pipe, motion, crawler_parameters, seed);
  odometry::OdometerStream stream(fusion());
  auto sample = crawler.next();
  double farthest = kStart + kWeldSensor.x();  // m, chainage of the weld sensor
  constexpr double kStep = 0.002;              // s
  const int steps = static_cast<int>(options.duration / kStep);
  for (int i = 0; i <= steps; ++i) {
    const double time = i * kStep;
    recorder.sample(body_at(time), motion.path(time));
    while (sample && sample->time <= time) {
      internal::push_wheel(
          stream, {.odometer = sample->wheel, .time = sample->time, .value = sample->value},
          kLatency, recorder);
      sample = crawler.next();
    }
    const double seen = kStart + motion.distance(time) + kWeldSensor.x();
    if (seen <= farthest) {
      continue;
    }
    for (std::size_t weld = 0; weld < pipe.joints().size(); ++weld) {
      const simulation::Joint& joint = pipe.joints()[weld];
      if (joint.begin > farthest && joint.begin <= seen) {
        const double at =
            time_at(motion, joint.begin - kStart - kWeldSensor.x(), time - kStep, time);
        // Across the pipe by how it was surveyed.
        const Vector3d off(0, kAcrossDeviation * draw.normal(), kAcrossDeviation * draw.normal());
        const simulation::BodyMotion there = route.motion(run.tally[weld], 1, 0);
        recorder.weld({.time = at,
                       .position = there.T_map_body * off,
                       .direction = there.velocity.normalized(),
                       .along_deviation = kWeldDeviation,
                       .across_deviation = std::hypot(kAcrossDeviation, kWeave.deviation),
                       .sensor = kWeldSensor},
                      at + kWeldLatency, joint.length);
      }
    }
    farthest = seen;
  }
  recorder.finish();
  return run;
}

}  // namespace pipescout::estimation_study
