// SPDX-License-Identifier: Apache-2.0
// What odometry in a pipe costs: the stream of odometers, the weld detector, weld positioning and
// the alignment of two runs.
#include <benchmark/benchmark.h>

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "figures.hpp"
#include "heap_guard.hpp"
#include "odometry_inputs.hpp"
#include "odometry_peers.hpp"
#include "pipescout/odometry_study/crawler_run.hpp"
#include "program.hpp"
#include "samples.hpp"

namespace pipescout::benchmarks {
namespace {

constexpr const char* kStream3 = "stream, 3 wheels, per round of samples";
constexpr const char* kStream16 = "stream, 16 wheels, per round of samples";
constexpr const char* kConsensus3 = "consensus only, 3 wheels, per round";
constexpr const char* kConsensus16 = "consensus only, 16 wheels, per round";
constexpr const char* kDetector = "weld detector, per sample";
constexpr const char* kConvolution = "direct convolution, per sample";
constexpr const char* kPositioning = "positioning, 1,000 joints, per weld";
constexpr const char* kSearching = "positioning, before it knows, per weld";
constexpr const char* kFingerprint = "search of the whole tally, per weld";
constexpr const char* kAlignment = "alignment of 1,600 joints";
constexpr const char* kFullMatrix = "full matrix, 1,600 joints";

/// Of all that works sample by sample, after its construction.
std::size_t& allocations_after_warm_up() {
  static std::size_t allocations = 0;
  return allocations;
}

/// `begin` makes the object; what it returns is timed, and is the work of `units`.
template <class Begin>
void add_case(const char* name, std::size_t units, bool counts_allocations, Begin begin) {
  benchmark::RegisterBenchmark(
      name,
      [=](benchmark::State& state) {
        for (auto _ : state) {
          auto work = begin();
          const pipescout::test::HeapGuard guard;
          const auto start = monotonic_nanoseconds();
          work();
          const auto took = static_cast<double>(monotonic_nanoseconds() - start);
          const std::size_t allocations = guard.allocations();
          allocations_after_warm_up() += counts_allocations ? allocations : 0;
          state.SetIterationTime(took * 1e-9);
          all_samples()[name].add(took * 1e-3 / static_cast<double>(units));
        }
      })
      ->UseManualTime()
      ->MinTime(0.05)
      ->Unit(benchmark::kMillisecond);
}

void register_stream(std::size_t wheels, const char* name, const char* peer) {
  const auto input = std::make_shared<WheelInput>(wheel_input(wheels));
  const std::size_t rounds = input->samples.size() / wheels;
  add_case(name, rounds, true, [input] {
    auto stream = std::make_shared<odometry::OdometerStream>(input->parameters);
    return [input, stream] {
      for (const auto& sample : input->samples) {
        stream->push(sample);
      }
      benchmark::DoNotOptimize(stream->state().distance);
    };
  });
  add_case(peer, rounds, false,
           [input] { return [input] { benchmark::DoNotOptimize(fuse_each_round(*input)); }; });
}

void register_detector() {
  const auto input = std::make_shared<std::vector<SignalSample>>(signal_input());
  add_case(kDetector, input->size(), true, [input] {
    auto detector = std::make_shared<odometry::WeldDetector>(odometry::WeldDetectorParameters{});
    return [input, detector] {
      for (const auto& sample : *input) {
        benchmark::DoNotOptimize(detector->update(sample.distance, {&sample.value, 1}));
      }
    };
  });
  add_case(kConvolution, input->size(), false, [input] {
    auto convolution = std::make_shared<DirectConvolution>();
    return [input, convolution] {
      for (const auto& sample : *input) {
        benchmark::DoNotOptimize(convolution->next({sample.value.x, sample.value.y}));
      }
    };
  });
}

/// The events of a crawler up to so many welds, from an unknown start; increments between the welds
/// count as well.
void register_positioning(const char* name, const std::shared_ptr<odometry_study::CrawlerRun>& run,
                          std::size_t welds) {
  add_case(name, welds, true, [run, welds] {
    auto positioning = std::make_shared<odometry::WeldPositioning>(
        odometry::WeldPositioningParameters{}, run->tally,
        odometry::WeldPositioningStart{.orientation = odometry::Orientation::kUnknown});
    return [run, positioning, welds] {
      std::size_t seen = 0;
      for (auto event = run->events.begin(); event != run->events.end() && seen < welds; ++event) {
        if (event->is_weld) {
          ++seen;
          positioning->add_weld(event->weld);
        } else {
          positioning->add_increment(event->increment);
        }
      }
    };
  });
}

void register_place() {
  constexpr std::uint64_t kSeed = 1001;
  const auto run =
      std::make_shared<odometry_study::CrawlerRun>(odometry_study::simulate_crawler_run({}, kSeed));
  std::vector<double> welds;
  for (const auto& event : run->events) {
    if (event.is_weld) {
      welds.push_back(event.weld.odometer_distance);
    }
  }
  register_positioning(kPositioning, run, welds.size());
  constexpr std::size_t kWeldsBeforeLock = 8;
  register_positioning(kSearching, run, kWeldsBeforeLock);
  add_case(kFingerprint, welds.size(), false, [run, welds] {
    auto search = std::make_shared<FingerprintSearch>(run->tally);
    return [search, welds] {
      for (std::size_t i = 1; i < welds.size(); ++i) {
        benchmark::DoNotOptimize(search->add_joint(welds[i] - welds[i - 1]));
      }
    };
  });
}

void register_alignment() {
  const auto lists = std::make_shared<WeldLists>(weld_lists());
  add_case(kAlignment, 1, false, [lists] {
    return [lists] { benchmark::DoNotOptimize(odometry::align_welds(lists->then, lists->later)); };
  });
  add_case(kFullMatrix, 1, false, [lists] {
    return [lists] { benchmark::DoNotOptimize(align_full_matrix(lists->then, lists->later)); };
  });
}

double median(const char* name) {
  return all_samples()[name].median();
}

Figures evaluate() {
  using Bound = Figures::Bound;
  Figures figures;
  for (const auto& [name, samples] : all_samples()) {
    figures.add_row({{"case", name},
                     {"median_us", samples.median()},
                     {"p99_us", samples.quantile(0.99)},
                     {"samples", samples.size()}});
  }
  const auto add_ratio = [&figures](const char* ours, const char* peer) {
    figures.add_row(
        {{"case", std::string(ours) + " / " + peer}, {"ratio", median(ours) / median(peer)}});
  };
  add_ratio(kStream3, kConsensus3);
  add_ratio(kStream16, kConsensus16);
  add_ratio(kDetector, kConvolution);
  add_ratio(kPositioning, kFingerprint);
  add_ratio(kAlignment, kFullMatrix);
  figures.add("stream_3_wheels_us", median(kStream3), Bound::kAtMost, 0.5);
  figures.add("stream_16_wheels_us", median(kStream16), Bound::kAtMost, 6.0);
  figures.add("detector_msamples_per_s", 1.0 / median(kDetector), Bound::kAtLeast, 5.0);
  figures.add("positioning_us_per_weld", median(kPositioning), Bound::kAtMost, 20.0);
  figures.add("alignment_1600_joints_ms", median(kAlignment) / 1e3, Bound::kAtMost, 50.0);
  figures.add("allocations_after_warm_up", static_cast<double>(allocations_after_warm_up()),
              Bound::kAtMost, 0.0);
  return figures;
}

}  // namespace
}  // namespace pipescout::benchmarks

int main(int argc, char** argv) {
  namespace pb = pipescout::benchmarks;
  return pb::run_program(
      argc, argv,
      [] {
        pb::register_stream(3, pb::kStream3, pb::kConsensus3);
        pb::register_stream(16, pb::kStream16, pb::kConsensus16);
        pb::register_detector();
        pb::register_place();
        pb::register_alignment();
      },
      pb::evaluate);
}
