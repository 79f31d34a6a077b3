// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/table_one.hpp"

#include <algorithm>

#include "pipescout/rack_study/paper_flight.hpp"

namespace pipescout::rack_study {

std::span<const TableCell> table_one_cells() {
  static constexpr std::array kCells{
      TableCell{2, 10, 0.145, 1.9},  TableCell{2, 20, 0.12, 1.5},   TableCell{2, 30, 0.11, 1.2},
      TableCell{2, 40, 0.1, 0.9},    TableCell{2, 50, 0.09, 0.8},   TableCell{3, 10, 0.139, 1.85},
      TableCell{3, 20, 0.124, 1.55}, TableCell{3, 30, 0.115, 1.2},  TableCell{3, 40, 0.12, 0.8},
      TableCell{3, 50, 0.085, 0.79}, TableCell{4, 10, 0.13, 1.2},   TableCell{4, 20, 0.12, 1.15},
      TableCell{4, 30, 0.11, 0.9},   TableCell{4, 40, 0.09, 0.9},   TableCell{4, 50, 0.07, 0.6},
      TableCell{5, 10, 0.12, 1.0},   TableCell{5, 20, 0.115, 1.15}, TableCell{5, 30, 0.112, 0.8},
      TableCell{5, 40, 0.09, 0.8},   TableCell{5, 50, 0.08, 0.5},
  };
  return kCells;
}

bool CellScore::half_of(const TableCell& cell) const {
  return 2 * all.position_mean() <= cell.paper_position &&
         2 * all.orientation_mean_degrees() <= cell.paper_orientation;
}

bool CellScore::above(const TableCell& cell) const {
  return all.position_mean() > cell.paper_position ||
         all.orientation_mean_degrees() > cell.paper_orientation;
}

bool CellScore::bound_half_of(const TableCell& cell) const {
  return 2 * all.position_mean() / all.position_ratio() <= cell.paper_position &&
         2 * all.orientation_mean_degrees() / all.orientation_ratio() <= cell.paper_orientation;
}

bool CellScore::bound_above(const TableCell& cell) const {
  return all.position_mean() / all.position_ratio() > cell.paper_position ||
         all.orientation_mean_degrees() / all.orientation_ratio() > cell.paper_orientation;
}

double CellScore::ratio_to_bound() const {
  return std::max(all.position_ratio(), all.orientation_ratio());
}

PoseErrors run_cell(const TableCell& cell, const TableOneSettings& settings, std::uint64_t seed) {
  const auto model = parallel_rack(cell.pipes);
  auto flight = paper_flight(model, {}, seed);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < flight.size(); i += settings.every) {
    flight[kept++] = flight[i];
  }
  flight.resize(kept);
  PoseRunSettings run;
  run.camera = {.samples_per_edge = settings.samples_per_edge, .noise = 2, .quantised = true};
  run.points = cell.points;
  run.along_deviation = settings.along_deviation;
  run.with_bound = true;
  return run_poses(model, flight, run, seed);
}

CellScore score_cell(const TableCell& cell, const TableOneSettings& settings,
                     std::span<const std::uint64_t> seeds) {
  CellScore score;
  for (const auto seed : seeds) {
    const PoseErrors run = run_cell(cell, settings, seed);
    score.all += run;
    score.position.push_back(run.position_mean());
    score.orientation.push_back(run.orientation_mean_degrees());
  }
  return score;
}

}  // namespace pipescout::rack_study
