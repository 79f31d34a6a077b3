// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometer_readings/readings_csv.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <set>
#include <system_error>
#include <utility>

#include "pipescout/csv/csv_words.hpp"
#include "pipescout/csv/utf8.hpp"

namespace pipescout {

namespace {

using std::chrono::nanoseconds;

constexpr std::string_view kStamp = "stamp";
constexpr std::string_view kReading = "reading";
constexpr std::string_view kStandardDeviation = ".standard_deviation";
constexpr std::string_view kValid = ".valid";

bool contains(const std::vector<std::string>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

struct LengthColumn {
  std::size_t index = 0;
  double metres = 1.0;  // in its unit
};

/// Where a row's values stand in the table.
struct Layout {
  std::optional<std::size_t> stamp;
  std::optional<std::size_t> reading;
  std::vector<LengthColumn> distance;
  std::vector<LengthColumn> standard_deviation;   // empty or as long as `distance`
  std::vector<std::optional<std::size_t>> valid;  // as long as `distance`
};

/// The odometer that a column says more about, if it does.
std::optional<std::string_view> odometer_of_suffix(std::string_view column) {
  for (const std::string_view suffix : {kStandardDeviation, kValid}) {
    if (column.ends_with(suffix)) {
      return column.substr(0, column.size() - suffix.size());
    }
  }
  return std::nullopt;
}

/// Each column is an odometer or more about one: none may be left out for its name. Empty columns
/// without one, which spreadsheets leave behind, are not meant.
void check_names(const CsvReader& table) {
  std::set<std::string_view> names;
  for (std::size_t column = 0; column < table.columns().size(); ++column) {
    const std::string& name = table.columns()[column];
    if (name.empty()) {
      if (!table.numbers()->is_empty(column)) {
        throw CsvError(table.path(), table.header_line(),
                       "column " + std::to_string(column + 1) + " has no name");
      }
    } else if (!names.insert(name).second) {
      throw CsvError(table.path(), table.header_line(), "two columns are named '" + name + "'");
    }
  }
}

std::vector<std::string> odometer_columns(const CsvReader& table,
                                          const ReadingsCsvSelection& selection) {
  check_names(table);
  if (!selection.odometers.empty()) {
    for (const std::string& name : selection.odometers) {
      if (!table.find_column(name)) {
        throw CsvError(table.path(), table.header_line(),
                       "no column '" + name + "'; there are " + quoted_list(table.columns()));
      }
    }
    if (std::set<std::string>(selection.odometers.begin(), selection.odometers.end()).size() !=
        selection.odometers.size()) {
      throw CsvError(table.path(), 0,
                     "an odometer is selected twice: " + quoted_list(selection.odometers));
    }
    return selection.odometers;
  }
  std::vector<std::string> odometers;
  for (const std::string& column : table.columns()) {
    if (!column.empty() && column != kStamp && column != kReading && !odometer_of_suffix(column) &&
        !contains(selection.ignored_columns, column)) {
      odometers.push_back(column);
    }
  }
  for (const std::string& column : table.columns()) {
    const auto odometer = odometer_of_suffix(column);
    if (odometer && !contains(odometers, *odometer) &&
        !contains(selection.ignored_columns, column)) {
      throw CsvError(table.path(), table.header_line(),
                     "column '" + column + "' belongs to no odometer column");
    }
  }
  if (odometers.empty()) {
    throw CsvError(table.path(), table.header_line(),
                   "no odometer column; there are " + quoted_list(table.columns()));
  }
  return odometers;
}

/// "left" of "left [mm]": distances become those in m.
std::string without_unit(const std::string& name) {
  const std::string unit = bracketed(name);
  return metres_per_list_unit(unit) && (name.ends_with(']') || name.ends_with(')'))
             ? folded(name.substr(0, name.size() - unit.size() - 2))
             : name;
}

/// In the unit that the file says; `otherwise` where it says none.
LengthColumn length_column(const CsvReader& table, std::size_t index, double otherwise,
                           std::vector<std::string>& notes) {
  const std::string unit = table.numbers()->unit(index);
  const auto metres = metres_per_list_unit(unit);
  if (!metres && is_unit_word(unit) && unit != "-") {
    throw CsvError(table.path(), table.header_line(),
                   "column '" + table.columns()[index] + "' is in '" + unit +
                       "', which is no length: " + list_unit_names());
  }
  if (metres && *metres != 1.0) {
    notes.push_back(table.path() + ": column '" + table.columns()[index] + "' is in " + unit +
                    ", converted to m");
  }
  return {.index = index, .metres = metres.value_or(otherwise)};
}

Layout layout_of(const CsvReader& table, const std::vector<std::string>& odometers,
                 std::vector<std::string>& notes) {
  Layout layout;
  layout.stamp = table.find_column(kStamp);
  layout.reading = table.find_column(kReading);
  for (const std::string& name : odometers) {
    layout.distance.push_back(length_column(table, *table.find_column(name), 1.0, notes));
    layout.valid.push_back(table.find_column(name + std::string(kValid)));
    if (const auto column = table.find_column(name + std::string(kStandardDeviation))) {
      layout.standard_deviation.push_back(
          length_column(table, *column, layout.distance.back().metres, notes));
    }
  }
  if (!layout.standard_deviation.empty() && layout.standard_deviation.size() != odometers.size()) {
    throw CsvError(table.path(), table.header_line(),
                   "columns '*" + std::string(kStandardDeviation) +
                       "' are there for some odometers but not for all");
  }
  return layout;
}

/// Appends the rows of a file to a recording.
class RowReader {
 public:
  RowReader(CsvReader& file, Layout layout) : file_(file), layout_(std::move(layout)) {}

  void read_into(ReadingsRecording& recording) {
    const std::size_t rows = file_.rows();
    recording.stamps.reserve(layout_.stamp ? rows : 0);
    recording.distances.reserve(rows * layout_.distance.size());
    recording.standard_deviations.reserve(rows * layout_.standard_deviation.size());
    recording.valid.reserve(rows * layout_.valid.size());
    while (file_.next()) {
      if (layout_.stamp) {
        recording.stamps.push_back(next_stamp(*layout_.stamp));
      }
      if (layout_.reading) {
        check_reading(*layout_.reading);
      }
      for (std::size_t i = 0; i < layout_.distance.size(); ++i) {
        recording.distances.push_back(length(layout_.distance[i]));
        recording.valid.push_back(layout_.valid[i] ? flag(*layout_.valid[i]) : true);
      }
      for (const LengthColumn& column : layout_.standard_deviation) {
        recording.standard_deviations.push_back(length(column));
      }
    }
  }

 private:
  double length(const LengthColumn& column) const {
    const auto value = file_.number(column.index);
    if (!value) {
      file_.refuse(column.index, "a number");
    }
    return *value * column.metres;
  }

  bool flag(std::size_t column) const {
    const std::string_view cell = file_.cells()[column];
    if (cell != "0" && cell != "1") {
      file_.refuse(column, "0 or 1");
    }
    return cell == "1";
  }

  nanoseconds next_stamp(std::size_t column) {
    const auto stamp = file_.time(column);
    if (!stamp || *stamp < nanoseconds::zero()) {
      file_.refuse(column,
                   "a time in seconds from 0 to 2^31 or one such as 2026-11-29T07:36:05.25Z");
    }
    if (last_stamp_ && *stamp <= *last_stamp_) {
      file_.refuse(column, "later than the previous stamp, " + format_stamp(*last_stamp_));
    }
    last_stamp_ = stamp;
    return *stamp;
  }

  void check_reading(std::size_t column) {
    const std::string_view cell = file_.cells()[column];
    std::int64_t value = 0;
    const char* const end = cell.data() + cell.size();
    const auto [stop, error] = std::from_chars(cell.data(), end, value);
    if (error != std::errc{} || stop != end) {
      file_.refuse(column, "a whole number");
    }
    if (last_reading_ && value <= *last_reading_) {
      file_.refuse(column, "above the previous number, " + std::to_string(*last_reading_));
    }
    last_reading_ = value;
  }

  CsvReader& file_;
  const Layout layout_;
  std::optional<nanoseconds> last_stamp_;
  std::optional<std::int64_t> last_reading_;
};

}  // namespace

ReadingsRow ReadingsRecording::row(std::size_t index) const {
  const std::size_t count = odometers.size();
  const auto first = static_cast<std::ptrdiff_t>(index * count);
  const auto last = first + static_cast<std::ptrdiff_t>(count);
  ReadingsRow result;
  if (!stamps.empty()) {
    result.stamp = stamps[index];
  }
  result.distance.assign(distances.begin() + first, distances.begin() + last);
  if (!standard_deviations.empty()) {
    result.standard_deviation.assign(standard_deviations.begin() + first,
                                     standard_deviations.begin() + last);
  }
  result.valid.assign(valid.begin() + first, valid.begin() + last);
  return result;
}

ReadingsRecording parse_readings_csv(std::string_view bytes, std::string_view path,
                                     const ReadingsCsvSelection& selection) {
  CsvReader file(bytes, path, selection.format);
  ReadingsRecording recording;
  recording.notes = file.notes();
  recording.odometers = odometer_columns(file, selection);
  const Layout layout = layout_of(file, recording.odometers, recording.notes);
  if (layout.stamp) {
    if (const std::string note = file.numbers()->time_note(*layout.stamp); !note.empty()) {
      recording.notes.push_back(note);
    }
  }
  RowReader(file, layout).read_into(recording);
  for (std::string& odometer : recording.odometers) {
    odometer = without_unit(odometer);
  }
  if (std::set<std::string>(recording.odometers.begin(), recording.odometers.end()).size() !=
      recording.odometers.size()) {
    throw CsvError(
        file.path(), file.header_line(),
        "two columns have one name without its unit: " + quoted_list(recording.odometers));
  }
  return recording;
}

std::vector<std::string> odometer_column_names(const std::vector<std::string>& names) {
  std::vector<std::string> columns;
  for (const std::string& name : names) {
    std::string column = name;
    for (std::size_t bad = first_byte_not_utf8(column); bad != std::string::npos;
         bad = first_byte_not_utf8(column)) {
      column[bad] = '_';
    }
    for (char& character : column) {
      const auto code = static_cast<unsigned char>(character);
      if (code < 0x20 || code == 0x7F || character == ',' || character == '"') {
        character = '_';
      }
    }
    if (!column.empty()) {
      for (char* const end : {&column.front(), &column.back()}) {
        *end = *end == ' ' ? '_' : *end;
      }
    }
    column = folded(column);
    if (is_unit_word(bracketed(column))) {
      // Distances are written in m, whatever the name says.
      std::ranges::replace_if(
          column, [](char c) { return std::string_view("[]()").find(c) != std::string::npos; },
          '_');
    }
    if (odometer_of_suffix(column)) {
      column[column.rfind('.')] = '_';
    }
    if (column.empty() || column == kStamp || column == kReading || contains(columns, column)) {
      const std::string fallback = "odometer_" + std::to_string(columns.size() + 1);
      column = fallback;
      while (contains(columns, column)) {
        column += '_';
      }
    }
    columns.push_back(std::move(column));
  }
  return columns;
}

std::string format_readings_header(const std::vector<std::string>& columns,
                                   bool with_standard_deviations) {
  std::string header = std::string(kReading) + "," + std::string(kStamp);
  for (const std::string& column : columns) {
    header += "," + column;
  }
  if (with_standard_deviations) {
    for (const std::string& column : columns) {
      header += "," + column + std::string(kStandardDeviation);
    }
  }
  for (const std::string& column : columns) {
    header += "," + column + std::string(kValid);
  }
  return header;
}

std::string format_readings_row(std::uint64_t reading, const ReadingsRow& row) {
  std::string line = std::to_string(reading) + "," + format_stamp(row.stamp);
  for (const double value : row.distance) {
    line += "," + format_csv_number(value);
  }
  for (const double value : row.standard_deviation) {
    line += "," + format_csv_number(value);
  }
  for (const bool valid : row.valid) {
    line += valid ? ",1" : ",0";
  }
  return line;
}

}  // namespace pipescout
