// SPDX-License-Identifier: Apache-2.0
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "known_keys.hpp"
#include "pipescout/csv/csv_file.hpp"
#include "pipescout/csv/csv_rows.hpp"
#include "pipescout/csv/csv_table.hpp"
#include "pipescout/files/yaml_location.hpp"
#include "recording.hpp"

namespace pipescout::estimate {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::string trimmed(const std::string& cell) {
  const auto begin = cell.find_first_not_of(" \t\r");
  return begin == std::string::npos
             ? std::string()
             : cell.substr(begin, cell.find_last_not_of(" \t\r") - begin + 1);
}

std::vector<CsvRow> blank_separated(const std::string& text) {
  std::vector<CsvRow> rows;
  std::istringstream lines(text);
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    CsvRow row{.line = ++number, .cells = {}};
    std::istringstream cells(line);
    for (std::string cell; cells >> cell;) {
      row.cells.push_back(cell);
    }
    if (!row.cells.empty()) {
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

/// One file of the mapping: rows of cells, columns by name or by number from 1.
class Table {
 public:
  Table(const std::filesystem::path& file, const YAML::Node& source, std::string mapping)
      : mapping_(std::move(mapping)) {
    const std::string delimiter = source["delimiter"] ? source["delimiter"].Scalar() : ",";
    const std::string text = read_csv_text(file.string());
    if (delimiter == "blank") {
      rows_ = blank_separated(text);
    } else if (delimiter.size() == 1) {
      rows_ = read_csv_rows(text, delimiter[0]).rows;
    } else {
      throw YamlError(mapping_, source["delimiter"].Mark(), "delimiter: one character, or 'blank'");
    }
    std::erase_if(rows_, [](const CsvRow& row) {
      return row.cells.empty() || trimmed(row.cells[0]).starts_with('#');
    });
    const bool header = !source["header"] || source["header"].Scalar() != "false";
    if (header && !rows_.empty()) {
      for (const std::string& cell : rows_.front().cells) {
        names_.push_back(trimmed(cell));
      }
      rows_.erase(rows_.begin());
    }
    if (source["rows"]) {
      const std::string mark = source["rows"].Scalar();
      std::erase_if(rows_, [&](const CsvRow& row) { return trimmed(row.cells[0]) != mark; });
    }
    if (rows_.empty()) {
      throw std::runtime_error(file.string() + ": no rows");
    }
  }

  [[nodiscard]] const std::vector<CsvRow>& rows() const noexcept { return rows_; }

  [[nodiscard]] std::size_t column(const YAML::Node& name) const {
    if (!name.IsScalar()) {
      throw YamlError(mapping_, name.Mark(), "the name or number of a column is expected");
    }
    const auto found = std::ranges::find(names_, name.Scalar());
    if (found != names_.end()) {
      return static_cast<std::size_t>(found - names_.begin());
    }
    const auto number = parse_csv_number(name.Scalar());
    if (number && *number >= 1 && *number <= 1024 && *number == std::floor(*number)) {
      return static_cast<std::size_t>(*number) - 1;
    }
    std::string known;
    for (const std::string& each : names_) {
      known += (known.empty() ? "; the file has " : ", ") + each;
    }
    throw YamlError(mapping_, name.Mark(), "no column '" + name.Scalar() + "'" + known);
  }

  /// NaN for what is no number, so that the row is counted as such.
  [[nodiscard]] static double number(const CsvRow& row, std::size_t column) {
    return column < row.cells.size() ? parse_csv_number(trimmed(row.cells[column])).value_or(kNan)
                                     : kNan;
  }

 private:
  std::string mapping_;
  std::vector<CsvRow> rows_;
  std::vector<std::string> names_;
};

/// The columns of one source.
class Columns {
 public:
  Columns(const Table& table, const YAML::Node& node, std::string mapping)
      : table_(table), node_(node), mapping_(std::move(mapping)) {}

  [[nodiscard]] bool has(const char* key) const { return node_[key].IsDefined(); }
  [[nodiscard]] std::vector<std::size_t> all(const char* key, std::size_t count) const {
    const YAML::Node value = node_[key];
    if (!value.IsDefined()) {
      throw YamlError(mapping_, node_.Mark(), std::string("columns: '") + key + "' is missing");
    }
    std::vector<std::size_t> result;
    if (value.IsSequence()) {
      for (const YAML::Node& each : value) {
        result.push_back(table_.column(each));
      }
    } else {
      result.push_back(table_.column(value));
    }
    if (count > 0 && result.size() != count) {
      throw YamlError(mapping_, value.Mark(),
                      std::string(key) + ": " + std::to_string(count) + " columns are expected");
    }
    return result;
  }
  [[nodiscard]] std::size_t one(const char* key) const { return all(key, 1)[0]; }

 private:
  const Table& table_;
  YAML::Node node_;
  std::string mapping_;
};

Eigen::Vector3d vector(const CsvRow& row, const std::vector<std::size_t>& columns) {
  return {Table::number(row, columns[0]), Table::number(row, columns[1]),
          Table::number(row, columns[2])};
}

/// Readings of a gyro in a file of its own, between the two nearest.
class Rates {
 public:
  Rates(const Table& table, const Columns& columns) {
    const std::size_t time = columns.one("time");
    const auto rate = columns.all("rate", 3);
    for (const CsvRow& row : table.rows()) {
      if (const double t = Table::number(row, time); std::isfinite(t)) {
        rows_.emplace_back(t, vector(row, rate));
      }
    }
    std::ranges::stable_sort(rows_, {}, &std::pair<double, Eigen::Vector3d>::first);
  }
  [[nodiscard]] Eigen::Vector3d at(double time) const {
    const auto after =
        std::ranges::lower_bound(rows_, time, {}, &std::pair<double, Eigen::Vector3d>::first);
    if (after == rows_.begin() || after == rows_.end()) {
      return Eigen::Vector3d::Constant(kNan);
    }
    const auto& before = *std::prev(after);
    const double share = (time - before.first) / (after->first - before.first);
    return (1 - share) * before.second + share * after->second;
  }

 private:
  std::vector<std::pair<double, Eigen::Vector3d>> rows_;
};

void read_imu(const Table& table, const Columns& columns, const Rates* rates, Stream& stream) {
  const std::size_t time = columns.one("time");
  const auto force = columns.all("force", 3);
  const auto rate = rates == nullptr ? columns.all("rate", 3) : std::vector<std::size_t>{};
  for (const CsvRow& row : table.rows()) {
    const double t = Table::number(row, time);
    add_imu(stream, {.time = t,
                     .force = vector(row, force),
                     .rate = rates == nullptr ? vector(row, rate) : rates->at(t)});
  }
}

/// Speed (the mean of several wheels) and yaw rate; or distance and turn since the row before.
void read_odometer(const Table& table, const Columns& columns, Stream& stream) {
  const std::size_t time = columns.one("time");
  const bool steps = columns.has("distance");
  const auto way = columns.all(steps ? "distance" : "speed", steps ? 1 : 0);
  const char* turn_key = steps ? "turn" : "yaw_rate";
  const bool turns = columns.has(turn_key);
  const std::size_t turn = turns ? columns.one(turn_key) : 0;
  double before = kNan;
  for (const CsvRow& row : table.rows()) {
    OdometerRow result{.time = Table::number(row, time)};
    for (const std::size_t column : way) {
      result.speed += Table::number(row, column) / static_cast<double>(way.size());
    }
    if (turns) {
      result.yaw_rate = Table::number(row, turn);
    }
    if (steps) {
      // The mean over the step holds in its middle.
      const double step = result.time - before;
      const double middle = result.time - step / 2;
      before = result.time;
      if (!(step > 0)) {
        continue;
      }
      result.time = middle;
      result.speed /= step;
      if (result.yaw_rate) {
        *result.yaw_rate /= step;
      }
    }
    add_odometer(stream, result);
  }
}

void read_gps(const Table& table, const Columns& columns, Stream& stream) {
  const std::size_t time = columns.one("time");
  const std::size_t latitude = columns.one("latitude");
  const std::size_t longitude = columns.one("longitude");
  const bool has_height = columns.has("height");
  const std::size_t height = has_height ? columns.one("height") : 0;
  const bool has_variance = columns.has("variance");
  const auto variance = has_variance ? columns.all("variance", 3) : std::vector<std::size_t>{};
  const bool has_status = columns.has("status");
  const std::size_t status = has_status ? columns.one("status") : 0;
  for (const CsvRow& row : table.rows()) {
    if (has_status && Table::number(row, status) < 0) {
      ++stream.faults["status is 'no fix'; not used"];
      continue;
    }
    GpsRow fix{.time = Table::number(row, time),
               .place = {Table::number(row, latitude), Table::number(row, longitude),
                         has_height ? Table::number(row, height) : kNan}};
    if (has_variance) {
      fix.covariance = vector(row, variance).asDiagonal().toDenseMatrix();
    }
    add_gps(stream, std::move(fix));
  }
}

std::string text_of(const YAML::Node& source, const char* key, const std::string& mapping) {
  const YAML::Node node = source[key];
  if (!node.IsDefined() || !node.IsScalar() || node.Scalar().empty()) {
    throw YamlError(mapping, source.Mark(), std::string("sources: '") + key + "' is missing");
  }
  return node.Scalar();
}

Stream read_source(const YAML::Node& source, const std::filesystem::path& folder,
                   const std::string& mapping) {
  require_known_keys(source,
                     {"name", "kind", "file", "delimiter", "header", "rows", "columns", "rate_file",
                      "rate_columns"},
                     mapping);
  Stream stream;
  stream.name = text_of(source, "name", mapping);
  stream.type = text_of(source, "file", mapping);
  const std::string kind = text_of(source, "kind", mapping);
  const YAML::Node columns_node = source["columns"];
  if (!columns_node.IsDefined()) {
    throw YamlError(mapping, source.Mark(), "sources: 'columns' is missing");
  }
  const Table table(folder / stream.type, source, mapping);
  const Columns columns(table, columns_node, mapping);
  if (kind == "imu") {
    require_known_keys(columns_node, {"time", "force", "rate"}, mapping);
    stream.kind = Kind::kImu;
    if (source["rate_file"]) {
      const Table of_rates(folder / text_of(source, "rate_file", mapping), source, mapping);
      const YAML::Node names = source["rate_columns"];
      if (!names.IsDefined()) {
        throw YamlError(mapping, source.Mark(), "sources: 'rate_columns' is missing");
      }
      require_known_keys(names, {"time", "rate"}, mapping);
      const Rates rates(of_rates, Columns(of_rates, names, mapping));
      read_imu(table, columns, &rates, stream);
    } else {
      read_imu(table, columns, nullptr, stream);
    }
  } else if (kind == "odometer") {
    require_known_keys(columns_node, {"time", "speed", "yaw_rate", "distance", "turn"}, mapping);
    stream.kind = Kind::kOdometer;
    read_odometer(table, columns, stream);
  } else if (kind == "gps") {
    require_known_keys(columns_node,
                       {"time", "latitude", "longitude", "height", "variance", "status"}, mapping);
    stream.kind = Kind::kGps;
    read_gps(table, columns, stream);
  } else {
    throw YamlError(mapping, source["kind"].Mark(), "kind: imu, odometer or gps");
  }
  return stream;
}

}  // namespace

Recording read_csv_folder(const std::filesystem::path& folder, const std::string& mapping) {
  const YAML::Node root = load_yaml(mapping);
  const YAML::Node sources = root["sources"];
  if (!sources.IsDefined() || !sources.IsSequence()) {
    throw YamlError(mapping, root.Mark(), "sources: a list is expected");
  }
  Recording recording;
  for (const YAML::Node& source : sources) {
    recording.streams.push_back(read_source(source, folder, mapping));
  }
  finish(recording);
  return recording;
}

}  // namespace pipescout::estimate
