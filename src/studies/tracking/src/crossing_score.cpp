// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking_study/crossing_score.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "pipescout/statistics/draw.hpp"

namespace pipescout::tracking_study {
namespace {

using statistics::Draw;
using tracking::PipeRegion;
using tracking::PipeShape;
using tracking::TrackState;

constexpr std::uint64_t kCrossingDraws = 47;  // purpose of the random numbers
constexpr tracking::ImageSize kCrossingImage{.width = 320, .height = 240};

/// A tube whose axis moves across itself; its middle sways along.
struct CrossingTube {
  double angle = 0.0;                                  // rad
  Eigen::Vector2d meeting = Eigen::Vector2d::Zero();   // px, where it is when they meet
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  // px/s
  double length = 150.0;                               // px
  double half_width = 5.0;                             // px

  [[nodiscard]] PipeShape::State at(double time) const {
    const Eigen::Vector2d middle = meeting + time * velocity;
    return {middle.x(), middle.y(), length, angle};
  }
};

PipeRegion seen_tube(const CrossingTube& tube, double time, double noise, Draw& draw) {
  const PipeShape::State state = tube.at(time);
  const Eigen::Vector2d half =
      0.5 * tube.length * Eigen::Vector2d(std::cos(tube.angle), std::sin(tube.angle));
  const auto end = [&](double sign) {
    return Eigen::Vector2d(state[0] + sign * half.x() + noise * draw.normal(),
                           state[1] + sign * half.y() + noise * draw.normal());
  };
  return {.start = end(-1.0), .end = end(1.0), .half_width = tube.half_width};
}

/// px, of the middle of one from the axis of the other, and of the angle at its end.
double apart(const PipeShape::State& estimate, const CrossingTube& tube, double time) {
  const PipeShape::State truth = tube.at(time);
  const double across = std::abs((truth[1] - estimate[1]) * std::cos(truth[3]) -
                                 (truth[0] - estimate[0]) * std::sin(truth[3]));
  const double turned = std::abs(std::remainder(estimate[3] - truth[3], std::numbers::pi));
  return across + 0.5 * tube.length * std::sin(turned);
}

}  // namespace

CrossingScore& CrossingScore::operator+=(const CrossingScore& other) {
  crossings += other.crossings;
  swaps += other.swaps;
  lost += other.lost;
  tracked_hidden += other.tracked_hidden;
  return *this;
}

CrossingScore score_crossing(const tracking::PipeTrackerParameters& parameters,
                             const CrossingSettings& settings, std::uint64_t seed) {
  Draw draw(seed, kCrossingDraws);
  const bool parallel = draw.happens(settings.parallel_share);
  const bool hides_tracked = draw.happens(0.5);
  CrossingTube tracked{.angle = draw.uniform(-0.3, 0.3),
                       .meeting = {160.0, 120.0},
                       .velocity = {draw.uniform(-3.0, 3.0), draw.uniform(-6.0, 6.0)},
                       .length = draw.uniform(140.0, 200.0)};
  const double side = draw.happens(0.5) ? 1.0 : -1.0;
  const CrossingTube other{
      .angle = tracked.angle + (parallel ? 0.0 : side * draw.uniform(0.1, 0.8)),
      .meeting = tracked.meeting,
      .velocity = tracked.velocity + Eigen::Vector2d(0.0, side * draw.uniform(6.0, 20.0)),
      .length = tracked.length * draw.uniform(0.7, 0.95),
      .half_width = tracked.half_width * draw.uniform(0.8, 1.25)};
  const double hidden_from = -settings.hidden * draw.uniform(0.2, 0.8);
  tracking::PipeTracker tracker({}, parameters, draw.seed());
  std::vector<PipeRegion> regions;
  const auto frames = static_cast<int>((settings.before + settings.after) * settings.frame_rate);
  double time = 0.0;
  for (int frame = 0; frame <= frames; ++frame) {
    time = frame / settings.frame_rate - settings.before;
    const bool hidden = time >= hidden_from && time < hidden_from + settings.hidden;
    regions.clear();
    // The longest is taken up: that it is the tracked one.
    if (!hidden || !hides_tracked) {
      regions.push_back(seen_tube(tracked, time, settings.noise, draw));
    }
    if (!hidden || hides_tracked) {
      regions.push_back(seen_tube(other, time, settings.noise, draw));
    }
    tracking::TrackingFrame<PipeShape> input{
        .time = time + settings.before, .image = kCrossingImage, .regions = regions};
    if (settings.odometry) {
      input.motion = tracking::ImageMotion{.at = tracker.track().estimate.head<2>(),
                                           .velocity = tracked.velocity};
    }
    tracker.update(input);
  }
  CrossingScore score{.crossings = 1, .tracked_hidden = hides_tracked ? 1U : 0U};
  const auto& track = tracker.track();
  const double own = apart(track.estimate, tracked, time);
  const double foreign = apart(track.estimate, other, time);
  constexpr double kOn = 10.0;  // px
  score.swaps = foreign < own ? 1 : 0;
  score.lost = track.state != TrackState::kLocked || std::min(own, foreign) > kOn ? 1 : 0;
  return score;
}

}  // namespace pipescout::tracking_study
