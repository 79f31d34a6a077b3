// SPDX-License-Identifier: Apache-2.0
#include "estimator_losses.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "each_seed.hpp"
#include "estimator_robots.hpp"
#include "pipescout/estimation_study/imu_gap_reference.hpp"
#include "pipescout/estimation_study/run_score.hpp"
#include "pipescout/estimation_study/sensor_loss.hpp"
#include "seed_values.hpp"

namespace pipescout::reproduce {
namespace {

using estimation_study::RunOptions;
using estimation_study::RunScore;
using estimation_study::SensorLoss;

constexpr double kFrom = 20;      // s: what it needs to start is whole
constexpr double kBurst = 2;      // s
constexpr double kLag = 0.5;      // s
constexpr double kRatioAt = 0.1;  // share of losses for which the ratio is asked
constexpr Target kLossCoverage = within(88, 99.9);

struct Loss {
  SensorLoss what{};
  std::string name{};
};

std::vector<Loss> losses_of(const Robot& robot) {
  std::vector<Loss> losses;
  for (const estimation_study::Sensor sensor : robot.sensors) {
    const std::string name = name_of(sensor);
    for (const double share : {0.01, 0.1, 0.3}) {
      const std::string percents = std::to_string(std::lround(100 * share)) + " % of " + name;
      losses.push_back({{.sensor = sensor, .share = share}, percents + " lost singly"});
      losses.push_back({{.sensor = sensor, .share = share, .longest_burst = kBurst},
                        percents + " lost in bursts"});
    }
    losses.push_back({{.sensor = sensor, .lag = kLag}, name + " behind by half a second"});
  }
  return losses;
}

struct LossScore {
  double position = 0;   // m, root mean square; infinite without any state
  double coverage = 0;   // percent
  double refused = 0;    // s, longer than the sensor's own gap
  double reference = 0;  // m, see imu_gap_reference; of such losses alone
};

bool is_compared(const Loss& loss) {
  return loss.what.sensor == estimation_study::Sensor::kImu && loss.what.longest_burst > 0 &&
         loss.what.share == kRatioAt;
}

RunScore score(const estimation_study::VehicleRun& run, const RunOptions& options,
               const estimation::StateEstimatorParameters& parameters) {
  constexpr double kSpacing = 0.5;  // s
  return estimation_study::score_run(run, options, parameters, {.nees_spacing = kSpacing});
}

LossScore judge(const RunScore& scored, const estimation_study::VehicleRun& run, const Loss& loss) {
  LossScore result;
  if (scored.estimates.empty()) {
    result.position = std::numeric_limits<double>::infinity();
    return result;
  }
  result.position = scored.position_rmse();
  result.coverage = 100 * scored.position_coverage();
  for (std::size_t i = 0; i < estimation_study::kSensors; ++i) {
    const auto sensor = static_cast<estimation_study::Sensor>(i);
    const double own =
        sensor == loss.what.sensor ? estimation_study::longest_gap(run, sensor) : 0.0;
    result.refused = std::max(result.refused, scored.refusals[i].longest - own);
  }
  return result;
}

/// Over all robots and losses.
struct Worst {
  double ratio = 0;
  double ratio_without_imu_bursts = 0;
  double least_coverage = 100;
  double most_coverage = 0;
  double refused = 0;
  double reference = 0;  // ratio, of bursts of the IMU
};

void add_robot(const Robot& robot, const std::vector<std::uint64_t>& seeds,
               const EstimatorExtent& extent, FigureRows& rows, StageProgress& progress,
               Worst& worst) {
  const std::vector<Loss> losses = losses_of(robot);
  RunOptions options;
  options.duration = extent.loss_duration;
  const std::string study = std::string(robot.article) + ": data lost or late";
  // The first is the whole run.
  const auto of_seeds = for_each_seed(progress, study, seeds, [&](std::uint64_t seed) {
    const auto whole = estimation_study::vehicle_run(robot.vehicle, options, seed);
    const auto parameters = estimation_study::estimator_parameters(whole, options);
    const RunScore of_whole = score(whole, options, parameters);
    std::vector<LossScore> scores{judge(of_whole, whole, {})};
    for (const Loss& loss : losses) {
      const auto run = estimation_study::with_loss(whole, loss.what, kFrom, seed);
      const RunScore scored = score(run, options, parameters);
      scores.push_back(judge(scored, run, loss));
      if (is_compared(loss)) {
        scores.back().reference = estimation_study::imu_gap_reference(run, scored, of_whole);
      }
    }
    return scores;
  });
  const auto values = [&](std::size_t loss, auto member) {
    return each(of_seeds, [&](const auto& scores) { return scores[loss].*member; });
  };
  const double whole = pooled(values(0, &LossScore::position));
  std::vector<Measure> measures{{"whole: position, root mean square, m", whole,
                                 values(0, &LossScore::position), kSmallIsGood}};
  for (std::size_t i = 0; i < losses.size(); ++i) {
    const Loss& loss = losses[i];
    const auto position = values(i + 1, &LossScore::position);
    const auto coverage = values(i + 1, &LossScore::coverage);
    const double ratio = pooled(position) / whole;
    const bool asked = loss.what.share == kRatioAt;
    measures.push_back({loss.name + ": ratio of the position error to the whole run",
                        ratio,
                        {},
                        asked ? at_most(1.5) : kSmallIsGood});
    measures.push_back({loss.name + ": truth within the stated 95 %, % of the time", mean(coverage),
                        coverage, kLossCoverage});
    if (is_compared(loss)) {
      const double reference = pooled(values(i + 1, &LossScore::reference)) / whole;
      measures.push_back({loss.name +
                              ": the same ratio of a reference that is told the truth before "
                              "and after each gap, and tuned in hindsight",
                          reference,
                          {},
                          kSmallIsGood});
      worst.reference = std::max(worst.reference, reference);
    }
    if (asked) {
      worst.ratio = std::max(worst.ratio, ratio);
      const bool imu_bursts =
          loss.what.sensor == estimation_study::Sensor::kImu && loss.what.longest_burst > 0;
      worst.ratio_without_imu_bursts =
          std::max(worst.ratio_without_imu_bursts, imu_bursts ? 0.0 : ratio);
    }
    worst.least_coverage = std::min(worst.least_coverage, mean(coverage));
    worst.most_coverage = std::max(worst.most_coverage, mean(coverage));
    worst.refused = std::max(worst.refused, largest(values(i + 1, &LossScore::refused)));
  }
  rows.add_study(study, measures);
}

}  // namespace

void reproduce_losses(const ReproduceOptions& options, const EstimatorExtent& extent,
                      FigureRows& rows, StageProgress& progress) {
  const auto seeds = seeds_of(options, std::min(options.seeds, extent.largest_loss_seeds));
  Worst worst;
  for (const Robot& robot : robots()) {
    add_robot(robot, seeds, extent, rows, progress, worst);
  }
  rows.add_study("Data lost or late, the worst of all robots and sensors",
                 {{"10 % lost: ratio of the position error to the whole run",
                   worst.ratio,
                   {},
                   at_most(1.5),
                   "loss_rmse_ratio"},
                  {"the same, but for the IMU in bursts",
                   worst.ratio_without_imu_bursts,
                   {},
                   at_most(1.5),
                   "loss_rmse_ratio_but_imu_bursts"},
                  {"10 % of the IMU lost in bursts: ratio of the reference",
                   worst.reference,
                   {},
                   kSmallIsGood,
                   "loss_rmse_ratio_reference"},
                  {"truth within the stated 95 %, least, % of the time",
                   worst.least_coverage,
                   {},
                   kLossCoverage,
                   "loss_coverage95_percent"},
                  {"truth within the stated 95 %, most, % of the time",
                   worst.most_coverage,
                   {},
                   kLossCoverage,
                   "loss_coverage95_most_percent"},
                  {"refused for longer than the sensor's own gap, s",
                   worst.refused,
                   {},
                   kNone,
                   "loss_refused_beyond_gap_s"}});
}

}  // namespace pipescout::reproduce
