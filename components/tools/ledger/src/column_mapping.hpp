// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipescout/csv/csv_format.hpp"
#include "pipescout/odometry/weld_ledger.hpp"

/// Which columns of somebody's list of an inspection mean what. Format: docs/weld_ledger.md.
namespace pipescout::ledger {

/// A column that the mapping names.
struct MappedColumn {
  std::string name;
  std::string location;  ///< "file:line:column" in the mapping
};

struct ColumnMapping {
  std::string path;              ///< of the YAML file, for messages
  CsvFormat format{};            ///< of the list, as far as the mapping says it
  MappedColumn distance;         ///< by the run's odometer
  double metres_per_unit = 1.0;  ///< of `distance` and `relative_distance`
  MappedColumn kind;
  std::vector<std::string> girth_welds;  ///< values of `kind`; at least one
  struct Landmarks {
    odometry::LandmarkKind kind;
    std::vector<std::string> names;  ///< values of `kind`
  };
  std::vector<Landmarks> landmarks;
  std::optional<MappedColumn> clock;
  std::optional<MappedColumn>
      relative_distance;                 ///< of a feature from the weld above it in the list
  std::optional<MappedColumn> latitude;  ///< with a longitude
  std::optional<MappedColumn> longitude;
  std::optional<MappedColumn> height;  ///< with both
  double metres_per_height_unit = 1.0;
  double odometer_standard_deviation = 0.01;  ///< m / sqrt(m), in (0, 1]
  double weld_standard_deviation = 0.05;      ///< m, of one weld's distance, in (0, 10]
  double landmark_standard_deviation = 0.3;   ///< m, of one landmark's distance, in (0, 10]
  double position_standard_deviation = 1.0;   ///< m, of latitude, longitude, height, in (0, 1000]
};

/// Throws YamlError, "file:line:column: message", for unknown and missing keys and for values that
/// are not what their key wants.
[[nodiscard]] ColumnMapping load_column_mapping(const std::string& path);
/// The same from text; `path` names it.
[[nodiscard]] ColumnMapping parse_column_mapping(const std::string& text, const std::string& path);

/// For a list with the columns of a pipe tally by the Pipeline Operators Forum ("Log distance [m]",
/// "Feature type", "Abs. dist. to upstream weld [m]", ...; POF 100, 2021, and before), which says
/// its unit: nothing for other lists. `columns`: of the list; `format`: its own.
[[nodiscard]] std::optional<ColumnMapping> pof_column_mapping(
    const std::vector<std::string>& columns, const CsvFormat& format);

}  // namespace pipescout::ledger
