// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometer_readings/readings_csv.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <set>
#include <system_error>
#include <utility>

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

/// Where a row's values stand in the table.
struct Layout {
  std::optional<std::size_t> stamp;
  std::optional<std::size_t> reading;
  std::vector<std::size_t> distance;
  std::vector<std::size_t> standard_deviation;    // empty or as long as `distance`
  std::vector<std::optional<std::size_t>> valid;  // as long as `distance`
};

std::string quoted_list(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) {
    text += (text.empty() ? "'" : ", '") + name + "'";
  }
  return text;
}

/// The odometer that a column says more about, if it does.
std::optional<std::string_view> odometer_of_suffix(std::string_view column) {
  for (const std::string_view suffix : {kStandardDeviation, kValid}) {
    if (column.ends_with(suffix)) {
      return column.substr(0, column.size() - suffix.size());
    }
  }
  return std::nullopt;
}

std::vector<std::string> odometer_columns(const CsvReader& table,
                                          const ReadingsCsvSelection& selection) {
  if (!selection.odometers.empty()) {
    for (const std::string& name : selection.odometers) {
      if (!table.find_column(name)) {
        throw CsvError(table.path(), 1,
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
    if (column != kStamp && column != kReading && !odometer_of_suffix(column) &&
        !contains(selection.ignored_columns, column)) {
      odometers.push_back(column);
    }
  }
  for (const std::string& column : table.columns()) {
    const auto odometer = odometer_of_suffix(column);
    if (odometer && !contains(odometers, *odometer) &&
        !contains(selection.ignored_columns, column)) {
      throw CsvError(table.path(), 1, "column '" + column + "' belongs to no odometer column");
    }
  }
  if (odometers.empty()) {
    throw CsvError(table.path(), 1,
                   "no odometer column; there are " + quoted_list(table.columns()));
  }
  return odometers;
}

Layout layout_of(const CsvReader& table, const std::vector<std::string>& odometers) {
  Layout layout;
  layout.stamp = table.find_column(kStamp);
  layout.reading = table.find_column(kReading);
  for (const std::string& name : odometers) {
    layout.distance.push_back(*table.find_column(name));
    layout.valid.push_back(table.find_column(name + std::string(kValid)));
    if (const auto column = table.find_column(name + std::string(kStandardDeviation))) {
      layout.standard_deviation.push_back(*column);
    }
  }
  if (!layout.standard_deviation.empty() && layout.standard_deviation.size() != odometers.size()) {
    throw CsvError(table.path(), 1,
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
    const std::size_t rows = file_.maximum_rows_left();
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
        recording.distances.push_back(number(layout_.distance[i]));
        recording.valid.push_back(layout_.valid[i] ? flag(*layout_.valid[i]) : true);
      }
      for (const std::size_t column : layout_.standard_deviation) {
        recording.standard_deviations.push_back(number(column));
      }
    }
  }

 private:
  double number(std::size_t column) const {
    const auto value = parse_csv_number(file_.cells()[column]);
    if (!value) {
      file_.refuse(column, "a number");
    }
    return *value;
  }

  bool flag(std::size_t column) const {
    const std::string_view cell = file_.cells()[column];
    if (cell != "0" && cell != "1") {
      file_.refuse(column, "0 or 1");
    }
    return cell == "1";
  }

  nanoseconds next_stamp(std::size_t column) {
    const auto stamp = parse_stamp(file_.cells()[column]);
    if (!stamp) {
      file_.refuse(column, "a time in seconds from 0 to 2^31");
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

ReadingsRecording parse_readings_csv(std::string_view text, std::string_view path,
                                     const ReadingsCsvSelection& selection) {
  CsvReader file(text, path);
  ReadingsRecording recording;
  recording.odometers = odometer_columns(file, selection);
  RowReader(file, layout_of(file, recording.odometers)).read_into(recording);
  return recording;
}

std::vector<std::string> odometer_column_names(const std::vector<std::string>& names) {
  std::vector<std::string> columns;
  for (const std::string& name : names) {
    std::string column = name;
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
    if (odometer_of_suffix(column)) {
      column[column.rfind('.')] = '_';
    }
    // A byte order mark would be taken for the file's.
    if (column.empty() || column == kStamp || column == kReading || column.front() == '\xEF' ||
        contains(columns, column)) {
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
