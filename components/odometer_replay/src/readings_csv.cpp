// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometer_replay/readings_csv.hpp"

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
/// builtin_interfaces/msg/Time holds seconds as int32.
constexpr std::int64_t kStampLimitSeconds = std::int64_t{1} << 31U;
constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
constexpr std::size_t kStampDecimals = 9;

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

std::vector<std::string> odometer_columns(const CsvTable& table,
                                          const ReadingsCsvSelection& selection) {
  if (!selection.odometers.empty()) {
    for (const std::string& name : selection.odometers) {
      if (!table.find_column(name)) {
        throw CsvError(table.path, 1,
                       "no column '" + name + "'; there are " + quoted_list(table.columns));
      }
    }
    if (std::set<std::string>(selection.odometers.begin(), selection.odometers.end()).size() !=
        selection.odometers.size()) {
      throw CsvError(table.path, 0,
                     "an odometer is selected twice: " + quoted_list(selection.odometers));
    }
    return selection.odometers;
  }
  std::vector<std::string> odometers;
  for (const std::string& column : table.columns) {
    if (column != kStamp && column != kReading && !odometer_of_suffix(column) &&
        !contains(selection.ignored_columns, column)) {
      odometers.push_back(column);
    }
  }
  for (const std::string& column : table.columns) {
    const auto odometer = odometer_of_suffix(column);
    if (odometer && !contains(odometers, *odometer) &&
        !contains(selection.ignored_columns, column)) {
      throw CsvError(table.path, 1, "column '" + column + "' belongs to no odometer column");
    }
  }
  if (odometers.empty()) {
    throw CsvError(table.path, 1, "no odometer column; there are " + quoted_list(table.columns));
  }
  return odometers;
}

Layout layout_of(const CsvTable& table, const std::vector<std::string>& odometers) {
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
    throw CsvError(table.path, 1,
                   "columns '*" + std::string(kStandardDeviation) +
                       "' are there for some odometers but not for all");
  }
  return layout;
}

class RowReader {
 public:
  RowReader(const CsvTable& table, const Layout& layout) : table_(table), layout_(layout) {}

  ReadingsRow read(const CsvTable::Row& row) {
    ReadingsRow result;
    if (layout_.stamp) {
      result.stamp = next_stamp(row, *layout_.stamp);
    }
    if (layout_.reading) {
      check_reading(row, *layout_.reading);
    }
    for (std::size_t i = 0; i < layout_.distance.size(); ++i) {
      result.distance.push_back(number(row, layout_.distance[i]));
      result.valid.push_back(layout_.valid[i] ? flag(row, *layout_.valid[i]) : true);
    }
    for (const std::size_t column : layout_.standard_deviation) {
      result.standard_deviation.push_back(number(row, column));
    }
    return result;
  }

 private:
  [[noreturn]] void refuse(const CsvTable::Row& row, std::size_t column,
                           const std::string& expected) const {
    throw CsvError(
        table_.path, row.line,
        "column '" + table_.columns[column] + "': '" + row.cells[column] + "' is not " + expected);
  }

  double number(const CsvTable::Row& row, std::size_t column) const {
    const auto value = parse_csv_number(row.cells[column]);
    if (!value) {
      refuse(row, column, "a number");
    }
    return *value;
  }

  bool flag(const CsvTable::Row& row, std::size_t column) const {
    const std::string& cell = row.cells[column];
    if (cell != "0" && cell != "1") {
      refuse(row, column, "0 or 1");
    }
    return cell == "1";
  }

  nanoseconds next_stamp(const CsvTable::Row& row, std::size_t column) {
    const auto stamp = parse_stamp(row.cells[column]);
    if (!stamp) {
      refuse(row, column, "a time in seconds from 0 to 2^31");
    }
    if (last_stamp_ && *stamp <= *last_stamp_) {
      refuse(row, column, "later than the stamp before, " + format_stamp(*last_stamp_));
    }
    last_stamp_ = stamp;
    return *stamp;
  }

  void check_reading(const CsvTable::Row& row, std::size_t column) {
    const std::string& cell = row.cells[column];
    std::int64_t value = 0;
    const char* const end = cell.data() + cell.size();
    const auto [stop, error] = std::from_chars(cell.data(), end, value);
    if (error != std::errc{} || stop != end) {
      refuse(row, column, "a whole number");
    }
    if (last_reading_ && value <= *last_reading_) {
      refuse(row, column, "above the number before, " + std::to_string(*last_reading_));
    }
    last_reading_ = value;
  }

  const CsvTable& table_;
  const Layout& layout_;
  std::optional<nanoseconds> last_stamp_;
  std::optional<std::int64_t> last_reading_;
};

}  // namespace

ReadingsRecording parse_readings_csv(std::string_view text, std::string_view path,
                                     const ReadingsCsvSelection& selection) {
  const CsvTable table = parse_csv(text, path);
  ReadingsRecording recording;
  recording.odometers = odometer_columns(table, selection);
  const Layout layout = layout_of(table, recording.odometers);
  recording.has_stamps = layout.stamp.has_value();
  recording.has_standard_deviations = !layout.standard_deviation.empty();
  recording.rows.reserve(table.rows.size());
  RowReader reader(table, layout);
  for (const CsvTable::Row& row : table.rows) {
    recording.rows.push_back(reader.read(row));
  }
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

std::string format_stamp(nanoseconds stamp) {
  const std::string decimals = std::to_string(std::abs(stamp.count() % kNanosecondsPerSecond));
  return (stamp.count() < 0 ? "-" : "") +
         std::to_string(std::abs(stamp.count() / kNanosecondsPerSecond)) + "." +
         std::string(kStampDecimals - decimals.size(), '0') + decimals;
}

std::optional<nanoseconds> parse_stamp(std::string_view cell) {
  const std::size_t point = cell.find('.');
  std::string digits(cell.substr(0, point));
  std::string decimals(point == std::string_view::npos ? "" : cell.substr(point + 1));
  const auto is_digit = [](char character) { return character >= '0' && character <= '9'; };
  const bool exact = !digits.empty() && digits.size() <= 10 && decimals.size() <= kStampDecimals &&
                     std::all_of(digits.begin(), digits.end(), is_digit) &&
                     std::all_of(decimals.begin(), decimals.end(), is_digit);
  if (exact) {
    decimals.resize(kStampDecimals, '0');
    const std::int64_t seconds = std::stoll(digits);
    if (seconds >= kStampLimitSeconds) {
      return std::nullopt;
    }
    return nanoseconds(seconds * kNanosecondsPerSecond + std::stoll(decimals));
  }
  const auto seconds = parse_csv_number(cell);
  if (!seconds || !(*seconds >= 0.0) || !(*seconds < static_cast<double>(kStampLimitSeconds))) {
    return std::nullopt;
  }
  return nanoseconds(std::llround(*seconds * 1e9));
}

}  // namespace pipescout
