// SPDX-License-Identifier: Apache-2.0
#include "pipescout/crawler_simulation/simulated_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace pipescout {

namespace {

simulation::JointedPipe make_pipe(const SimulatedRunParameters& parameters, const Tally& tally) {
  if (parameters.start_joint >= tally.joints.size()) {
    throw std::invalid_argument("start_joint: " + std::to_string(parameters.start_joint) +
                                " is outside [0, " + std::to_string(tally.joints.size()) + ")");
  }
  std::vector<double> lengths;
  for (std::size_t i = parameters.start_joint; i < tally.joints.size(); ++i) {
    lengths.push_back(tally.joints[i].length);
  }
  return {parameters.pipe, lengths, parameters.seed};
}

/// The bends of the route as the wheels meet them, from the start of the drive on.
simulation::PipeFittings make_fittings(const SimulatedRunParameters& parameters, double start) {
  simulation::PipeFittings fittings{.radius = parameters.pipe_radius};
  double begin = -start;
  for (const simulation::RoutePiece& piece : parameters.route) {
    const double rate = std::hypot(piece.heading_rate, piece.pitch_rate);
    if (rate > 0.0 && begin + piece.length > 0.0) {
      const double length = std::min(piece.length, begin + piece.length);
      fittings.bends.push_back({.begin = std::max(begin, 0.0),
                                .radius = 1.0 / rate,
                                .angle = rate * length,
                                .direction = std::atan2(-piece.heading_rate, piece.pitch_rate)});
    }
    begin += piece.length;
  }
  return fittings;
}

simulation::Crawler make_crawler(const SimulatedRunParameters& parameters, const Tally& tally) {
  simulation::JointedPipe pipe = make_pipe(parameters, tally);
  simulation::InspectionParameters motion = parameters.motion;
  motion.length = std::min(motion.length, pipe.length());
  simulation::CrawlerParameters crawler = parameters.crawler;
  if (parameters.pipe_radius != 0.0) {
    crawler.fittings = make_fittings(parameters, tally.chainages[parameters.start_joint]);
  }
  return {std::move(pipe), simulation::draw_inspection(motion, parameters.seed + 1),
          std::move(crawler), parameters.seed + 2};
}

simulation::EddyCurrentSignal make_signal(const SimulatedRunParameters& parameters,
                                          const simulation::JointedPipe& pipe) {
  std::vector<double> welds;
  for (const simulation::Joint& joint : pipe.joints()) {
    welds.push_back(joint.begin);
  }
  welds.push_back(pipe.length());
  simulation::PipeParameters features = parameters.features;
  features.length = pipe.length();
  features.joint_length = std::min(features.joint_length, features.length);
  return {parameters.signal, simulation::draw_features(features, welds, parameters.seed + 3),
          parameters.seed + 4};
}

/// m over which the crawler takes a change of bend: about its length.
constexpr double kEase = 0.5;

simulation::PipeRoute make_route(const SimulatedRunParameters& parameters) {
  constexpr double kAnyLength = 1.0;  // straight on beyond its end
  const std::vector<simulation::RoutePiece> straight{simulation::RoutePiece::straight(kAnyLength)};
  return {parameters.route.empty() ? straight : parameters.route, kEase};
}

}  // namespace

SimulatedRun::SimulatedRun(const SimulatedRunParameters& parameters, const Tally& tally)
    : start_joint_(parameters.start_joint),
      start_chainage_(parameters.start_joint < tally.chainages.size()
                          ? tally.chainages[parameters.start_joint]
                          : 0.0),
      sample_interval_(1.0 / parameters.signal.sample_rate),
      crawler_(make_crawler(parameters, tally)),
      signal_(make_signal(parameters, crawler_.pipe())),
      pending_(crawler_.next()),
      route_(make_route(parameters)) {
  if (parameters.imu) {
    imu_.emplace(*parameters.imu, parameters.seed + 5);
  }
}

std::vector<SimulatedRun::Readings> SimulatedRun::readings_until(double time) {
  std::vector<Readings> result;
  for (; pending_ && pending_->time <= time; pending_ = crawler_.next()) {
    if (result.empty() || result.back().time != pending_->time) {
      result.push_back({.time = pending_->time});
    }
    result.back().wheels.push_back(pending_->wheel);
    result.back().values.push_back(pending_->value);
  }
  return result;
}

std::vector<std::complex<double>> SimulatedRun::samples_until(double time) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::complex<double>> result;
  for (; next_sample_time() <= time; ++samples_) {
    const auto sample = signal_.next(crawler_.motion().distance(next_sample_time()));
    const bool missing = sample.fault == simulation::SampleFault::kMissing;
    result.push_back(missing ? std::complex<double>(kNan, kNan) : sample.value);
  }
  return result;
}

SimulatedRun::Position SimulatedRun::position(double time) const noexcept {
  const double distance = crawler_.motion().distance(std::max(time, 0.0));
  const std::size_t joint = crawler_.pipe().joint_at(distance);
  return {.joint = start_joint_ + joint,
          .into_joint = distance - crawler_.pipe().joints()[joint].begin,
          .chainage = start_chainage_ + distance,
          .distance = distance};
}

simulation::BodyMotion SimulatedRun::body_motion(double time) const {
  const simulation::Motion& motion = crawler_.motion();
  const bool moves = time >= 0.0 && time < motion.duration();
  simulation::BodyMotion result =
      route_.motion(position(time).chainage, moves ? motion.speed(time) : 0.0,
                    moves ? motion.pieces()[motion.piece_at(time)].acceleration : 0.0);
  result.time = time;
  return result;
}

std::vector<SimulatedRun::ImuSample> SimulatedRun::imu_samples_until(double time) {
  std::vector<ImuSample> result;
  if (!imu_) {
    return result;
  }
  if (!next_imu_sample_) {
    next_imu_sample_ = time;
  }
  for (; *next_imu_sample_ <= time; *next_imu_sample_ += imu_->parameters().period) {
    const simulation::BodyMotion truth = body_motion(*next_imu_sample_);
    result.push_back({.time = *next_imu_sample_,
                      .reading = imu_->measure({.angular_rate = truth.angular_rate,
                                                .specific_force = truth.specific_force()})});
  }
  return result;
}

}  // namespace pipescout
