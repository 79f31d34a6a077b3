// SPDX-License-Identifier: Apache-2.0
// Updates of the particle filter and of the whole tracker against 5 regions, and those of the same
// filter on the Bayesian Filtering Library.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "figures.hpp"
#include "heap_guard.hpp"
#include "pipescout/tracking/shape_tracker.hpp"
#include "samples.hpp"
#include "tracking_cases.hpp"
#include "tracking_peer.hpp"

namespace pipescout::benchmarks {
namespace {

using tracking::PipeRegion;
using tracking::PipeShape;
using tracking::PipeTracker;
using tracking::PipeTrackerParameters;
using Filter = tracking::ParticleFilter<PipeShape>;
using Parameters = tracking::ParticleFilterParameters<PipeShape>;
using Section = tracking::ShapeState<PipeShape>;

constexpr std::uint64_t kSeed = 1001;
constexpr double kPeriod = 0.04;  // s
constexpr int kWarmUp = 20;
constexpr std::array<std::size_t, 4> kParticles{100, 1000, 10'000, 100'000};
constexpr const char* kTracker = "tracker, 1000 particles";
constexpr const char* kMultinomial = "particle filter, 1000 particles, multinomial";
constexpr const char* kPeer = "bootstrap filter of BFL, 1000 particles";

std::size_t& allocations() {
  static std::size_t counted = 0;
  return counted;
}

std::string filter_case(std::size_t particles) {
  return "particle filter, " + std::to_string(particles) + " particles";
}

/// A pipe that swings, and four other regions.
std::array<Section, 5> sections(int picture) {
  const double t = kPeriod * picture;
  return {
      Section(160 + 20 * std::sin(2 * t), 120 + 15 * std::sin(5 * t), 200, 0.2 * std::sin(3 * t)),
      Section(60, 40, 90, 1.2), Section(250, 60, 70, -0.4), Section(80, 200, 60, 0.9),
      Section(280, 190, 50, -1.3)};
}

std::array<PipeRegion, 5> regions(int picture) {
  std::array<PipeRegion, 5> result;
  const auto all = sections(picture);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Eigen::Vector2d half =
        all[i][2] / 2 * Eigen::Vector2d(std::cos(all[i][3]), std::sin(all[i][3]));
    result[i] = {.start = all[i].head<2>() - half, .end = all[i].head<2>() + half, .half_width = 6};
  }
  return result;
}

Parameters parameters(std::size_t particles) {
  PipeTrackerParameters result;
  result.filter.particles = particles;
  return result.filter;
}

/// Registers a case; `step(picture)` is timed, `make_step` and the warm-up are not.
template <class MakeStep>
void add_case(const std::string& name, int pictures, bool guarded, const MakeStep& make_step) {
  benchmark::RegisterBenchmark(name.c_str(),
                               [=](benchmark::State& state) {
                                 for (auto _ : state) {
                                   auto step = make_step();
                                   int picture = 0;
                                   for (; picture < kWarmUp; ++picture) {
                                     step(picture);
                                   }
                                   const pipescout::test::HeapGuard guard;
                                   const std::int64_t begin = thread_cpu_nanoseconds();
                                   for (; picture < kWarmUp + pictures; ++picture) {
                                     step(picture);
                                   }
                                   const auto took =
                                       static_cast<double>(thread_cpu_nanoseconds() - begin);
                                   allocations() += guarded ? guard.allocations() : 0;
                                   all_samples()[name].add(took * 1e-3 / pictures);
                                   state.SetIterationTime(took * 1e-9);
                                 }
                               })
      ->UseManualTime()
      ->Iterations(1)
      ->Unit(benchmark::kMillisecond);
}

void add_filter(const std::string& name, int pictures, const Parameters& of_filter) {
  add_case(name, pictures, true, [of_filter] {
    auto filter = std::make_shared<Filter>(PipeShape{}, of_filter, kSeed);
    filter->start(sections(0).front());
    return [filter](int picture) {
      filter->predict(kPeriod, Section::Zero());
      filter->update(sections(picture));
    };
  });
}

double median_us(const std::string& name) {
  return all_samples()[name].median();
}

}  // namespace

void register_tracker_cases() {
  for (const std::size_t particles : kParticles) {
    const auto pictures =
        static_cast<int>(std::clamp<std::size_t>(2'000'000 / particles, 20, 2000));
    add_filter(filter_case(particles), pictures, parameters(particles));
  }
  auto multinomial = parameters(1000);
  multinomial.resampling = tracking::Resampling::kMultinomial;
  add_filter(kMultinomial, 2000, multinomial);
  add_case(kTracker, 2000, true, [] {
    auto tracker = std::make_shared<PipeTracker>(PipeShape{}, PipeTrackerParameters{}, kSeed);
    return [tracker](int picture) {
      const auto seen = regions(picture);
      tracker->update({.time = kPeriod * picture, .image = {320, 240}, .regions = seen});
    };
  });
  add_case(kPeer, 100, false, [] {
    auto peer = std::make_shared<BflPeer>(PipeShape{}, parameters(1000), sections(0).front());
    return [peer](int picture) {
      const auto seen = sections(picture);
      peer->step(kPeriod, Section::Zero(), seen);
    };
  });
}

void add_tracker_figures(Figures& figures) {
  using Bound = Figures::Bound;
  figures.add_seed(kSeed);
  std::vector<std::string> names{kMultinomial, kTracker, kPeer};
  for (const std::size_t particles : kParticles) {
    names.push_back(filter_case(particles));
  }
  for (const std::string& name : names) {
    const Samples& samples = all_samples()[name];
    figures.add_row({{"case", name},
                     {"median_us", samples.median()},
                     {"p99_us", samples.quantile(0.99)},
                     {"samples", samples.size()}});
  }
  const double update = median_us(filter_case(1000));
  figures.add("update_1000_us", update, Bound::kAtMost, 60.0);
  figures.add("update_100000_over_linear", median_us(filter_case(100'000)) / (100 * update),
              Bound::kAtMost, 1.5);
  figures.add("tracker_1000_us", median_us(kTracker));
  figures.add("bfl_1000_us", median_us(kPeer));
  figures.add("speedup_vs_peer", median_us(kPeer) / median_us(kMultinomial), Bound::kAtLeast, 5.0);
  figures.add("allocations_after_warm_up", static_cast<double>(allocations()), Bound::kAtMost, 0.0);
}

}  // namespace pipescout::benchmarks
