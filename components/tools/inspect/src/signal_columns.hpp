// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "pipescout/csv/csv_format.hpp"

/// Which columns of a user's CSV file are the signal of an eddy-current probe. Format:
/// docs/weld_inspection.md.
namespace pipescout::inspect {

struct SignalColumns {
  std::string path;    ///< of the YAML file, for messages; empty: the names are the defaults
  CsvFormat format{};  ///< of the file, as far as the mapping says it
  std::string distance = "distance_m";
  double metres_per_unit = 1.0;  ///< of `distance`
  /// Columns of the two components of each channel, as many of one as of the other; empty: x and y,
  /// or x1, y1, x2, y2, ..., whichever the file has.
  std::vector<std::string> x;
  std::vector<std::string> y;
};

/// Throws YamlError, "file:line:column: message", for unknown and missing keys and for values that
/// are not what their key wants.
[[nodiscard]] SignalColumns load_signal_columns(const std::string& path);

}  // namespace pipescout::inspect
