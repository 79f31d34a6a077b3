// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "pipescout/command_line/text_table.hpp"
#include "pipescout/rack_study/first_pose_trials.hpp"
#include "pipescout/rack_study/offset_run.hpp"
#include "pipescout/rack_study/paper_flight.hpp"
#include "pipescout/rack_study/table_one.hpp"
#include "rack_figures.hpp"
#include "seed_values.hpp"

namespace pipescout::reproduce {
namespace {

using command_line::TextTable;

using rack_study::CellScore;
using rack_study::OffsetFrame;
using rack_study::PoseErrors;
using rack_study::TableCell;

constexpr std::size_t kTableRuns = 10;  // of the paper
constexpr std::size_t kPointsPerPipe = 25;

double deviation(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) {
    sum += (value - mean(values)) * (value - mean(values));
  }
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// Runs of poses, one per seed.
struct Runs {
  std::vector<PoseErrors> each;
  PoseErrors all;

  [[nodiscard]] std::vector<double> values(double (PoseErrors::*value)() const noexcept) const {
    std::vector<double> result;
    for (const auto& errors : each) {
      result.push_back((errors.*value)());
    }
    return result;
  }
};

Runs fly(RackReproduction& run, const std::string& study, const rack_vision::RackModel& model,
         const rack_study::PoseRunSettings& settings) {
  Runs runs;
  run.progress.begin(study, run.seeds.size());
  for (const auto seed : run.seeds) {
    const auto flight = rack_study::paper_flight(model, {}, seed);
    runs.each.push_back(rack_study::run_poses(model, flight, settings, seed));
    runs.all += runs.each.back();
    run.progress.step();
  }
  run.progress.end();
  return runs;
}

void ideal_run(RackReproduction& run) {
  const std::string study = "Ideal camera, gusts, four way-points, the paper's five pipes";
  const auto model = rack_study::paper_rack();
  const auto runs = fly(run, study, model, {.points = kPointsPerPipe * model.pipes.size()});
  run.rows.add_study(study, {{"position, root mean square, m",
                              runs.all.position_rms(),
                              runs.values(&PoseErrors::position_rms),
                              {.most = 0.001},
                              "ideal_position_rms_m"},
                             {"orientation, root mean square, deg",
                              runs.all.orientation_rms_degrees(),
                              runs.values(&PoseErrors::orientation_rms_degrees),
                              {.most = 0.02},
                              "ideal_orientation_rms_deg"}});
}

/// Table I. With `figures`, under the names of the figures.
void table_one(RackReproduction& run, int samples_per_edge, bool figures) {
  const std::string study = "Table I: quantised pixels, 2 px of noise, " +
                            std::to_string(samples_per_edge) +
                            " samples an edge, each frame by itself";
  const std::span<const std::uint64_t> seeds(run.seeds.data(),
                                             std::min(kTableRuns, run.seeds.size()));
  TextTable table({"pipes", "points", "position [m]", "+-", "paper [m]", "orientation [deg]", "+-",
                   "paper [deg]", "ratio to bound", "half of the paper", "bound half of it"});
  double half = 0, bound_half = 0, above = 0, bound_above = 0, worst = 0;
  const auto cells = rack_study::table_one_cells();
  run.progress.begin(study, cells.size());
  for (const TableCell& cell : cells) {
    const CellScore score = rack_study::score_cell(
        cell, {.samples_per_edge = samples_per_edge, .every = run.extent.every_frame}, seeds);
    const double position = score.all.position_mean();
    const double orientation = score.all.orientation_mean_degrees();
    half += score.half_of(cell) ? 1 : 0;
    bound_half += score.bound_half_of(cell) ? 1 : 0;
    above += score.above(cell) ? 1 : 0;
    bound_above += score.bound_above(cell) ? 1 : 0;
    worst = std::max(worst, score.ratio_to_bound());
    table.add_row({std::int64_t{cell.pipes}, static_cast<std::int64_t>(cell.points),
                   rounded(position), rounded(deviation(score.position)), cell.paper_position,
                   rounded(orientation), rounded(deviation(score.orientation)),
                   cell.paper_orientation, rounded(score.ratio_to_bound()), score.half_of(cell),
                   score.bound_half_of(cell)});
    run.result.rows.push_back(
        {{"study", study},
         {"pipes", cell.pipes},
         {"points", cell.points},
         {"position_m", position},
         {"position_m_sd", deviation(score.position)},
         {"paper_position_m", cell.paper_position},
         {"position_bound_rms_m", score.all.position_rms() / score.all.position_ratio()},
         {"orientation_deg", orientation},
         {"orientation_deg_sd", deviation(score.orientation)},
         {"paper_orientation_deg", cell.paper_orientation},
         {"orientation_bound_rms_deg",
          score.all.orientation_rms_degrees() / score.all.orientation_ratio()},
         {"ratio_to_bound", score.ratio_to_bound()},
         {"frames", score.all.frames},
         {"frames_without_points", score.all.without_points}});
    run.progress.step();
  }
  run.progress.end();
  run.out << study << "\n\n";
  table.print(run.out, "  ");
  run.out << '\n';
  const auto name = [&](const std::string& figure) {
    return figures ? figure : figure + "_" + std::to_string(samples_per_edge) + "_samples";
  };
  run.rows.add_study(study + ": cells",
                     {{"at most half of the paper in both",
                       half,
                       {},
                       {.least = 16},
                       name("table1_cells_half_of_paper")},
                      {"of them, a perfect single-frame estimate", bound_half, {}, {.least = 0}},
                      {"above the paper", above, {}, {.most = 0}, name("table1_cells_above_paper")},
                      {"of them, a perfect single-frame estimate", bound_above, {}, {.most = 0}},
                      {"worst ratio to the Cramer-Rao bound",
                       worst,
                       {},
                       {.most = 1.2},
                       name("table1_worst_ratio_to_bound")}});
}

void methods(RackReproduction& run) {
  const std::string study = "Four pipes, 25 points each, quantised pixels and 2 px of noise";
  const auto model = rack_study::parallel_rack(4);
  rack_study::PoseRunSettings settings;
  settings.points = kPointsPerPipe * model.pipes.size();
  settings.camera.noise = 2;
  settings.camera.quantised = true;
  const Runs clean = fly(run, study, model, settings);

  auto with_outliers = settings;
  with_outliers.camera.outlier_share = 0.3;
  with_outliers.camera.outlier_reach = 40;
  const Runs outliers = fly(run, study + ", 30 % gross outliers", model, with_outliers);

  const auto ratio = [&](double (PoseErrors::*value)() const noexcept) {
    return (outliers.all.*value)() / (clean.all.*value)();
  };
  std::vector<Measure> measures{
      {"position, root mean square, m", clean.all.position_rms(),
       clean.values(&PoseErrors::position_rms)},
      {"orientation, root mean square, deg", clean.all.orientation_rms_degrees(),
       clean.values(&PoseErrors::orientation_rms_degrees)},
      {"position with 30 % outliers against without",
       ratio(&PoseErrors::position_rms),
       {},
       {.most = 1.6},
       "outlier30_position_ratio"},
      {"orientation with 30 % outliers against without",
       ratio(&PoseErrors::orientation_rms_degrees),
       {}}};
  for (const auto method : {rack_vision::SolverMethod::kLippielloLeastSquares,
                            rack_vision::SolverMethod::kLippielloSaliency}) {
    for (const bool disturbed : {false, true}) {
      auto literal = disturbed ? with_outliers : settings;
      literal.solver.method = method;
      const std::string name =
          std::string(to_string(method)) + (disturbed ? ", 30 % outliers" : "");
      const Runs runs = fly(run, name, model, literal);
      measures.push_back({name + ": position, m", runs.all.position_rms(),
                          runs.values(&PoseErrors::position_rms)});
    }
  }
  run.rows.add_study(study, measures);
}

void offsets(RackReproduction& run) {
  const std::string study = "Summed distances of the pipes, 15/35/50 cm said, 10/20/30 true";
  std::vector<double> ideal, noisy, nees, pushed, creeping;
  run.progress.begin(study, run.seeds.size());
  for (const auto seed : run.seeds) {
    constexpr std::size_t kAfter = 25;
    const auto wrong = rack_study::OffsetScenario::kWrongModel;
    const auto moving = rack_study::OffsetScenario::kMovingPipes;
    const auto without = rack_study::run_offsets({.scenario = wrong, .frames = 50}, seed);
    ideal.push_back(
        static_cast<double>(rack_study::frames_until(without, &OffsetFrame::largest_error, 0.001)));
    const auto with = rack_study::run_offsets({.scenario = wrong, .noise = true}, seed);
    noisy.push_back(with[kAfter - 1].largest_error);
    nees.push_back(with[kAfter - 1].consistency / 3);
    const auto moved = rack_study::run_offsets({.scenario = moving, .noise = true}, seed);
    pushed.push_back(static_cast<double>(rack_study::frames_until(
        moved, &OffsetFrame::step_error, 0.01, rack_study::kPushedAtFrame)));
    creeping.push_back(moved.back().largest_error);
    run.progress.step();
  }
  run.progress.end();
  // 95 % of the means of this many chi-square values of three degrees of freedom, over three
  // (Wilson and Hilferty).
  const double degrees = 3 * static_cast<double>(nees.size());
  const auto bound = [&](double z) {
    return std::pow(1 - 2 / (9 * degrees) + z * std::sqrt(2 / (9 * degrees)), 3);
  };
  run.rows.add_study(
      study, {{"frames to 1 mm without noise",
               largest(ideal),
               ideal,
               {.most = 5},
               "offsets_ideal_frames_to_1mm"},
              {"largest error after 25 frames with noise, m",
               largest(noisy),
               noisy,
               {.most = 0.005},
               "offsets_noise_error_m"},
              {"squared error / covariance, after 25 frames",
               mean(nees),
               nees,
               {.least = bound(-1.96), .most = bound(1.96)},
               "offsets_nees"},
              {"pipe pushed by 3 cm in flight: frames to 1 cm for good", largest(pushed), pushed},
              {"largest error 5 s after that, another creeping by 0.2 mm/s, m", largest(creeping),
               creeping}});
}

void first_poses(RackReproduction& run) {
  const std::string study = "Initial pose wrong by 5 cm and 5 deg, features";
  std::vector<double> wrong, refused;
  run.progress.begin(study, run.seeds.size());
  const std::size_t trials =
      (run.extent.first_pose_trials + run.seeds.size() - 1) / run.seeds.size();
  for (const auto seed : run.seeds) {
    auto score = rack_study::try_first_poses({}, trials / 2, seed);
    score += rack_study::try_first_poses({.outlier_share = 0.3}, trials - trials / 2, seed);
    wrong.push_back(static_cast<double>(score.silent_wrong));
    refused.push_back(static_cast<double>(score.refused));
    run.progress.step();
  }
  run.progress.end();
  const double all = static_cast<double>(trials * run.seeds.size());
  run.rows.add_study(study,
                     {{"trials, half of them with 30 % outliers", all, {}},
                      {"wrong and not detected",
                       std::accumulate(wrong.begin(), wrong.end(), 0.0),
                       wrong,
                       {.most = 0},
                       "features_silent_wrong_pose"},
                      {"refused", std::accumulate(refused.begin(), refused.end(), 0.0), refused}});
}

}  // namespace

void reproduce_rack_features(RackReproduction& run) {
  ideal_run(run);
  table_one(run, 20, true);
  table_one(run, 50, false);
  methods(run);
  offsets(run);
  first_poses(run);
}

}  // namespace pipescout::reproduce
