// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pipescout/rack_study/pose_run.hpp"

/// Table I of Lippiello and Cacace: pose error by the number of pipes and of texture points.
namespace pipescout::rack_study {

struct TableCell {
  int pipes = 0;
  std::size_t points = 0;        ///< over the whole rack
  double paper_position = 0;     ///< m, mean as printed
  double paper_orientation = 0;  ///< deg
};

/// The 20 cells, by pipes, then by points.
[[nodiscard]] std::span<const TableCell> table_one_cells();

struct CellScore {
  PoseErrors all;                   ///< over all runs
  std::vector<double> position;     ///< m, mean of the norms, per run
  std::vector<double> orientation;  ///< deg
  /// At most half of the paper's in position and in orientation; more than the paper's in either.
  [[nodiscard]] bool half_of(const TableCell& cell) const;
  [[nodiscard]] bool above(const TableCell& cell) const;
  /// Whether a perfect single-frame estimate of these features could be `half_of`: the bound's root
  /// mean square, put in the ratio that mean and root mean square of our errors have.
  [[nodiscard]] bool bound_half_of(const TableCell& cell) const;
  [[nodiscard]] bool bound_above(const TableCell& cell) const;
  /// The larger one of position and orientation.
  [[nodiscard]] double ratio_to_bound() const;
};

struct TableOneSettings {
  int samples_per_edge = 20;  ///< as the paper has it; its authors' published simulation: 50
  /// See PoseRunSettings: the only help for frames in which no texture point is seen.
  double along_deviation = 0.25;
  std::size_t every = 1;  ///< only each n-th frame of the flight, for short tests
};

/// One run of a cell: gusts, pixels with 2 px of noise and quantised, one pose per frame without
/// smoothing over time.
[[nodiscard]] PoseErrors run_cell(const TableCell& cell, const TableOneSettings& settings,
                                  std::uint64_t seed);

/// All runs of a cell.
[[nodiscard]] CellScore score_cell(const TableCell& cell, const TableOneSettings& settings,
                                   std::span<const std::uint64_t> seeds);

}  // namespace pipescout::rack_study
