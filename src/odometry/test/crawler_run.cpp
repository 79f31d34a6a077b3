// SPDX-License-Identifier: Apache-2.0
#include "crawler_run.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "pipescout/odometry/consensus_fusion.hpp"

namespace pipescout::odometry::test {
namespace {

constexpr std::size_t kWheels = 3;

using Engine = std::mt19937_64;

double uniform(Engine& engine, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(engine);
}

double normal(Engine& engine, double sigma) {
  return std::normal_distribution<double>(0.0, 1.0)(engine) * sigma;
}

/// The pipe and its tally, with the tally's errors well apart from each other.
void lay_pipe(const CrawlerRunSettings& settings, Engine& engine, CrawlerRun& run) {
  const std::size_t errors =
      settings.wrong_lengths + settings.missing_joints + settings.extra_joints;
  run.welds.push_back(0.0);
  run.weld_of_tally.push_back(0);
  std::size_t next_error = 0;
  for (std::size_t j = 0; j < settings.joints; ++j) {
    const auto draw = [&] {
      return settings.joint_length + normal(engine, settings.joint_spread * settings.joint_length);
    };
    const auto in_pipe = [&](double length) {
      run.welds.push_back(run.welds.back() + length);
      return static_cast<int>(run.welds.size()) - 1;
    };
    const auto in_tally = [&](double length, int weld) {
      run.tally.push_back({length + normal(engine, settings.tally_sigma), settings.tally_sigma});
      run.weld_of_tally.push_back(weld);
    };
    const bool error_here =
        next_error < errors && j == (next_error + 1) * settings.joints / (errors + 1);
    const double length = draw();
    if (!error_here) {
      in_tally(length, in_pipe(length));
      continue;
    }
    // Kinds take turns, as long as there are some of each.
    std::array<std::size_t, 3> left = {settings.wrong_lengths, settings.missing_joints,
                                       settings.extra_joints};
    std::size_t kind = 0;
    for (std::size_t i = 0, done = 0; done <= next_error; i = (i + 1) % 3) {
      if (left[i] > 0) {
        --left[i];
        ++done;
        kind = i;
      }
    }
    ++next_error;
    if (kind == 0) {
      const double wrong = uniform(engine, 0.3, 1.0) * (uniform(engine, 0.0, 1.0) < 0.5 ? -1 : 1);
      in_tally(length + wrong, in_pipe(length));
    } else if (kind == 1) {
      in_pipe(length);
      const double after = draw();
      // The weld between the two joints is not in the tally, nor is the first of them.
      run.weld_of_tally.back() = static_cast<int>(run.welds.size()) - 1;
      in_tally(after, in_pipe(after));
    } else {
      in_tally(length, static_cast<int>(run.welds.size()) - 1);
      run.weld_of_tally[run.weld_of_tally.size() - 2] = -1;
    }
  }
}

struct Slip {
  double from = 0.0;  // m, path
  double to = 0.0;
  double lost = 0.0;
  std::array<bool, kWheels> wheels{};
};

std::vector<Slip> draw_slips(const CrawlerRunSettings& settings, Engine& engine, double path) {
  std::vector<Slip> slips;
  if (settings.slip_every > 0.0) {
    std::exponential_distribution<double> gap(1.0 / settings.slip_every);
    for (double at = gap(engine); at < path;) {
      Slip slip{.from = at,
                .to = at + uniform(engine, 0.5, settings.slip_length),
                .lost = uniform(engine, 0.0, settings.slip_most)};
      slip.wheels[std::uniform_int_distribution<std::size_t>(0, kWheels - 1)(engine)] = true;
      slips.push_back(slip);
      at = slip.to + gap(engine);
    }
  }
  return slips;
}

/// Signed steps of the crawler: straight on, with stretches back and on again.
std::vector<double> draw_motion(const CrawlerRunSettings& settings, Engine& engine) {
  std::vector<double> steps;
  const auto go = [&](double distance) {
    const auto count = static_cast<std::size_t>(std::abs(distance) / settings.step);
    steps.insert(steps.end(), count, std::copysign(settings.step, distance));
  };
  const double part = settings.run_length / static_cast<double>(settings.reversals + 1);
  for (std::size_t i = 0; i <= settings.reversals; ++i) {
    go(part);
    if (i < settings.reversals) {
      const double back = uniform(engine, 5.0, 40.0);
      go(-back);
      go(back);
    }
  }
  return steps;
}

}  // namespace

CrawlerRun simulate_crawler_run(const CrawlerRunSettings& settings, std::uint64_t seed) {
  Engine engine(seed);
  CrawlerRun run;
  lay_pipe(settings, engine, run);
  const double pipe = run.welds.back();
  const double spare = std::max(pipe - settings.run_length - 1.0, 0.0);
  const double facing = settings.backward ? -1.0 : 1.0;
  const double margin = uniform(engine, 0.5, 0.5 + spare * 0.9);
  double place = run.start = settings.backward ? pipe - margin : margin;

  const auto steps = draw_motion(settings, engine);
  const double path = settings.step * static_cast<double>(steps.size());
  auto slips = draw_slips(settings, engine, path);
  for (std::size_t i = 0; i < settings.double_slips; ++i) {
    const double at = (static_cast<double>(i) + uniform(engine, 0.6, 1.4)) * path /
                      static_cast<double>(settings.double_slips + 1);
    Slip slip{.from = at,
              .to = at + uniform(engine, 2.0, settings.slip_length + 1.0),
              .lost = uniform(engine, settings.double_slip_least, settings.slip_most),
              .wheels = {true, true, false}};
    slip.lost *= uniform(engine, 0.0, 1.0) < 0.5 ? -1.0 : 1.0;
    slips.push_back(slip);
    run.double_slip_lost.push_back(0.0);
    run.double_slip_end.push_back(0.0);
  }
  const std::size_t first_double = slips.size() - settings.double_slips;

  std::array<double, kWheels> radius{};
  std::array<double, kWheels> wear{};
  const double common = normal(engine, settings.common_scale_error);
  for (std::size_t w = 0; w < kWheels; ++w) {
    radius[w] = common + normal(engine, settings.radius_error);
    wear[w] = settings.wear * (1.0 + normal(engine, settings.wear_difference));
  }
  const double bend = uniform(engine, 0.5, 2.0);  // wear comes late or early

  const double stated = settings.stated_noise_part * settings.wheel_noise;
  const double window_sigma =
      std::sqrt(stated * stated * settings.step + settings.resolution * settings.resolution / 6.0 +
                std::pow(settings.radius_error * settings.step, 2));
  const ConsensusFusion fusion({.epsilon = 0.95});
  std::array<double, kWheels> reading{};
  std::array<double, kWheels> shown{};
  double odometer = 0.0;
  double gone = 0.0;
  double farthest = 0.0;
  struct Pending {
    double at_path;
    bool spurious;
    double odometer;
  };
  std::vector<Pending> pending;
  const auto crossed = [&](double weld, double from, double to) {
    return (weld > std::min(from, to)) && (weld <= std::max(from, to));
  };
  std::size_t passed = 0;
  std::size_t near_weld = 0;
  while (near_weld + 1 < run.welds.size() && run.welds[near_weld + 1] <= place) {
    ++near_weld;
  }

  for (const double step : steps) {
    const double before = place;
    place += facing * step;
    gone += std::abs(step);
    const bool new_ground = std::abs(place - run.start) > farthest + 1e-9;
    farthest = std::max(farthest, std::abs(place - run.start));
    const double worn = std::pow(gone / path, bend);
    std::array<OdometerReading, kWheels> readings;
    double mean_rate = 0.0;
    for (std::size_t w = 0; w < kWheels; ++w) {
      double rate = 1.0 + radius[w] + wear[w] * worn;
      mean_rate += rate / static_cast<double>(kWheels);
      for (const Slip& slip : slips) {
        if (slip.wheels[w] && gone > slip.from && gone <= slip.to) {
          rate *= 1.0 - slip.lost;
        }
      }
      reading[w] += step * rate + normal(engine, settings.wheel_noise * std::sqrt(std::abs(step)));
      const double now = std::round(reading[w] / settings.resolution) * settings.resolution;
      readings[w] = {.distance = now - shown[w], .standard_deviation = window_sigma};
      shown[w] = now;
    }
    for (std::size_t i = first_double; i < slips.size(); ++i) {
      if (gone > slips[i].from && gone <= slips[i].to) {
        run.double_slip_lost[i - first_double] += std::abs(step) * slips[i].lost;
        run.double_slip_end[i - first_double] = gone;
      }
    }
    const auto fused = fusion.fuse(readings);
    CrawlerRunEvent event;
    event.place = place;
    event.scale = 1.0 / mean_rate;
    if (fused.status == FusionStatus::kOk) {
      event.increment = {fused.fused.distance,
                         fused.fused.standard_deviation * fused.fused.standard_deviation};
    } else {
      std::array<double, kWheels> sorted = {readings[0].distance, readings[1].distance,
                                            readings[2].distance};
      std::sort(sorted.begin(), sorted.end());
      event.increment = {sorted[1], window_sigma * window_sigma};
    }
    const double odometer_before = odometer;
    odometer += event.increment.distance;

    while (near_weld + 1 < run.welds.size() && run.welds[near_weld + 1] <= place) {
      ++near_weld;
    }
    while (near_weld > 0 && run.welds[near_weld] > place) {
      --near_weld;
    }
    for (std::size_t i = near_weld > 0 ? near_weld - 1 : 0;
         i < std::min(near_weld + 3, run.welds.size()); ++i) {
      if (!crossed(run.welds[i], before, place)) {
        continue;
      }
      if (new_ground) {
        ++passed;
      }
      if ((new_ground || settings.detects_on_old_ground) &&
          uniform(engine, 0.0, 1.0) >= settings.missed) {
        const double part = (run.welds[i] - before) / (place - before);
        pending.push_back({gone + settings.detector_lag, false,
                           odometer_before + part * event.increment.distance +
                               normal(engine, settings.weld_sigma)});
      }
    }
    if (new_ground &&
        uniform(engine, 0.0, 1.0) < settings.spurious * std::abs(step) / settings.joint_length) {
      pending.push_back({gone + settings.detector_lag, true,
                         odometer_before + uniform(engine, 0.0, 1.0) * event.increment.distance});
    }
    event.joints_passed = passed;
    run.events.push_back(event);
    while (!pending.empty() && pending.front().at_path <= gone) {
      CrawlerRunEvent weld = event;
      weld.is_weld = true;
      weld.spurious = pending.front().spurious;
      weld.weld = {.odometer_distance = pending.front().odometer,
                   .standard_deviation = settings.weld_sigma};
      run.events.push_back(weld);
      pending.erase(pending.begin());
    }
  }
  return run;
}

}  // namespace pipescout::odometry::test
