// SPDX-License-Identifier: Apache-2.0
#include "pipescout/weld_ledger/weld_ledger_text.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <utility>

#include "pipescout/csv/csv_cell.hpp"
#include "pipescout/csv/csv_table.hpp"

namespace pipescout {
namespace {

using odometry::LedgerLandmark;
using odometry::LedgerRun;
using odometry::LedgerSighting;
using odometry::LedgerWeld;
using odometry::MapFrame;
using odometry::MapPosition;
using odometry::WeldEvidence;
using odometry::WeldLedger;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// m: joint lengths and chainages that were rounded to centimetres by hand still agree.
constexpr double kAgreement = 0.02;

constexpr std::string_view kWeld = "weld";  // as a kind
constexpr const char* kAngle = "angle_deg";
constexpr double kHalfTurn = 180.0;  // degrees
constexpr double kAngleDigits =
    1e9;  // per degree: what is lost between degrees and rad is not written
constexpr std::string_view kRun = "run ";
constexpr std::string_view kRunChainage = " chainage_m";
constexpr std::string_view kRunSigma = " sd_m";

std::array<const char*, 3> map_columns(MapFrame frame) {
  return frame == MapFrame::kGeodetic
             ? std::array<const char*, 3>{"latitude_deg", "longitude_deg", "height_m"}
             : std::array<const char*, 3>{"x_m", "y_m", "z_m"};
}

std::string run_column(const LedgerRun& run, std::string_view what) {
  return std::string(kRun) + run.name + '|' + run.date + std::string(what);
}

/// Some rows of a ledger's table, by names of columns.
class Table {
 public:
  /// All rows.
  explicit Table(const CsvTable& table) : table_(&table), rows_(table.rows()) {
    std::iota(rows_.begin(), rows_.end(), std::size_t{0});
    for (std::size_t column = 0; column < table.columns().size(); ++column) {
      if (!columns_.emplace(table.columns()[column], column).second) {
        fail_header(table.columns()[column], "duplicate column");
      }
    }
  }

  /// The rows whose kind is that of a weld, or the others.
  [[nodiscard]] Table of_welds(bool welds) const {
    Table part(*this);
    std::erase_if(part.rows_, [&](std::size_t row) { return is_weld(row) != welds; });
    return part;
  }

  [[nodiscard]] std::size_t size() const { return rows_.size(); }
  [[nodiscard]] const std::vector<std::string>& header() const { return table_->columns(); }
  [[nodiscard]] bool has(const std::string& column) const { return columns_.contains(column); }

  [[nodiscard]] const std::string& cell(std::size_t row, const std::string& column) const {
    return table_->cell(rows_[row], columns_.at(column));
  }

  /// A finite number; above 0 when `positive`.
  [[nodiscard]] double required(std::size_t row, const std::string& column, bool positive) const {
    const double value = table_->required(rows_[row], columns_.at(column));
    if (positive && value <= 0.0) {
      fail(row, column, cell(row, column) + " is not above 0");
    }
    return value;
  }

  [[noreturn]] void fail(std::size_t row, const std::string& column,
                         const std::string& what) const {
    table_->refuse(rows_[row], columns_.at(column), what);
  }
  /// `column` may be one that there is not.
  [[noreturn]] void fail_header(const std::string& column, const std::string& what) const {
    throw CsvError(table_->path(), table_->header_line(), "column '" + column + "': " + what);
  }

 private:
  [[nodiscard]] bool is_weld(std::size_t row) const {
    const auto kind = columns_.find("kind");
    return kind == columns_.end() || table_->cell(row, kind->second).empty() ||
           table_->cell(row, kind->second) == kWeld;
  }

  const CsvTable* table_;
  std::vector<std::size_t> rows_;  // of it
  std::map<std::string, std::size_t, std::less<>> columns_;
};

/// The runs that the header names; throws for columns that mean nothing.
std::vector<LedgerRun> read_header(const Table& table) {
  static const std::set<std::string, std::less<>> known = {"id",
                                                           "kind",
                                                           "angle_deg",
                                                           "chainage_m",
                                                           "chainage_sd_m",
                                                           "joint_length_m",
                                                           "joint_length_sd_m",
                                                           "seen",
                                                           "passed",
                                                           "latitude_deg",
                                                           "longitude_deg",
                                                           "height_m",
                                                           "position_sd_m",
                                                           "x_m",
                                                           "y_m",
                                                           "z_m"};
  const auto fail = [&](const std::string& column, const std::string& what) {
    table.fail_header(column, what);
  };
  std::vector<LedgerRun> runs;
  for (const std::string& column : table.header()) {
    if (known.contains(column)) {
      continue;
    }
    const auto bar = column.find('|');
    const bool of_run = column.starts_with(kRun) && bar != std::string::npos && bar > kRun.size();
    if (of_run && column.ends_with(kRunChainage)) {
      const LedgerRun run{
          .name = column.substr(kRun.size(), bar - kRun.size()),
          .date = column.substr(bar + 1, column.size() - kRunChainage.size() - bar - 1)};
      if (column.find_first_of("|\r\n", bar + 1) != std::string::npos) {
        fail(column, "the name or the date of a run holds '|' or a line break");
      }
      if (!table.has(run_column(run, kRunSigma))) {
        fail(run_column(run, kRunSigma), "the column is missing");
      }
      runs.push_back(run);
    } else if (of_run && column.ends_with(kRunSigma)) {
      const std::string partner =
          column.substr(0, column.size() - kRunSigma.size()) + std::string(kRunChainage);
      if (!table.has(partner)) {
        fail(partner, "the column is missing");
      }
    } else {
      fail(column, "is not a column of a ledger");
    }
  }
  if (!table.has("id")) {
    fail("id", "the column is missing");
  }
  if (!table.has("chainage_m") && !table.has("joint_length_m")) {
    fail("joint_length_m", "the column is missing, and chainage_m too");
  }
  return runs;
}

/// Chainage and joint length of every weld, each from the other where a column is missing.
void read_lengths(const Table& table, WeldLedger& ledger) {
  const bool has_chainage = table.has("chainage_m");
  const bool has_joint = table.has("joint_length_m");
  std::vector<LedgerWeld>& welds = ledger.welds;
  for (std::size_t k = 0; k < welds.size(); ++k) {
    const bool last = k + 1 == welds.size();
    if (has_joint) {
      if (!last) {
        welds[k].joint_length = table.required(k, "joint_length_m", true);
      } else if (!table.cell(k, "joint_length_m").empty()) {
        table.fail(k, "joint_length_m", "the last weld has no joint after it");
      }
    }
    if (has_chainage) {
      welds[k].chainage = table.required(k, "chainage_m", false);
    } else if (k > 0) {
      welds[k].chainage = welds[k - 1].chainage + welds[k - 1].joint_length;
    }
    if (k == 0) {
      continue;
    }
    const double length = welds[k].chainage - welds[k - 1].chainage;
    if (!(length > 0.0)) {
      table.fail(k, has_chainage ? "chainage_m" : "joint_length_m",
                 format_optional_csv_number(welds[k].chainage) + " is not above " +
                     format_optional_csv_number(welds[k - 1].chainage));
    }
    if (!has_joint) {
      welds[k - 1].joint_length = length;
    } else if (!(std::abs(length - welds[k - 1].joint_length) <= kAgreement)) {
      table.fail(k - 1, "joint_length_m",
                 format_optional_csv_number(welds[k - 1].joint_length) +
                     " is not the distance to the next chainage, " +
                     format_optional_csv_number(length));
    }
  }
}

void read_deviations(const Table& table, WeldLedger& ledger, double fallback) {
  for (std::size_t k = 0; k < ledger.welds.size(); ++k) {
    LedgerWeld& weld = ledger.welds[k];
    const bool last = k + 1 == ledger.welds.size();
    weld.standard_deviation =
        table.has("chainage_sd_m") ? table.required(k, "chainage_sd_m", true) : fallback;
    if (last) {
      if (table.has("joint_length_sd_m") && !table.cell(k, "joint_length_sd_m").empty()) {
        table.fail(k, "joint_length_sd_m", "the last weld has no joint after it");
      }
    } else {
      weld.joint_standard_deviation = table.has("joint_length_sd_m")
                                          ? table.required(k, "joint_length_sd_m", true)
                                          : std::sqrt(2.0) * fallback;
    }
  }
}

MapFrame read_frame(const Table& table) {
  const bool geodetic = table.has("latitude_deg");
  const bool local = table.has("x_m");
  if (geodetic && local) {
    table.fail_header("x_m", "latitude_deg is given too: a ledger has one map");
  }
  const MapFrame frame = geodetic ? MapFrame::kGeodetic
                         : local  ? MapFrame::kLocal
                                  : MapFrame::kNone;
  for (const MapFrame possible : {MapFrame::kGeodetic, MapFrame::kLocal}) {
    for (const char* column : map_columns(possible)) {
      if (table.has(column) != (possible == frame)) {
        table.fail_header(
            column, possible == frame ? "the column is missing" : "is an incomplete position");
      }
    }
  }
  if (table.has("position_sd_m") != (frame != MapFrame::kNone)) {
    table.fail_header("position_sd_m", frame != MapFrame::kNone ? "the column is missing"
                                                                : "is an incomplete position");
  }
  return frame;
}

/// Of welds or of landmarks.
template <typename Place>
void read_positions(const Table& table, MapFrame frame, std::vector<Place>& places) {
  if (frame == MapFrame::kNone) {
    return;
  }
  const auto columns = map_columns(frame);
  for (std::size_t k = 0; k < places.size(); ++k) {
    const bool empty = table.cell(k, "position_sd_m").empty() &&
                       std::all_of(columns.begin(), columns.end(), [&](const char* column) {
                         return table.cell(k, column).empty();
                       });
    if (empty) {
      continue;
    }
    MapPosition position;
    for (std::size_t axis = 0; axis < columns.size(); ++axis) {
      position.coordinates[axis] = table.required(k, columns[axis], false);
      const double limit = axis == 0 ? 90.0 : 180.0;
      if (frame == MapFrame::kGeodetic && axis < 2 &&
          std::abs(position.coordinates[axis]) > limit) {
        table.fail(k, columns[axis],
                   table.cell(k, columns[axis]) + " is outside [-" +
                       format_optional_csv_number(limit) + ", " +
                       format_optional_csv_number(limit) + "]");
      }
    }
    position.standard_deviation = table.required(k, "position_sd_m", false);
    if (position.standard_deviation < 0.0) {
      table.fail(k, "position_sd_m", table.cell(k, "position_sd_m") + " is below 0");
    }
    places[k].position = position;
  }
}

void read_sightings(const Table& table, WeldLedger& ledger) {
  for (std::size_t run = 0; run < ledger.runs.size(); ++run) {
    const std::string chainage = run_column(ledger.runs[run], kRunChainage);
    const std::string sigma = run_column(ledger.runs[run], kRunSigma);
    double previous = kNaN;
    double direction = 0.0;
    for (std::size_t k = 0; k < ledger.welds.size(); ++k) {
      if (table.cell(k, chainage).empty() && table.cell(k, sigma).empty()) {
        continue;
      }
      const LedgerSighting sighting{.run = run,
                                    .chainage = table.required(k, chainage, false),
                                    .standard_deviation = table.required(k, sigma, true)};
      if (!std::isnan(previous)) {
        const double step = sighting.chainage - previous;
        direction = direction == 0.0 ? step : direction;
        if (!(step * direction > 0.0)) {
          table.fail(k, chainage,
                     table.cell(k, chainage) + " does not continue from " +
                         format_optional_csv_number(previous));
        }
      }
      previous = sighting.chainage;
      ledger.welds[k].sightings.push_back(sighting);
    }
  }
}

odometry::LandmarkKind landmark_kind(const Table& table, std::size_t row) {
  std::string kinds(kWeld);
  for (const odometry::LandmarkKind kind : odometry::kLandmarkKinds) {
    if (table.cell(row, "kind") == to_string(kind)) {
      return kind;
    }
    kinds += std::string(", ") + to_string(kind);
  }
  table.fail(row, "kind", "'" + table.cell(row, "kind") + "' is none of " + kinds);
}

/// Of bends only; NaN where the ledger does not say it.
double read_angle(const Table& table, std::size_t row, odometry::LandmarkKind kind) {
  if (!table.has(kAngle) || table.cell(row, kAngle).empty()) {
    return kNaN;
  }
  if (kind != odometry::LandmarkKind::kBend) {
    table.fail(row, kAngle, std::string("a ") + to_string(kind) + " has no angle");
  }
  const double degrees = table.required(row, kAngle, true);
  if (degrees > kHalfTurn) {
    table.fail(row, kAngle, table.cell(row, kAngle) + " is above 180");
  }
  return degrees / kHalfTurn * std::numbers::pi;
}

void read_landmarks(const Table& table, WeldLedger& ledger, double fallback) {
  if (table.size() > 0 && !table.has("chainage_m")) {
    table.fail_header("chainage_m", "the column is missing, and landmarks need it");
  }
  ledger.landmarks.resize(table.size());
  for (std::size_t k = 0; k < table.size(); ++k) {
    LedgerLandmark& landmark = ledger.landmarks[k];
    landmark.kind = landmark_kind(table, k);
    landmark.id = table.cell(k, "id");
    landmark.angle = read_angle(table, k, landmark.kind);
    landmark.chainage = table.required(k, "chainage_m", false);
    landmark.standard_deviation =
        table.has("chainage_sd_m") ? table.required(k, "chainage_sd_m", true) : fallback;
    for (std::size_t run = 0; run < ledger.runs.size(); ++run) {
      const std::string chainage = run_column(ledger.runs[run], kRunChainage);
      const std::string sigma = run_column(ledger.runs[run], kRunSigma);
      if (!table.cell(k, chainage).empty() || !table.cell(k, sigma).empty()) {
        landmark.sightings.push_back({.run = run,
                                      .chainage = table.required(k, chainage, false),
                                      .standard_deviation = table.required(k, sigma, true)});
      }
    }
  }
  read_positions(table, ledger.frame, ledger.landmarks);
}

/// What a row says of a weld or a landmark behind its own columns: the map and the runs.
template <typename Place>
std::string rest_of_row(const WeldLedger& ledger, const Place& place) {
  std::string text;
  if (ledger.frame != MapFrame::kNone) {
    const MapPosition position = place.position.value_or(MapPosition{});
    for (const double coordinate : position.coordinates) {
      text += ',' + format_optional_csv_number(coordinate);
    }
    text += ',' + format_optional_csv_number(position.standard_deviation);
  }
  std::vector<LedgerSighting> by_run(ledger.runs.size(),
                                     {.chainage = kNaN, .standard_deviation = kNaN});
  for (const LedgerSighting& sighting : place.sightings) {
    by_run[sighting.run] = sighting;
  }
  for (const LedgerSighting& sighting : by_run) {
    text += ',' + format_optional_csv_number(sighting.chainage) + ',' +
            format_optional_csv_number(sighting.standard_deviation);
  }
  return text + '\n';
}

std::string landmark_row(const WeldLedger& ledger, const LedgerLandmark& landmark,
                         bool has_angles) {
  const double degrees = landmark.angle / std::numbers::pi * kHalfTurn;
  const std::string angle =
      has_angles
          ? ',' + format_optional_csv_number(std::round(degrees * kAngleDigits) / kAngleDigits)
          : "";
  return csv_cell(landmark.id) + ',' + to_string(landmark.kind) + angle + ',' +
         format_optional_csv_number(landmark.chainage) + ',' +
         format_optional_csv_number(landmark.standard_deviation) + ",,," +
         std::to_string(landmark.sightings.size()) + ',' + rest_of_row(ledger, landmark);
}

}  // namespace

std::string to_csv(const WeldLedger& ledger) {
  // Programs that know no landmarks read the ledgers that have none.
  const bool has_landmarks = !ledger.landmarks.empty();
  const bool has_angles = std::ranges::any_of(
      ledger.landmarks, [](const LedgerLandmark& bend) { return !std::isnan(bend.angle); });
  std::string text = std::string("id,") + (has_landmarks ? "kind," : "") +
                     (has_angles ? std::string(kAngle) + ',' : "") +
                     "chainage_m,chainage_sd_m,joint_length_m,joint_length_sd_m,seen,passed";
  if (ledger.frame != MapFrame::kNone) {
    for (const char* column : map_columns(ledger.frame)) {
      text += std::string(",") + column;
    }
    text += ",position_sd_m";
  }
  for (const LedgerRun& run : ledger.runs) {
    text +=
        ',' + csv_cell(run_column(run, kRunChainage)) + ',' + csv_cell(run_column(run, kRunSigma));
  }
  text += '\n';
  const std::vector<WeldEvidence> believed = evidence(ledger);
  auto landmark = ledger.landmarks.begin();
  for (std::size_t k = 0; k < ledger.welds.size(); ++k) {
    const LedgerWeld& weld = ledger.welds[k];
    for (; landmark != ledger.landmarks.end() && landmark->chainage < weld.chainage; ++landmark) {
      text += landmark_row(ledger, *landmark, has_angles);
    }
    text += csv_cell(weld.id);
    if (has_landmarks) {
      text += ',' + std::string(kWeld) + (has_angles ? "," : "");
    }
    for (const double value : {weld.chainage, weld.standard_deviation, weld.joint_length,
                               weld.joint_standard_deviation}) {
      text += ',' + format_optional_csv_number(value);
    }
    text += ',' + std::to_string(believed[k].seen) + ',' + std::to_string(believed[k].passed);
    text += rest_of_row(ledger, weld);
  }
  for (; landmark != ledger.landmarks.end(); ++landmark) {
    text += landmark_row(ledger, *landmark, has_angles);
  }
  return text;
}

WeldLedger ledger_from_csv(const CsvTable& csv, double default_standard_deviation) {
  if (!(std::isfinite(default_standard_deviation) && default_standard_deviation > 0.0)) {
    throw std::invalid_argument(
        "default_standard_deviation: " + format_csv_number(default_standard_deviation) +
        " is outside (0, infinity)");
  }
  const Table all(csv);
  const Table table = all.of_welds(true);
  WeldLedger ledger;
  ledger.runs = read_header(table);
  std::set<std::string> ids;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (all.cell(k, "id").empty()) {
      all.fail(k, "id", "is missing");
    }
    if (!ids.insert(all.cell(k, "id")).second) {
      all.fail(k, "id", "'" + all.cell(k, "id") + "' is a duplicate");
    }
  }
  ledger.welds.resize(table.size());
  for (std::size_t k = 0; k < table.size(); ++k) {
    ledger.welds[k].id = table.cell(k, "id");
  }
  read_lengths(table, ledger);
  read_deviations(table, ledger, default_standard_deviation);
  ledger.frame = read_frame(table);
  read_positions(table, ledger.frame, ledger.welds);
  read_sightings(table, ledger);
  read_landmarks(all.of_welds(false), ledger, default_standard_deviation);
  if (ledger.runs.empty()) {
    ledger.runs.push_back({.name = "tally", .date = ""});
    const auto see = [&](auto& place) {
      place.sightings = {
          {.run = 0, .chainage = place.chainage, .standard_deviation = default_standard_deviation}};
    };
    std::ranges::for_each(ledger.welds, see);
    std::ranges::for_each(ledger.landmarks, see);
  }
  std::ranges::stable_sort(ledger.landmarks, {}, &LedgerLandmark::chainage);
  return ledger;
}

}  // namespace pipescout
