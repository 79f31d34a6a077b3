// SPDX-License-Identifier: Apache-2.0
// What one thermal frame costs, from counts to findings, and, for the same frames, a pipeline on
// generic thinning.
#include <benchmark/benchmark.h>
#include <time.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "figures.hpp"
#include "heap_guard.hpp"
#include "program.hpp"
#include "samples.hpp"
#include "thermal_inputs.hpp"
#include "thermal_peer.hpp"

namespace pipescout::benchmarks {
namespace {

using Recorded = std::shared_ptr<const ThermalRecording>;

constexpr std::uint64_t kSeed = 1001;
constexpr std::size_t kWarmUp = 3;  // rounds through the recording
constexpr std::size_t kRounds = 6;  // that are measured

constexpr const char* kLarge = "640x512, counts to findings";
constexpr const char* kSmall = "320x240, counts to findings";
constexpr const char* kDetection = "640x512, counts to detections";
constexpr const char* kAdaptive = "640x512, counts to detections, adaptive threshold";
constexpr const char* kContrast = "640x512, counts to detections, by contrast";
constexpr const char* kThinning = "640x512, counts to detections, cv::ximgproc::thinning";

/// What is found beside times.
struct Findings {
  std::size_t allocations = 0;  ///< after warm-up
  std::map<std::string, Samples> leaks;
};

Findings& found() {
  static Findings all;
  return all;
}

/// What this thread has used: other work on the machine makes nothing slower.
std::int64_t cpu_nanoseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// Registers a case: `step(round, shot)` handles a frame and returns how many leaks it knows of.
template <class MakeStep>
void add_case(const char* name, const Recorded& recorded, std::size_t warm_up, std::size_t rounds,
              bool guarded, const MakeStep& make_step) {
  benchmark::RegisterBenchmark(
      name,
      [=](benchmark::State& state) {
        Samples& samples = all_samples()[name];
        for (auto _ : state) {
          auto step = make_step();
          double total = 0;
          for (std::size_t round = 0; round < warm_up + rounds; ++round) {
            for (std::size_t shot = 0; shot < recorded->shots.size(); ++shot) {
              const pipescout::test::HeapGuard guard;
              const std::int64_t start = cpu_nanoseconds();
              const std::size_t leaks = step(round, shot);
              const auto took = static_cast<double>(cpu_nanoseconds() - start);
              if (round >= warm_up) {
                found().allocations += guarded ? guard.allocations() : 0;
                found().leaks[name].add(static_cast<double>(leaks));
                samples.add(took * 1e-3);
              }
              total += took;
            }
          }
          state.SetIterationTime(total * 1e-9);
        }
      })
      ->UseManualTime()
      ->Iterations(1)
      ->Repetitions(3)
      ->Unit(benchmark::kMillisecond);
}

void add_findings(const char* name, const Recorded& recorded) {
  add_case(name, recorded, kWarmUp, kRounds, true, [recorded] {
    auto detector = std::make_shared<thermal::LeakDetector>(thermal_detector_parameters());
    auto findings = std::make_shared<leak_findings::LeakFindings>(thermal_findings_parameters(),
                                                                  recorded->camera);
    return [=](std::size_t round, std::size_t shot) {
      const thermal::Detections& detections =
          detector->detect(recorded->view(shot), recorded->table.degrees(),
                           findings->conditions(recorded->frame(round, shot)));
      findings->update(recorded->frame(round, shot), detections);
      return findings->findings().size();
    };
  });
}

void add_detection(const char* name, const Recorded& recorded,
                   const thermal::LeakDetectorParameters& parameters) {
  add_case(name, recorded, kWarmUp, kRounds, true, [recorded, parameters] {
    auto detector = std::make_shared<thermal::LeakDetector>(parameters);
    return [=](std::size_t, std::size_t shot) {
      return detector->detect(recorded->view(shot), recorded->table.degrees()).leaks.size();
    };
  });
}

void add_peer(const Recorded& recorded) {
  add_case(kThinning, recorded, 0, 1, false, [recorded] {
    auto peer = std::make_shared<ThinningPeer>();
    return [=](std::size_t, std::size_t shot) {
      return peer->detect(recorded->view(shot), recorded->table.degrees());
    };
  });
}

double median_ms(const char* name) {
  return all_samples()[name].median() / 1e3;
}

Figures evaluate() {
  using Bound = Figures::Bound;
  Figures figures;
  figures.add_seed(kSeed);
  for (const auto& [name, samples] : all_samples()) {
    figures.add_row({{"case", name},
                     {"median_us", samples.median()},
                     {"p99_us", samples.quantile(0.99)},
                     {"samples", samples.size()},
                     {"leaks_median", found().leaks[name].median()}});
  }
  figures.add("frame_640_median_ms", median_ms(kLarge), Bound::kAtMost, 1.5);
  figures.add("frame_320_median_ms", median_ms(kSmall), Bound::kAtMost, 0.4);
  figures.add("frame_640_p99_ms", all_samples()[kLarge].quantile(0.99) / 1e3);
  figures.add("adaptive_640_median_ms", median_ms(kAdaptive));
  figures.add("contrast_640_median_ms", median_ms(kContrast), Bound::kAtMost, 1.5);
  figures.add("thinning_median_ms", median_ms(kThinning));
  figures.add("speedup_vs_thinning", median_ms(kThinning) / median_ms(kDetection), Bound::kAtLeast,
              30.0);
  figures.add("allocations_after_warm_up", static_cast<double>(found().allocations), Bound::kAtMost,
              0.0);
  return figures;
}

}  // namespace
}  // namespace pipescout::benchmarks

int main(int argc, char** argv) {
  namespace pb = pipescout::benchmarks;
  return pb::run_program(
      argc, argv,
      [] {
        const auto large =
            std::make_shared<const pb::ThermalRecording>(pb::thermal_recording(true, pb::kSeed));
        const auto small =
            std::make_shared<const pb::ThermalRecording>(pb::thermal_recording(false, pb::kSeed));
        pb::add_findings(pb::kLarge, large);
        pb::add_findings(pb::kSmall, small);
        pb::add_detection(pb::kDetection, large, pb::thermal_detector_parameters());
        auto adaptive = pb::thermal_detector_parameters();
        adaptive.threshold_rule = pipescout::thermal::ThresholdRule::kLocal;
        pb::add_detection(pb::kAdaptive, large, adaptive);
        pb::add_detection(pb::kContrast, large,
                          pipescout::thermal::LeakDetectorParameters::by_contrast());
        pb::add_peer(large);
      },
      pb::evaluate);
}
