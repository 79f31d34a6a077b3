// SPDX-License-Identifier: Apache-2.0
#include "run_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <utility>

#include "pipescout/command_line/suggestion.hpp"
#include "pipescout/csv/csv_file.hpp"
#include "pipescout/csv/csv_table.hpp"
#include "pipescout/csv/csv_words.hpp"
#include "pipescout/statistics/median.hpp"
#include "pipescout/weld_ledger/weld_ledger_text.hpp"

namespace pipescout::ledger {
namespace {

using command_line::suggestion;

using odometry::MapFrame;
using odometry::MapPosition;
using odometry::WeldLedger;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kSurveySigma = 1.0;  // m, of points that do not say
constexpr std::size_t kKindsShown = 30;
// m: the longest pipelines of the world are below 9000 km, in sections of some 100 km for a run.
constexpr double kLongestRun = 5e6;
// m: joints are 10 to 25 m long; with nine of ten welds missing no list can be aligned.
constexpr double kLongestJoint = 200.0;
constexpr std::size_t kEnoughJoints = 10;

/// The kinds of a list, the most frequent first: "'metal loss' (1625), 'GirthWeld' (1607)".
std::string kinds_of(const std::map<std::string, std::size_t>& counts) {
  std::vector<std::pair<std::string, std::size_t>> kinds(counts.begin(), counts.end());
  std::stable_sort(kinds.begin(), kinds.end(),
                   [](const auto& one, const auto& next) { return one.second > next.second; });
  std::string text;
  for (std::size_t k = 0; k < std::min(kinds.size(), kKindsShown); ++k) {
    text += (k > 0 ? ", '" : "'") + kinds[k].first + "' (" + std::to_string(kinds[k].second) + ")";
  }
  return text + (kinds.size() > kKindsShown ? ", ..." : "");
}

double required_angle(const CsvTable& table, std::size_t row, std::size_t column, double limit) {
  const double value = table.required(row, column);
  if (std::abs(value) > limit) {
    table.refuse(row, column,
                 table.cell(row, column) + " is outside [-" + format_csv_number(limit) + ", " +
                     format_csv_number(limit) + "] degrees");
  }
  return value;
}

/// A sentence goes on after a suggestion, and after none.
std::string sentence_end(const std::string& suggestion) {
  return suggestion.empty() ? ". " : suggestion + " ";
}

/// Reads one list through one mapping.
class ListReader {
 public:
  ListReader(const std::string& path, const ColumnMapping& mapping)
      : table_(read_csv_text(path), path, mapping.format),
        mapping_(mapping),
        distance_(column(mapping.distance, "the distance")),
        kind_(column(mapping.kind, "the kind of a row")),
        clock_(optional_column(mapping.clock, "the o'clock position")),
        relative_(optional_column(mapping.relative_distance, "the distance from the weld")),
        latitude_(optional_column(mapping.latitude, "the latitude")),
        longitude_(optional_column(mapping.longitude, "the longitude")),
        height_(optional_column(mapping.height, "the height")) {
    check_unit();
  }

  RunFile read() {
    run_.path = table_.path();
    run_.notes = table_.notes();
    run_.length_noise = mapping_.odometer_standard_deviation;
    std::vector<std::string> welds;
    std::ranges::transform(mapping_.girth_welds, std::back_inserter(welds), folded);
    std::map<std::string, std::size_t> counts;
    for (std::size_t row = 0; row < table_.rows(); ++row) {
      const std::string kind = folded(table_.cell(row, kind_));
      ++counts[kind];
      const double chainage = table_.required(row, distance_) * mapping_.metres_per_unit;
      if (std::ranges::find(welds, kind) != welds.end()) {
        add_weld(row, chainage);
      } else {
        add_feature(row, kind, chainage);
      }
    }
    if (run_.welds.empty()) {
      std::vector<std::string> known;
      for (const auto& [kind, count] : counts) {
        known.push_back(kind);
      }
      throw CsvError(table_.path(), 0,
                     "no girth weld: column '" + mapping_.kind.name + "' never says " +
                         quoted_list(mapping_.girth_welds) + " (girth_weld in " + mapping_.path +
                         ")" + sentence_end(suggestion(mapping_.girth_welds.front(), known)) +
                         "It says " + kinds_of(counts));
    }
    check_length();
    return std::move(run_);
  }

 private:
  /// What a row of units says of the distance, the mapping must say too.
  void check_unit() const {
    const std::string said = table_.numbers().unit(distance_);
    const auto metres = metres_per_list_unit(said);
    if (metres && *metres != mapping_.metres_per_unit) {
      throw CsvError(table_.path(), table_.header_line(),
                     "column '" + mapping_.distance.name + "' is in " + said +
                         ", and the unit in " + mapping_.path + " is another one");
    }
  }

  /// A wrong unit would give a ledger of a pipe that nobody has.
  void check_length() const {
    const double length = run_.welds.back().chainage - run_.welds.front().chainage;
    if (length > kLongestRun) {
      const auto km = [](double metres) {
        return std::to_string(std::lround(metres / 1000.0)) + " km";
      };
      throw CsvError(table_.path(), 0,
                     "from the first girth weld to the last are " + km(length) +
                         ", and no run is longer than " + km(kLongestRun) +
                         ": is the unit of column '" + mapping_.distance.name + "' right, which " +
                         mapping_.path + " has?");
    }
    std::vector<double> joints;
    for (std::size_t k = 1; k < run_.welds.size(); ++k) {
      joints.push_back(run_.welds[k].chainage - run_.welds[k - 1].chainage);
    }
    if (joints.size() < kEnoughJoints) {
      return;
    }
    const double joint = statistics::median_in_place(joints);
    if (joint > kLongestJoint) {
      throw CsvError(table_.path(), 0,
                     "from one girth weld to the next are " + std::to_string(std::lround(joint)) +
                         " m (the middle one of " + std::to_string(joints.size()) +
                         "), and no joint is longer than " + format_csv_number(kLongestJoint) +
                         " m: is the unit of column '" + mapping_.distance.name +
                         "' right, which " + mapping_.path + " has?");
    }
  }

  std::size_t column(const MappedColumn& wanted, const std::string& what) const {
    const auto found = table_.find_column(wanted.name);
    if (!found) {
      throw CsvError(table_.path(), table_.header_line(),
                     "no column '" + wanted.name + "', which " + wanted.location + " wants as " +
                         what + sentence_end(suggestion(wanted.name, table_.columns())) +
                         "The file has " + quoted_list(table_.columns()) + ". The mapping wants " +
                         quoted_list(wanted_columns()));
    }
    return *found;
  }

  std::optional<std::size_t> optional_column(const std::optional<MappedColumn>& wanted,
                                             const std::string& what) const {
    return wanted ? std::optional(column(*wanted, what)) : std::nullopt;
  }

  std::vector<std::string> wanted_columns() const {
    std::vector<std::string> names{mapping_.distance.name, mapping_.kind.name};
    for (const auto& wanted : {mapping_.clock, mapping_.relative_distance, mapping_.latitude,
                               mapping_.longitude, mapping_.height}) {
      if (wanted) {
        names.push_back(wanted->name);
      }
    }
    return names;
  }

  void add_weld(std::size_t row, double chainage) {
    if (!run_.welds.empty() && !(chainage > run_.welds.back().chainage)) {
      table_.refuse(row, distance_,
                    table_.cell(row, distance_) + " is not above " +
                        table_.cell(last_weld_, distance_) + ", the girth weld before, line " +
                        std::to_string(table_.line(last_weld_)));
    }
    run_.welds.push_back(
        {.chainage = chainage, .standard_deviation = mapping_.weld_standard_deviation});
    run_.positions.push_back(position(row));
    last_weld_ = row;
  }

  void add_feature(std::size_t row, const std::string& kind, double chainage) {
    RunFeature feature{.line = table_.line(row),
                       .kind = kind,
                       .clock = clock_ ? folded(table_.cell(row, *clock_)) : "",
                       .chainage = chainage,
                       .given_from_weld = kNaN,
                       .from_weld = kNaN};
    if (relative_) {
      if (const auto given = table_.number(row, *relative_)) {
        // Some lists count from the weld, some from the feature.
        feature.given_from_weld = std::abs(*given) * mapping_.metres_per_unit;
      }
    }
    if (!run_.welds.empty()) {
      feature.from_weld = chainage - run_.welds.back().chainage;
    }
    add_landmark(feature);
    run_.features.push_back(std::move(feature));
  }

  void add_landmark(const RunFeature& feature) {
    for (const auto& [kind, names] : mapping_.landmarks) {
      const auto is_this = [&](const std::string& name) { return folded(name) == feature.kind; };
      if (std::ranges::any_of(names, is_this)) {
        run_.landmarks.push_back({.kind = kind,
                                  .chainage = feature.chainage,
                                  .standard_deviation = mapping_.landmark_standard_deviation});
        return;
      }
    }
  }

  std::optional<MapPosition> position(std::size_t row) const {
    if (!latitude_ ||
        (table_.cell(row, *latitude_).empty() && table_.cell(row, *longitude_).empty())) {
      return std::nullopt;
    }
    const double height =
        height_ ? table_.required(row, *height_) * mapping_.metres_per_height_unit : 0.0;
    return MapPosition{.coordinates = {required_angle(table_, row, *latitude_, 90.0),
                                       required_angle(table_, row, *longitude_, 180.0), height},
                       .standard_deviation = mapping_.position_standard_deviation};
  }

  const CsvTable table_;
  const ColumnMapping& mapping_;
  const std::size_t distance_;
  const std::size_t kind_;
  const std::optional<std::size_t> clock_;
  const std::optional<std::size_t> relative_;
  const std::optional<std::size_t> latitude_;
  const std::optional<std::size_t> longitude_;
  const std::optional<std::size_t> height_;
  RunFile run_;
  std::size_t last_weld_ = 0;  // row
};

/// The three columns of a survey's frame, from what its header has.
std::pair<MapFrame, std::array<std::size_t, 3>> survey_columns(const CsvTable& table) {
  const std::array<std::pair<MapFrame, std::array<const char*, 3>>, 2> frames{
      {{MapFrame::kGeodetic, {"latitude_deg", "longitude_deg", "height_m"}},
       {MapFrame::kLocal, {"x_m", "y_m", "z_m"}}}};
  for (const auto& [frame, names] : frames) {
    if (!table.find_column(names.front())) {
      continue;
    }
    std::array<std::size_t, 3> columns{};
    for (std::size_t axis = 0; axis < names.size(); ++axis) {
      const auto column = table.find_column(names[axis]);
      if (!column) {
        throw CsvError(table.path(), table.header_line(),
                       "no column '" + std::string(names[axis]) + "'; the file has " +
                           quoted_list(table.columns()));
      }
      columns[axis] = *column;
    }
    return {frame, columns};
  }
  throw CsvError(table.path(), table.header_line(),
                 "a survey has columns latitude_deg, longitude_deg, height_m or x_m, y_m, z_m; the "
                 "file has " +
                     quoted_list(table.columns()));
}

}  // namespace

RunFile read_run(const std::string& path, const ColumnMapping& mapping) {
  return ListReader(path, mapping).read();
}

RunFile read_run(const std::string& path, const CsvFormat& format) {
  const std::string bytes = read_csv_text(path);
  if (const auto mapping = pof_column_mapping(CsvReader(bytes, path, format).columns(), format)) {
    return read_run(path, *mapping);
  }
  RunFile run;
  run.path = path;
  auto [ledger, notes] = read_ledger(path, format);
  run.ledger = std::move(ledger);
  run.notes = std::move(notes);
  for (const odometry::LedgerLandmark& landmark : run.ledger->landmarks) {
    run.landmarks.push_back({.kind = landmark.kind,
                             .chainage = landmark.chainage,
                             .standard_deviation = landmark.standard_deviation});
  }
  run.welds = weld_positions(*run.ledger);
  run.positions.resize(run.welds.size());
  if (run.ledger->frame == MapFrame::kGeodetic) {
    for (std::size_t k = 0; k < run.welds.size(); ++k) {
      run.positions[k] = run.ledger->welds[k].position;
    }
  }
  return run;
}

LedgerFile read_ledger(const std::string& path, const CsvFormat& format) {
  const CsvTable table(read_csv_text(path), path, format);
  try {
    return {ledger_from_csv(table), table.notes()};
  } catch (const CsvError& error) {
    const bool foreign = error.line() == table.header_line();
    throw CsvError(
        path, error.line(),
        error.message() + (foreign ? " (a list with other columns needs --columns)" : ""));
  }
}

SurveyFile read_survey(const std::string& path, const CsvFormat& format) {
  const CsvTable table(read_csv_text(path), path, format);
  const auto [frame, columns] = survey_columns(table);
  const auto sigma = table.find_column("position_sd_m");
  const auto chainage = table.find_column("chainage_m");
  std::vector<odometry::SurveyedPoint> points;
  std::optional<double> last_chainage;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const bool empty = std::all_of(columns.begin(), columns.end(), [&, row](std::size_t column) {
      return table.cell(row, column).empty();
    });
    if (empty) {
      continue;  // a weld beyond the map of its ledger
    }
    odometry::SurveyedPoint point;
    for (std::size_t axis = 0; axis < columns.size(); ++axis) {
      point.position.coordinates[axis] =
          frame == MapFrame::kGeodetic && axis < 2
              ? required_angle(table, row, columns[axis], axis == 0 ? 90.0 : 180.0)
              : table.required(row, columns[axis]);
    }
    if (!points.empty() && !(map_distance(frame, points.back().position.coordinates,
                                          point.position.coordinates) > 0.0)) {
      table.refuse(row, columns.front(), "the point coincides with the previous one");
    }
    point.position.standard_deviation = sigma ? table.required(row, *sigma) : kSurveySigma;
    if (point.position.standard_deviation < 0.0) {
      table.refuse(row, *sigma, table.cell(row, *sigma) + " is below 0");
    }
    point.chainage = chainage ? table.number(row, *chainage) : std::nullopt;
    if (point.chainage && last_chainage && !(*point.chainage > *last_chainage)) {
      table.refuse(
          row, *chainage,
          table.cell(row, *chainage) + " is not above " + format_csv_number(*last_chainage));
    }
    last_chainage = point.chainage ? point.chainage : last_chainage;
    points.push_back(point);
  }
  if (points.size() < 2) {
    throw CsvError(path, 0, "a survey needs at least 2 points");
  }
  return {.line = {frame, std::move(points)}, .notes = table.notes()};
}

}  // namespace pipescout::ledger
