// SPDX-License-Identifier: Apache-2.0
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "csv_messages.hpp"
#include "csv_source.hpp"
#include "pipescout/command_line/known_keys.hpp"
#include "pipescout/files/yaml_location.hpp"
#include "recording.hpp"

namespace pipescout::estimate {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Readings of a gyro in a file of its own, between the two nearest.
class Rates {
 public:
  Rates(const CsvSource& table, const CsvColumns& columns) {
    const std::size_t time = columns.one("time");
    const auto rate = columns.all("rate", 3);
    for (const std::size_t row : table.rows()) {
      if (const double t = columns.time(row, time); std::isfinite(t)) {
        rows_.emplace_back(t, columns.vector(row, rate));
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

void read_imu(const CsvSource& table, const CsvColumns& columns, const Rates* rates,
              Stream& stream) {
  const std::size_t time = columns.one("time");
  const auto force = columns.all("force", 3);
  const auto rate = rates == nullptr ? columns.all("rate", 3) : std::vector<std::size_t>{};
  for (const std::size_t row : table.rows()) {
    const double t = columns.time(row, time);
    add_imu(stream, {.time = t,
                     .force = columns.vector(row, force),
                     .rate = rates == nullptr ? columns.vector(row, rate) : rates->at(t)});
  }
}

/// Speed (the mean of several wheels) and yaw rate; or distance and turn since the row before.
void read_odometer(const CsvSource& table, const CsvColumns& columns, Stream& stream) {
  const std::size_t time = columns.one("time");
  const bool steps = columns.has("distance");
  const auto way = columns.all(steps ? "distance" : "speed", steps ? 1 : 0);
  const char* turn_key = steps ? "turn" : "yaw_rate";
  const bool turns = columns.has(turn_key);
  const std::size_t turn = turns ? columns.one(turn_key) : 0;
  double before = kNan;
  for (const std::size_t row : table.rows()) {
    OdometerRow result{.time = columns.time(row, time)};
    for (const std::size_t column : way) {
      result.speed += columns.number(row, column) / static_cast<double>(way.size());
    }
    if (turns) {
      result.yaw_rate = columns.number(row, turn);
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

void read_gps(const CsvSource& table, const CsvColumns& columns, Stream& stream) {
  const std::size_t time = columns.one("time");
  const std::size_t latitude = columns.one("latitude");
  const std::size_t longitude = columns.one("longitude");
  const bool has_height = columns.has("height");
  const std::size_t height = has_height ? columns.one("height") : 0;
  const bool has_variance = columns.has("variance");
  const auto variance = has_variance ? columns.all("variance", 3) : std::vector<std::size_t>{};
  const bool has_status = columns.has("status");
  const std::size_t status = has_status ? columns.one("status") : 0;
  for (const std::size_t row : table.rows()) {
    if (has_status && columns.number(row, status) < 0) {
      ++stream.faults["status is 'no fix'; not used"];
      continue;
    }
    GpsRow fix{.time = columns.time(row, time),
               .place = {columns.number(row, latitude), columns.number(row, longitude),
                         has_height ? columns.number(row, height) : kNan}};
    if (has_variance) {
      fix.covariance = columns.vector(row, variance).asDiagonal().toDenseMatrix();
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

/// How a file was read, where that is a guess.
void add_notes(const CsvSource& source, const CsvColumns& columns,
               std::vector<std::string>& remarks) {
  std::vector<std::string> notes = source.table().notes();
  notes.push_back(source.table().numbers().time_note(columns.one("time")));
  for (const std::string& note : notes) {
    if (!note.empty() && std::ranges::find(remarks, note) == remarks.end()) {
      remarks.push_back(note);
    }
  }
}

Stream read_source(const YAML::Node& source, const std::filesystem::path& folder,
                   const std::string& mapping, std::vector<std::string>& remarks) {
  command_line::require_known_keys(
      source, mapping, "an entry of 'sources'",
      {"name", "kind", "file", "delimiter", "decimal_mark", "time_unit", "header", "rows",
       "columns", "rate_file", "rate_columns"});
  Stream stream;
  stream.name = text_of(source, "name", mapping);
  stream.type = text_of(source, "file", mapping);
  const std::string kind = text_of(source, "kind", mapping);
  const YAML::Node columns_node = source["columns"];
  if (!columns_node.IsDefined()) {
    throw YamlError(mapping, source.Mark(), "sources: 'columns' is missing");
  }
  const CsvSource table(folder / stream.type, source, mapping);
  const CsvColumns columns(table, columns_node, mapping);
  add_notes(table, columns, remarks);
  if (kind == "imu") {
    command_line::require_known_keys(columns_node, mapping, "'columns'", {"time", "force", "rate"});
    stream.kind = Kind::kImu;
    if (source["rate_file"]) {
      const CsvSource of_rates(folder / text_of(source, "rate_file", mapping), source, mapping);
      const YAML::Node names = source["rate_columns"];
      if (!names.IsDefined()) {
        throw YamlError(mapping, source.Mark(), "sources: 'rate_columns' is missing");
      }
      command_line::require_known_keys(names, mapping, "'rate_columns'", {"time", "rate"});
      const CsvColumns rate_columns(of_rates, names, mapping);
      add_notes(of_rates, rate_columns, remarks);
      const Rates rates(of_rates, rate_columns);
      read_imu(table, columns, &rates, stream);
    } else {
      read_imu(table, columns, nullptr, stream);
    }
  } else if (kind == "odometer") {
    command_line::require_known_keys(columns_node, mapping, "'columns'",
                                     {"time", "speed", "yaw_rate", "distance", "turn"});
    stream.kind = Kind::kOdometer;
    read_odometer(table, columns, stream);
  } else if (kind == "gps") {
    command_line::require_known_keys(
        columns_node, mapping, "'columns'",
        {"time", "latitude", "longitude", "height", "variance", "status"});
    stream.kind = Kind::kGps;
    read_gps(table, columns, stream);
  } else if (const auto further = named_source_kind(kind)) {
    read_messages(*further, table, columns, columns_node, mapping, stream);
  } else {
    throw YamlError(mapping, source["kind"].Mark(),
                    "kind: imu, odometer, gps, " + kinds_in_csv_files());
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
    recording.streams.push_back(read_source(source, folder, mapping, recording.remarks));
  }
  finish(recording);
  return recording;
}

}  // namespace pipescout::estimate
