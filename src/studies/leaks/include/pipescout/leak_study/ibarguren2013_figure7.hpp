// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/thermal/pipe_profile.hpp"

/// Figure 7 of Ibarguren and others (2013): mean temperatures of successive parts of pipes in 13
/// recorded sequences, each with a leak. The numbers are in `ibarguren2013_figure7.csv` of this
/// package, without the paper's red marking of leaks.
namespace pipescout::leak_study {

struct Figure7Part {
  std::string sequence;  ///< "PIA2", ...
  int stretch = 1;       ///< parts of different stretches are not adjacent
  int part = 1;          ///< from 1 on, along the pipe
  double mean = 0;       ///< degC
};

/// Parses CSV with the columns sequence, stretch, part and mean_temperature; `path` names it in
/// messages. Throws CsvError.
[[nodiscard]] std::vector<Figure7Part> read_figure7(std::string_view csv, std::string_view path);

struct Figure7Labels {
  std::vector<thermal::PartKind> kinds;  ///< of each part
  std::size_t sequences = 0;             ///< total
  std::size_t flagged = 0;               ///< of them, with a part labelled as leak
  double warmest_sound = 0;              ///< degC, of the parts that are not labelled as leaks
  double coldest_leak = 0;               ///< degC, of those that are
  /// degC, half-way between the two: all parts above it are labelled, and none below. NaN when no
  /// threshold separates them.
  double cut_off = 0;
};

/// Converts each stretch to a profile, with 20 samples per part and, in between, a joint of 3
/// samples that is 100 K warmer than its neighbours, or colder where the camera's range ends at 300
/// degC; then splits, filters and labels it. Throws as thermal::ProfileParameters::validate.
[[nodiscard]] Figure7Labels label_figure7(std::span<const Figure7Part> parts,
                                          const thermal::ProfileParameters& parameters);

}  // namespace pipescout::leak_study
