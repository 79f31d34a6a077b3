// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "column_mapping.hpp"
#include "pipescout/odometry/weld_ledger.hpp"

/// The files that `pipescout ledger` reads. All functions throw CsvError, "file:line: column 'x':
/// ...", for what cannot be used: nothing is guessed.
namespace pipescout::ledger {

/// What a list holds besides girth welds.
struct RunFeature {
  std::size_t line = 0;   ///< of the file, from 1
  std::string kind;       ///< as in the file
  std::string clock;      ///< o'clock as in the file; may be empty
  double chainage = 0.0;  ///< m, by the run's odometer
  /// m, from the girth weld above it in the list: as the list says, and by the odometer. NaN: not
  /// said, or no such weld.
  double given_from_weld = 0.0;
  double from_weld = 0.0;
};

/// One run, or a tally of the pipe's construction.
struct RunFile {
  std::string path;
  std::vector<odometry::WeldPosition> welds;                    ///< chainage rises strictly
  std::vector<std::optional<odometry::MapPosition>> positions;  ///< geodetic, one per weld
  std::vector<RunFeature> features;                             ///< in the order of the file
  std::vector<odometry::LandmarkPosition> landmarks;            ///< features of it among them
  double length_noise =
      odometry::LedgerParameters{}.length_noise;  ///< m / sqrt(m), of its odometer
  /// Of a file in the ledger's own format, which needs no mapping and has no features.
  std::optional<odometry::WeldLedger> ledger;
  std::vector<std::string> notes;  ///< how the file was read, where that is a guess
};

struct LedgerFile {
  odometry::WeldLedger ledger;
  std::vector<std::string> notes;
};

struct SurveyFile {
  odometry::CentreLine line;
  std::vector<std::string> notes;
};

/// A list whose columns the mapping names.
[[nodiscard]] RunFile read_run(const std::string& path, const ColumnMapping& mapping);
/// A ledger or a tally in the ledger's own format, or a list with the columns of the Pipeline
/// Operators Forum. `format`: as far as the user says it.
[[nodiscard]] RunFile read_run(const std::string& path, const CsvFormat& format);

[[nodiscard]] LedgerFile read_ledger(const std::string& path, const CsvFormat& format);

/// Points along the pipe: latitude_deg, longitude_deg, height_m or x_m, y_m, z_m, and optionally
/// position_sd_m (1 m without it) and chainage_m (may be empty). Other columns are passed over, so
/// that a ledger with a map is a survey too.
[[nodiscard]] SurveyFile read_survey(const std::string& path, const CsvFormat& format);

}  // namespace pipescout::ledger
