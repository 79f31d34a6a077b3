// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry_study/crawler_run.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <numbers>

#include "pipescout/odometry/odometer_stream.hpp"
#include "pipescout/simulation/crawler.hpp"
#include "pipescout/statistics/draw.hpp"

namespace pipescout::odometry_study {
namespace {

using statistics::Engine;
using statistics::normal;
using statistics::uniform;

using std::numbers::pi;

constexpr double kEventSpacing = 0.1;       // m, path
constexpr std::uint64_t kOfTheList = 0x6c;  // purpose of the errors of the bends in the tally

bool happens(Engine& engine, double probability) {
  return uniform(engine, 0.0, 1.0) < probability;
}

simulation::JointedPipe lay_pipe(const CrawlerRunSettings& settings, std::uint64_t seed) {
  return simulation::JointedPipe({.joints = settings.joints,
                                  .joint_length = settings.joint_length,
                                  .length_spread = settings.joint_spread,
                                  .tally_sigma = settings.tally_sigma,
                                  .tally_wrong = settings.wrong_lengths,
                                  .tally_missing = settings.missing_joints,
                                  .tally_extra = settings.extra_joints},
                                 seed);
}

void write_down(const simulation::JointedPipe& pipe, const CrawlerRunSettings& settings,
                CrawlerRun& run) {
  for (const auto& joint : pipe.joints()) {
    run.welds.push_back(joint.begin);
  }
  run.welds.push_back(pipe.length());
  for (const auto& entry : pipe.tally()) {
    run.tally.push_back({entry.length, settings.tally_sigma});
    run.weld_of_tally.push_back(
        entry.error == simulation::TallyError::kExtra ? -1 : static_cast<int>(entry.joint));
  }
  run.weld_of_tally.push_back(static_cast<int>(pipe.joints().size()));
}

simulation::Motion drive(const CrawlerRunSettings& settings, std::uint64_t seed) {
  return simulation::draw_inspection({.length = settings.run_length,
                                      .reverse_share = settings.reverse_share,
                                      .reverse_distance = settings.reverse_distance},
                                     seed);
}

/// Bends of 1.5 to 5 diameters; after each other one the pipe goes up or down and comes back.
simulation::PipeFittings draw_fittings(const CrawlerRunSettings& settings, Engine& engine,
                                       CrawlerRun& run) {
  constexpr double kHalf = 0.5;
  simulation::PipeFittings fittings{.radius = kHalf * settings.pipe_diameter};
  const double spacing = settings.run_length / static_cast<double>(settings.bends + 1);
  const auto add = [&](double begin, double angle, double direction) {
    fittings.bends.push_back({.begin = begin,
                              .radius = settings.pipe_diameter * uniform(engine, 1.5, 5.0),
                              .angle = angle,
                              .direction = direction});
    const double end = fittings.bends.back().end();
    run.bends.push_back({.begin = begin, .end = end, .angle = angle});
    return end;
  };
  for (std::size_t i = 0; i < settings.bends; ++i) {
    const double begin = spacing * (static_cast<double>(i) + uniform(engine, 0.7, 1.3));
    if (i % 4 == 2 && i + 1 < settings.bends) {  // up or down, and level again
      const double up = happens(engine, 0.5) ? 1.0 : -1.0;
      const double direction = up > 0.0 ? 0.0 : pi;
      const double end = add(begin, pi / 2, direction);
      const double length = uniform(engine, 3.0, 20.0);
      fittings.rises.push_back({.begin = end, .length = length, .pitch = up * pi / 2});
      add(end + length, pi / 2, direction + pi);
      ++i;
    } else {
      const double angle = happens(engine, 0.6) ? pi / 2 : uniform(engine, pi / 9, pi / 2);
      add(begin, angle, uniform(engine, -pi, pi));
    }
  }
  for (std::size_t i = 0; i < settings.tees; ++i) {
    const double at = settings.run_length * (static_cast<double>(i) + uniform(engine, 0.2, 0.8)) /
                      static_cast<double>(settings.tees);
    fittings.tees.push_back({.position = at,
                             .radius = fittings.radius * uniform(engine, 0.2, 0.8),
                             .direction = uniform(engine, -pi, pi)});
  }
  return fittings;
}

/// Lists the bends as a tally does, by joint and distance.
void list_bends(const CrawlerRunSettings& settings, Engine& engine, CrawlerRun& run) {
  for (const BendPassage& bend : run.bends) {
    const double ahead = 0.5 * (bend.begin + bend.end);
    const double place = settings.backward ? run.start - ahead : run.start + ahead;
    const auto weld = std::ranges::upper_bound(run.welds, place) - 1;
    const auto joint =
        std::ranges::find(run.weld_of_tally, static_cast<int>(weld - run.welds.begin()));
    if (joint == run.weld_of_tally.end()) {
      continue;
    }
    run.tally_bends.push_back(
        {.joint = static_cast<std::size_t>(joint - run.weld_of_tally.begin()),
         .distance = place - *weld + settings.tally_bend_sigma * normal(engine),
         .standard_deviation = settings.tally_bend_sigma,
         .angle = std::min(bend.angle + settings.tally_angle_sigma * normal(engine), pi),
         .angle_standard_deviation = settings.tally_angle_sigma});
  }
}

/// Bursts of one wheel at a time, apart from those of two wheels.
std::vector<simulation::WheelFault> draw_slips(const CrawlerRunSettings& settings, double path,
                                               Engine& engine, CrawlerRun& run) {
  std::vector<simulation::WheelFault> slips;
  for (std::size_t i = 0; i < settings.double_slips; ++i) {
    const double spacing = path / static_cast<double>(settings.double_slips + 1);
    simulation::WheelFault slip{
        .wheel = 0,
        .begin = (static_cast<double>(i) + uniform(engine, 0.6, 1.4)) * spacing,
        .length = uniform(engine, 2.0, settings.slip_longest + 1.0),
        .ratio = uniform(engine, settings.double_slip_least, settings.slip_most)};
    run.double_slips.push_back(
        {.begin = slip.begin, .end = slip.begin + slip.length, .lost = slip.length * slip.ratio});
    slips.push_back(slip);
    slip.wheel = 1;
    slips.push_back(slip);
  }
  const std::vector<simulation::WheelFault> doubles = slips;
  constexpr double kShortest = 0.5;  // m
  for (double at = settings.slip_every * statistics::exponential(engine); at < path;) {
    const simulation::WheelFault slip{.wheel = static_cast<std::size_t>(uniform(
                                          engine, 0.0, static_cast<double>(settings.wheels))),
                                      .begin = at,
                                      .length = uniform(engine, kShortest, settings.slip_longest),
                                      .ratio = uniform(engine, 0.0, settings.slip_most)};
    at += slip.length + settings.slip_every * statistics::exponential(engine);
    const bool clear = std::none_of(doubles.begin(), doubles.end(), [&slip](const auto& other) {
      constexpr double kApart = 1.0;  // m
      return slip.begin < other.begin + other.length + kApart &&
             other.begin < slip.begin + slip.length + kApart;
    });
    if (clear) {
      slips.push_back(slip);
    }
  }
  return slips;
}

/// `middle`: m, true distance from the start.
void note_bend(double middle, double angle, const CrawlerRunSettings& settings, CrawlerRun& run) {
  constexpr double kLargestAngleError = pi / 18;
  const auto bend = std::ranges::find_if(run.bends, [&](const BendPassage& passage) {
    return middle > passage.begin - settings.window_distance &&
           middle < passage.end + settings.window_distance;
  });
  if (bend == run.bends.end()) {
    ++run.false_bends;
  } else {
    bend->found = bend->found || std::abs(angle - bend->angle) < kLargestAngleError;
  }
}

struct Wheels {
  simulation::CrawlerParameters simulated;
  odometry::OdometerStreamParameters fused;
  double scale_error = 0.0;  ///< mean of the wheels
  double wear_per_metre = 0.0;
};

Wheels make_wheels(const CrawlerRunSettings& settings, double path, Engine& engine) {
  Wheels wheels;
  const auto count = static_cast<double>(settings.wheels);
  wheels.fused.window_distance = settings.window_distance;
  wheels.fused.lookback_windows = settings.lookback_windows;
  wheels.fused.rule = settings.rule;
  wheels.fused.circumference = {.radius = 0.5 * settings.pipe_diameter,
                                .clock_sigma = settings.clock_error};
  const double common = settings.common_scale_error * normal(engine);
  for (std::size_t i = 0; i < settings.wheels; ++i) {
    const double wear = settings.wear * (1.0 + settings.wear_difference * normal(engine)) / path;
    const double scale = common + settings.radius_error * normal(engine);
    wheels.simulated.wheels.push_back(
        {.period = settings.sample_period,
         // They do not know of each other.
         .start = settings.sample_period * static_cast<double>(i) / count,
         .scale_error = scale,
         .wear_per_metre = wear,
         .noise_per_sqrt_metre = settings.wheel_noise});
    wheels.scale_error += scale / count;
    wheels.wear_per_metre += wear / count;
    odometry::OdometerParameters odometer{
        .resolution = wheels.simulated.wheels.back().resolution,
        .sigma_per_sqrt_metre = settings.stated_noise_part * settings.wheel_noise,
        .clock = 2.0 * pi * static_cast<double>(i) / count};
    odometer.correction.covariance(0, 0) =
        std::pow(settings.radius_error, 2) + std::pow(settings.wear * settings.wear_difference, 2);
    wheels.fused.odometers.push_back(odometer);
  }
  return wheels;
}

/// What the fused odometer and the welds become on the way.
class Recorder {
 public:
  Recorder(const CrawlerRunSettings& settings, const Wheels& wheels, Engine& engine,
           CrawlerRun& run)
      : settings_(settings), wheels_(wheels), engine_(engine), run_(run) {
    for (const double weld : run.welds) {
      const double ahead = settings.backward ? run.start - weld : weld - run.start;
      if (ahead > 0.0) {
        ahead_.push_back(ahead);
      }
    }
    std::sort(ahead_.begin(), ahead_.end());
  }

  /// A bend that has been found; after the tick in which it was.
  void tell_bend(const odometry::FoundBend& bend) {
    CrawlerRunEvent event = now_;
    event.is_bend = true;
    event.bend = {.odometer_distance = bend.middle,
                  .standard_deviation = bend.middle_standard_deviation,
                  .angle = std::min(bend.angle, pi),
                  .angle_standard_deviation = bend.angle_standard_deviation};
    run_.events.push_back(event);
  }

  /// `distance`, `path`: true, m, since the start.
  void tick(const odometry::FusedStream& fused, double distance, double path) {
    pass_welds(fused.distance, distance, path);
    for (DoubleSlip& slip : run_.double_slips) {
      slip.doubted = slip.doubted || (fused.status == odometry::StreamStatus::kNoConsensus &&
                                      path > slip.begin && path < slip.end + kEventSpacing);
    }
    now_ = {.place = settings_.backward ? run_.start - distance : run_.start + distance,
            .path = path,
            .scale = 1.0 / (1.0 + wheels_.scale_error + wheels_.wear_per_metre * path),
            .joints_passed = passed_};
    odometer_ = fused.distance;
    distance_ = distance;
    const bool due = !pending_.empty() && pending_.front().due <= path;
    if (due || path >= told_path_ + kEventSpacing) {
      tell_increment(fused);
    }
    while (!pending_.empty() && pending_.front().due <= path) {
      CrawlerRunEvent event = now_;
      event.is_weld = true;
      event.spurious = pending_.front().spurious;
      event.weld = {.odometer_distance = pending_.front().odometer,
                    .standard_deviation = settings_.weld_sigma};
      run_.events.push_back(event);
      pending_.pop_front();
    }
  }

 private:
  struct Pending {
    double due;  // m, path
    double odometer;
    bool spurious;
  };

  void tell_increment(const odometry::FusedStream& fused) {
    // What was taken back of the variance is told of no stretch that follows.
    const double variance = std::max(0.0, fused.random_variance - told_variance_);
    CrawlerRunEvent event = now_;
    event.increment = {fused.distance - told_distance_, variance};
    run_.events.push_back(event);
    told_distance_ = fused.distance;
    told_variance_ += variance;
    told_path_ = now_.path;
  }

  void pass_welds(double odometer, double distance, double path) {
    const auto odometer_at = [&](double ahead) {
      const double part = (ahead - distance_) / (distance - distance_);
      return odometer_ + part * (odometer - odometer_);
    };
    const auto low = std::upper_bound(ahead_.begin(), ahead_.end(), std::min(distance, distance_));
    const auto high = std::upper_bound(low, ahead_.end(), std::max(distance, distance_));
    for (auto weld = low; weld != high; ++weld) {
      const bool new_ground = static_cast<std::size_t>(weld - ahead_.begin()) == passed_;
      passed_ += new_ground ? 1 : 0;
      if ((new_ground || settings_.detects_on_old_ground) && !happens(engine_, settings_.missed)) {
        pending_.push_back({path + settings_.detector_lag,
                            odometer_at(*weld) + settings_.weld_sigma * normal(engine_), false});
      }
    }
    if (distance > farthest_) {
      if (happens(engine_, settings_.spurious * (distance - farthest_) / settings_.joint_length)) {
        pending_.push_back({path + settings_.detector_lag,
                            odometer_at(uniform(engine_, farthest_, distance)), true});
      }
      farthest_ = distance;
    }
  }

  const CrawlerRunSettings& settings_;
  const Wheels& wheels_;
  Engine& engine_;
  CrawlerRun& run_;
  std::vector<double> ahead_;  // m, of the start, welds in the order in which they are passed
  std::deque<Pending> pending_;
  CrawlerRunEvent now_;
  std::size_t passed_ = 0;
  double odometer_ = 0.0;  // at the tick before
  double distance_ = 0.0;
  double farthest_ = 0.0;
  double told_distance_ = 0.0;
  double told_variance_ = 0.0;
  double told_path_ = 0.0;
};

}  // namespace

CrawlerRun simulate_crawler_run(const CrawlerRunSettings& settings, std::uint64_t seed) {
  Engine engine(seed);
  CrawlerRun run;
  const auto pipe = lay_pipe(settings, seed);
  write_down(pipe, settings, run);
  const auto motion = drive(settings, seed);
  const double path = motion.path(motion.duration());
  constexpr double kMargin = 0.5;  // m
  const double spare = std::max(pipe.length() - settings.run_length - 10.0, 0.0);
  const double margin = uniform(engine, kMargin, kMargin + 0.9 * spare);
  run.start = settings.backward ? pipe.length() - margin : margin;

  const auto slips = draw_slips(settings, path, engine, run);
  auto wheels = make_wheels(settings, path, engine);
  if (settings.bends + settings.tees > 0) {
    wheels.simulated.fittings = draw_fittings(settings, engine, run);
    Engine listing = statistics::make_engine(seed, kOfTheList);
    list_bends(settings, listing, run);
    wheels.simulated.roll = uniform(engine, -pi, pi);
    wheels.simulated.roll_per_metre = settings.roll_per_metre;
    for (std::size_t i = 0; i < settings.wheels; ++i) {
      wheels.simulated.wheels[i].gravity_slip = settings.gravity_slip;
      wheels.simulated.wheels[i].clock =
          wheels.fused.odometers[i].clock + settings.clock_error * normal(engine);
    }
  }
  // Its chainage counts from the start of the run: these wheels do not depend on the slope.
  simulation::Crawler crawler(pipe, motion, wheels.simulated, seed, slips);
  odometry::OdometerStream stream(wheels.fused);
  Recorder recorder(settings, wheels, engine, run);
  std::uint64_t bends = 0;
  while (const auto sample = crawler.next()) {
    const auto pushed =
        stream.push({.odometer = sample->wheel, .time = sample->time, .value = sample->value});
    if (pushed.ticks > 0) {
      const auto& fused = stream.state();
      recorder.tick(fused, motion.distance(fused.time), motion.path(fused.time));
      if (fused.bends > bends) {
        bends = fused.bends;
        const double behind = fused.distance - fused.bend.middle;
        note_bend(motion.distance(fused.time) - behind, fused.bend.angle, settings, run);
        recorder.tell_bend(fused.bend);
      }
    }
  }
  return run;
}

}  // namespace pipescout::odometry_study
