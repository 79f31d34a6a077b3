// SPDX-License-Identifier: Apache-2.0
// What one update of the state estimate costs: the fixed-lag smoother and, for the same windows
// with the same factors, Ceres; a longer window; a day; the output between updates.
#include <benchmark/benchmark.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>

#include "estimator_inputs.hpp"
#include "figures.hpp"
#include "heap_guard.hpp"
#include "program.hpp"
#include "samples.hpp"

namespace pipescout::benchmarks {
namespace {

using estimation::FixedLagSmoother;
using estimation::FixedLagSmootherParameters;
using Recorded = std::shared_ptr<const EstimatorRecording>;

constexpr std::uint64_t kSeed = 1001;
constexpr std::size_t kWarmUp = 50;  // updates

constexpr const char* kUpdate = "update, 20 keyframes";
constexpr const char* kCholesky = "Ceres, the same 20 keyframes, Cholesky";
constexpr const char* kSchur = "Ceres, the same 20 keyframes, Schur";
constexpr const char* kOneIteration = "Ceres, Cholesky, one iteration";
constexpr const char* kLongUpdate = "update, 200 keyframes";
constexpr const char* kWhole = "update of all 20 keyframes";
constexpr const char* kLongWhole = "update of all 200 keyframes";
constexpr const char* kOutput = "an IMU sample in, a state out";
constexpr const char* kBatch = "Ceres, a recording of 600 keyframes";
constexpr const char* kLongBatch = "Ceres, a recording of 6000 keyframes";
constexpr const char* kDay = "24 hours";

/// What is found beside times.
struct Findings {
  std::size_t allocations = 0;  ///< after warm-up
  double growth_kb = std::numeric_limits<double>::quiet_NaN();
  bool simulated = true;
  std::map<std::string, Samples> iterations;  ///< of Ceres
};

Findings& findings() {
  static Findings all;
  return all;
}

/// What this thread has used: other work on the machine makes nothing slower.
std::int64_t cpu_nanoseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// kB of this process in memory that no file backs: code that is read for the first time does not
/// count.
double anonymous_kb() {
  std::FILE* const file = std::fopen("/proc/self/status", "r");
  std::array<char, 256> line{};
  double kb = std::numeric_limits<double>::quiet_NaN();
  while (file != nullptr && std::fgets(line.data(), line.size(), file) != nullptr) {
    std::sscanf(line.data(), "RssAnon: %lf kB", &kb);
  }
  if (file != nullptr) {
    std::fclose(file);
  }
  return kb;
}

FixedLagSmootherParameters parameters_of(std::size_t keyframes) {
  FixedLagSmootherParameters parameters = estimator_parameters();
  // The newest beside those of the lag.
  parameters.lag = kKeyframeStep * static_cast<double>(keyframes - 1);
  parameters.max_keyframes = keyframes + 10;
  parameters.max_imu_samples = 20 * keyframes;
  return parameters;
}

/// Feeds one step and updates; what the update and reading the newest state take, in nanoseconds.
std::int64_t timed_update(FixedLagSmoother& smoother, const EstimatorStep& step) {
  feed(smoother, step);
  const std::int64_t start = cpu_nanoseconds();
  smoother.update(step.time);
  benchmark::DoNotOptimize(smoother.state(smoother.keyframes() - 1));
  return cpu_nanoseconds() - start;
}

/// A heading of no weight at the oldest keyframes: all is eliminated anew.
void add_late_measurement(FixedLagSmoother& smoother) {
  constexpr double kNothing = 1e3;  // rad
  smoother.add(estimation::HeadingMeasurement{smoother.time(1), 0, kNothing});
}

void add_updates(const char* name, const Recorded& recorded, std::size_t keyframes, bool whole) {
  benchmark::RegisterBenchmark(name,
                               [=](benchmark::State& state) {
                                 Samples& samples = all_samples()[name];
                                 for (auto _ : state) {
                                   FixedLagSmoother smoother(parameters_of(keyframes));
                                   start(smoother, recorded->start);
                                   const std::size_t warm_up = keyframes + kWarmUp;
                                   double total = 0;
                                   std::size_t index = 0;
                                   for (const EstimatorStep& step : recorded->steps) {
                                     const pipescout::test::HeapGuard guard;
                                     if (whole && index > 2) {
                                       add_late_measurement(smoother);
                                     }
                                     const auto took =
                                         static_cast<double>(timed_update(smoother, step));
                                     if (++index > warm_up) {
                                       findings().allocations += guard.allocations();
                                       samples.add(took * 1e-3);
                                     }
                                     total += took;
                                   }
                                   state.SetIterationTime(total * 1e-9);
                                 }
                               })
      ->UseManualTime()
      ->Iterations(1)
      ->Repetitions(3)
      ->Unit(benchmark::kMillisecond);
}

/// Solves once and takes the time; making the problem is not timed.
void solve_by_ceres(const char* name, const estimation::BatchSmootherParameters& parameters,
                    const estimation::Recording& recording, double& total) {
  estimation::BatchSmoother peer(parameters, recording);
  const std::int64_t begin = cpu_nanoseconds();
  const estimation::BatchReport& report = peer.solve();
  const auto took = static_cast<double>(cpu_nanoseconds() - begin);
  all_samples()[name].add(took * 1e-3);
  findings().iterations[name].add(report.iterations);
  total += took;
}

estimation::BatchSmootherParameters ceres_parameters(estimation::LinearSolver solver,
                                                     int iterations) {
  auto parameters = estimation::BatchSmootherParameters::like(estimator_parameters());
  parameters.linear_solver = solver;
  parameters.max_iterations = iterations;
  parameters.tolerance = 1e-6;  // Ceres' own
  parameters.max_reintegrations = 0;
  return parameters;
}

/// The peer: warm-started.
void add_ceres(const char* name, const Recorded& recorded, estimation::LinearSolver solver,
               int iterations) {
  benchmark::RegisterBenchmark(name,
                               [=](benchmark::State& state) {
                                 constexpr std::size_t kEach = 10;
                                 const auto parameters = ceres_parameters(solver, iterations);
                                 for (auto _ : state) {
                                   FixedLagSmoother smoother(parameters_of(20));
                                   start(smoother, recorded->start);
                                   double total = 0;
                                   for (std::size_t i = 0; i < recorded->steps.size(); ++i) {
                                     feed(smoother, recorded->steps[i]);
                                     if (i >= kWarmUp && i % kEach == 0) {
                                       solve_by_ceres(
                                           name, parameters,
                                           window_for_ceres(smoother, recorded->steps, i), total);
                                     }
                                     smoother.update(recorded->steps[i].time);
                                   }
                                   state.SetIterationTime(total * 1e-9);
                                 }
                               })
      ->UseManualTime()
      ->Iterations(1)
      ->Repetitions(3)
      ->Unit(benchmark::kMillisecond);
}

void add_batch(const char* name, std::size_t keyframes) {
  benchmark::RegisterBenchmark(
      name,
      [=](benchmark::State& state) {
        constexpr int kIterations = 5;
        const estimation::Recording recording = batch_recording(kSeed, keyframes);
        for (auto _ : state) {
          double total = 0;
          solve_by_ceres(name,
                         ceres_parameters(estimation::LinearSolver::kSparseCholesky, kIterations),
                         recording, total);
          state.SetIterationTime(total * 1e-9);
        }
      })
      ->UseManualTime()
      ->Iterations(1)
      ->Repetitions(3)
      ->Unit(benchmark::kMillisecond);
}

void add_output(const Recorded& recorded) {
  benchmark::RegisterBenchmark(kOutput,
                               [=](benchmark::State& state) {
                                 Samples& samples = all_samples()[kOutput];
                                 for (auto _ : state) {
                                   FixedLagSmoother smoother(parameters_of(20));
                                   start(smoother, recorded->start);
                                   double total = 0;
                                   for (const EstimatorStep& step : recorded->steps) {
                                     for (const estimation::ImuSample& sample : step.imu) {
                                       // The clock of the thread is a system call, which takes as
                                       // long as this.
                                       const std::int64_t begin = monotonic_nanoseconds();
                                       smoother.add(sample);
                                       benchmark::DoNotOptimize(smoother.propagated());
                                       const auto took =
                                           static_cast<double>(monotonic_nanoseconds() - begin);
                                       samples.add(took * 1e-3);
                                       total += took;
                                     }
                                     feed(smoother, step);  // of the samples, duplicates now
                                     smoother.update(step.time);
                                   }
                                   state.SetIterationTime(total * 1e-9);
                                 }
                               })
      ->UseManualTime()
      ->Iterations(1)
      ->Repetitions(3)
      ->Unit(benchmark::kMillisecond);
}

void add_day() {
  benchmark::RegisterBenchmark(kDay,
                               [](benchmark::State& state) {
                                 constexpr double kBegin = 600;
                                 constexpr double kEnd = kBegin + 24 * 3600;
                                 for (auto _ : state) {
                                   EstimatorStream stream(kSeed);
                                   FixedLagSmoother smoother(parameters_of(20));
                                   start(smoother, stream.start());
                                   EstimatorStep step;
                                   std::int64_t took = 0;
                                   double before = 0;
                                   std::size_t allocations_before = 0;
                                   const pipescout::test::HeapGuard guard;
                                   while (step.time < kEnd) {
                                     stream.next(step);
                                     took += timed_update(smoother, step);
                                     if (before == 0 && step.time >= kBegin) {
                                       before = anonymous_kb();
                                       allocations_before = guard.allocations();
                                     }
                                   }
                                   findings().allocations +=
                                       guard.allocations() - allocations_before;
                                   findings().growth_kb = anonymous_kb() - before;
                                   if (!smoother.initialised()) {
                                     throw std::logic_error("the smoother has reset itself");
                                   }
                                   state.SetIterationTime(static_cast<double>(took) * 1e-9);
                                 }
                               })
      ->UseManualTime()
      ->Iterations(1)
      ->Repetitions(1)
      ->Unit(benchmark::kSecond);
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
                     {"samples", samples.size()}});
  }
  figures.add_row({{"case", "stream"}, {"simulated", findings().simulated ? 1 : 0}});
  for (const auto& [name, iterations] : findings().iterations) {
    figures.add_row({{"case", name + " / ours"},
                     {"ratio", median_ms(name.c_str()) / median_ms(kUpdate)},
                     {"iterations", iterations.median()}});
  }
  const double peer = std::min(median_ms(kCholesky), median_ms(kSchur));
  figures.add("update_median_ms", median_ms(kUpdate), Bound::kAtMost, 0.10);
  figures.add("update_p99_ms", all_samples()[kUpdate].quantile(0.99) / 1e3, Bound::kAtMost, 0.30);
  figures.add("ceres_median_ms", peer);
  figures.add("speedup_vs_ceres", peer / median_ms(kUpdate), Bound::kAtLeast, 10.0);
  figures.add("speedup_vs_one_iteration", median_ms(kOneIteration) / median_ms(kUpdate),
              Bound::kAtLeast, 10.0);
  figures.add("window_200_ms", median_ms(kLongUpdate));
  // 1 is linear; all keyframes are eliminated anew.
  figures.add("window_exponent", std::log10(median_ms(kLongWhole) / median_ms(kWhole)),
              Bound::kAtMost, 1.1);
  const auto per_iteration = [](const char* name) {
    return median_ms(name) / findings().iterations[name].median();
  };
  figures.add("batch_exponent", std::log10(per_iteration(kLongBatch) / per_iteration(kBatch)),
              Bound::kAtMost, 1.1);
  figures.add("imu_rate_output_us", all_samples()[kOutput].median(), Bound::kAtMost, 2.0);
  figures.add("memory_growth_24h_kb", findings().growth_kb, Bound::kAtMost, 0.0);
  figures.add("allocations_after_warm_up", static_cast<double>(findings().allocations),
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
        const auto recorded =
            std::make_shared<const pb::EstimatorRecording>(pb::estimator_recording(pb::kSeed));
        pb::findings().simulated = recorded->simulated;
        pb::add_updates(pb::kUpdate, recorded, 20, false);
        pb::add_updates(pb::kLongUpdate, recorded, 200, false);
        pb::add_updates(pb::kWhole, recorded, 20, true);
        pb::add_updates(pb::kLongWhole, recorded, 200, true);
        using pipescout::estimation::LinearSolver;
        const int iterations = pb::estimator_parameters().max_iterations;
        pb::add_ceres(pb::kCholesky, recorded, LinearSolver::kSparseCholesky, iterations);
        pb::add_ceres(pb::kSchur, recorded, LinearSolver::kSparseSchur, iterations);
        pb::add_ceres(pb::kOneIteration, recorded, LinearSolver::kSparseCholesky, 1);
        pb::add_batch(pb::kBatch, 600);
        pb::add_batch(pb::kLongBatch, 6000);
        pb::add_output(recorded);
        pb::add_day();
      },
      pb::evaluate);
}
