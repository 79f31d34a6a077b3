// SPDX-License-Identifier: Apache-2.0
#include "estimator_worlds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "each_seed.hpp"
#include "estimator_robots.hpp"
#include "pipescout/estimation_study/world_run.hpp"
#include "seed_values.hpp"

namespace pipescout::reproduce {
namespace {

constexpr Target kCoverage = within(88, 99.5);
constexpr Target kRatio = at_most(1.3);

struct Score {
  double position = 0;  // m, root mean square; infinite without any state
  double coverage = 0;  // percent
  double lockout = 0;   // s
};

Score score_of(const estimation_study::RunScore& run) {
  if (run.estimates.empty()) {
    return {.position = std::numeric_limits<double>::infinity(), .lockout = run.lockout};
  }
  return {.position = run.position_rmse(),
          .coverage = 100 * run.position_coverage(),
          .lockout = run.lockout};
}

struct Pair {
  Score nominal{};
  Score told{};
};

}  // namespace

void reproduce_worlds(const ReproduceOptions& options, const EstimatorExtent& extent,
                      FigureRows& rows, StageProgress& progress) {
  const auto seeds = seeds_of(options, options.seeds);
  double worst_ratio = 0;
  double worst_coverage = 100;
  double most_coverage = 0;
  double lockout = 0;
  for (const Robot& robot : robots()) {
    const std::string study = std::string(robot.article) + ": in worlds that it was not told about";
    const auto of_seeds = for_each_seed(progress, study, seeds, [&](std::uint64_t seed) {
      const auto scored = estimation_study::score_world(robot.vehicle, extent.duration, {}, seed);
      return Pair{score_of(scored.nominal), score_of(scored.told)};
    });
    const auto values = [&](auto whose, auto member) {
      return each(of_seeds, [&](const Pair& pair) { return pair.*whose.*member; });
    };
    const auto nominal = values(&Pair::nominal, &Score::position);
    const auto told = values(&Pair::told, &Score::position);
    const auto coverage = values(&Pair::nominal, &Score::coverage);
    const auto told_coverage = values(&Pair::told, &Score::coverage);
    const auto out = values(&Pair::nominal, &Score::lockout);
    const double ratio = pooled(nominal) / pooled(told);
    rows.add_study(
        study, {{"position, root mean square, m", pooled(nominal), nominal, kSmallIsGood},
                {"the same, told the truth, m", pooled(told), told, kSmallIsGood},
                {"ratio", ratio, {}, kRatio, std::string("world_rmse_ratio_") + robot.name},
                {"truth within the stated 95 %, % of the time", mean(coverage), coverage, kCoverage,
                 std::string("world_coverage95_percent_") + robot.name},
                {"the same, told the truth, %", mean(told_coverage), told_coverage, kCoverage},
                {"right GPS locked out and not said, s", largest(out), out, kNone}});
    worst_ratio = std::max(worst_ratio, ratio);
    worst_coverage = std::min(worst_coverage, mean(coverage));
    most_coverage = std::max(most_coverage, mean(coverage));
    lockout = std::max(lockout, largest(out));
  }
  rows.add_study("Worlds that it was not told about, the worst of all robots",
                 {{"ratio of the position error to that of an estimator told the truth",
                   worst_ratio,
                   {},
                   kRatio,
                   "world_rmse_ratio"},
                  {"truth within the stated 95 %, least, % of the time",
                   worst_coverage,
                   {},
                   kCoverage,
                   "world_coverage95_percent"},
                  {"truth within the stated 95 %, most, % of the time",
                   most_coverage,
                   {},
                   kCoverage,
                   "world_coverage95_most_percent"},
                  {"right GPS locked out and not said, s", lockout, {}, kNone, "world_lockout_s"}});
}

}  // namespace pipescout::reproduce
