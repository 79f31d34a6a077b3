// SPDX-License-Identifier: Apache-2.0
#include "column_mapping.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <utility>

#include "pipescout/command_line/known_keys.hpp"
#include "pipescout/csv/csv_rows.hpp"
#include "pipescout/csv/csv_table.hpp"
#include "pipescout/csv/list_table.hpp"
#include "pipescout/files/yaml_location.hpp"

namespace pipescout::ledger {
namespace {

constexpr std::array kKeys{"delimiter",
                           "distance",
                           "unit",
                           "kind",
                           "girth_weld",
                           "markers",
                           "valves",
                           "tees",
                           "bends",
                           "clock",
                           "relative_distance",
                           "latitude",
                           "longitude",
                           "height",
                           "height_unit",
                           "odometer_standard_deviation",
                           "weld_standard_deviation",
                           "landmark_standard_deviation",
                           "position_standard_deviation"};

using odometry::LandmarkKind;
constexpr std::array<std::pair<const char*, LandmarkKind>, 4> kLandmarkKeys{
    {{"markers", LandmarkKind::kMarker},
     {"valves", LandmarkKind::kValve},
     {"tees", LandmarkKind::kTee},
     {"bends", LandmarkKind::kBend}}};

class Reader {
 public:
  Reader(const YAML::Node& root, const std::string& path) : root_(root), path_(path) {}

  ColumnMapping read() const {
    command_line::require_known_keys(root_, path_, "a mapping of columns",
                                     {kKeys.begin(), kKeys.end()});
    ColumnMapping mapping;
    mapping.path = path_;
    mapping.delimiter = delimiter();
    mapping.distance = *column("distance", true);
    mapping.metres_per_unit = metres_per("unit", true);
    mapping.kind = *column("kind", true);
    mapping.girth_welds = names_of("girth_weld");
    for (const auto& [key, kind] : kLandmarkKeys) {
      if (root_[key]) {
        mapping.landmarks.push_back({kind, names_of(key)});
      }
    }
    mapping.clock = column("clock", false);
    mapping.relative_distance = column("relative_distance", false);
    mapping.latitude = column("latitude", false);
    mapping.longitude = column("longitude", false);
    mapping.height = column("height", false);
    mapping.metres_per_height_unit = metres_per("height_unit", false);
    if (mapping.latitude.has_value() != mapping.longitude.has_value()) {
      fail(root_[mapping.latitude ? "latitude" : "longitude"],
           "latitude and longitude belong together; one of them is missing");
    }
    if (mapping.height && !mapping.latitude) {
      fail(root_["height"], "a height needs a latitude and a longitude");
    }
    if (root_["height_unit"] && !mapping.height) {
      fail(root_["height_unit"], "height_unit needs a height");
    }
    mapping.odometer_standard_deviation =
        number("odometer_standard_deviation", mapping.odometer_standard_deviation, 1.0);
    mapping.weld_standard_deviation =
        number("weld_standard_deviation", mapping.weld_standard_deviation, 10.0);
    mapping.landmark_standard_deviation =
        number("landmark_standard_deviation", mapping.landmark_standard_deviation, 10.0);
    mapping.position_standard_deviation =
        number("position_standard_deviation", mapping.position_standard_deviation, 1000.0);
    return mapping;
  }

 private:
  [[noreturn]] void fail(const YAML::Node& node, const std::string& message) const {
    throw YamlError(path_, node.Mark(), message);
  }

  /// The text of a key; nothing when the key is missing and may be.
  std::optional<std::string> text(const std::string& key, bool required) const {
    const auto node = root_[key];
    if (!node) {
      if (required) {
        fail(root_, "key '" + key + "' is missing");
      }
      return std::nullopt;
    }
    if (!node.IsScalar() || node.Scalar().empty()) {
      fail(node, key + " must be a text");
    }
    return node.Scalar();
  }

  std::optional<MappedColumn> column(const std::string& key, bool required) const {
    const auto name = text(key, required);
    if (!name) {
      return std::nullopt;
    }
    return MappedColumn{.name = *name, .location = location(path_, root_[key].Mark())};
  }

  double metres_per(const std::string& key, bool required) const {
    const auto name = text(key, required);
    if (!name) {
      return 1.0;
    }
    const auto metres = metres_per_list_unit(*name);
    if (!metres) {
      fail(root_[key], key + " must be one of " + list_unit_names() + ", not '" + *name + "'");
    }
    return *metres;
  }

  char delimiter() const {
    const auto word = text("delimiter", false);
    if (!word) {
      return ',';
    }
    if (const auto delimiter = list_delimiter(*word)) {
      return *delimiter;
    }
    fail(root_["delimiter"], "delimiter must be ',', ';', '|' or tab, not '" + *word + "'");
  }

  /// A text or a list of texts.
  std::vector<std::string> names_of(const std::string& key) const {
    const auto node = root_[key];
    if (!node || node.IsScalar()) {
      return {*text(key, true)};
    }
    std::vector<std::string> names;
    for (const auto& entry : node) {
      if (!node.IsSequence() || !entry.IsScalar() || entry.Scalar().empty()) {
        fail(node, key + " must be a text or a list of texts");
      }
      names.push_back(entry.Scalar());
    }
    if (names.empty()) {
      fail(node, key + " must be a text or a list of texts");
    }
    return names;
  }

  double number(const std::string& key, double fallback, double largest) const {
    const auto word = text(key, false);
    if (!word) {
      return fallback;
    }
    const auto value = parse_csv_number(*word);
    if (!value || !(*value > 0.0 && *value <= largest)) {
      fail(root_[key], key + " must be a number in (0, " + format_csv_number(largest) + "], not '" +
                           *word + "'");
    }
    return *value;
  }

  const YAML::Node root_;
  const std::string& path_;
};

std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return text;
}

/// "m" of "Log distance [m]" or "Log distance (m)"; empty without.
std::string bracketed(const std::string& name) {
  const auto open = name.find_last_of("[(");
  const auto close = name.find_last_of("])");
  return open == std::string::npos || close == std::string::npos || close < open
             ? std::string()
             : name.substr(open + 1, close - open - 1);
}

/// The one column whose name begins with one of these, in small letters; nothing when there are
/// none or several.
std::optional<MappedColumn> pof_column(const std::vector<std::string>& columns,
                                       std::initializer_list<std::string_view> beginnings) {
  std::optional<MappedColumn> found;
  for (const std::string& column : columns) {
    const std::string name = lower_case(column);
    if (std::ranges::any_of(beginnings, [&](auto begin) { return name.starts_with(begin); })) {
      if (found) {
        return std::nullopt;
      }
      found = MappedColumn{.name = column, .location = "the Pipeline Operators Forum"};
    }
  }
  return found;
}

std::optional<ColumnMapping> pof_mapping_of(const std::vector<std::string>& columns) {
  ColumnMapping mapping;
  mapping.path = "the list of the Pipeline Operators Forum";
  const auto distance = pof_column(columns, {"log distance"});
  const auto kind = pof_column(columns, {"feature type"});
  const auto unit = distance ? metres_per_list_unit(bracketed(distance->name)) : std::nullopt;
  if (!distance || !kind || !unit) {
    return std::nullopt;
  }
  mapping.distance = *distance;
  mapping.kind = *kind;
  mapping.metres_per_unit = *unit;
  mapping.girth_welds = {"Weld", "weld", "Girth weld", "Girth Weld", "girth weld", "GWD"};
  mapping.landmarks = {
      {LandmarkKind::kMarker, {"Marker", "marker", "Above ground marker", "AGM"}},
      {LandmarkKind::kValve, {"Valve", "valve", "VALV"}},
      {LandmarkKind::kTee, {"Tee", "tee", "TEE", "Off take", "Offtake", "Off-take", "OFFT"}},
      {LandmarkKind::kBend, {"Bend", "bend", "BEND"}}};
  mapping.clock = pof_column(columns, {"clock position", "o'clock"});
  const auto relative = pof_column(
      columns, {"abs. dist. to upstream weld", "up weld dist", "dist. to upstream weld"});
  if (relative && bracketed(relative->name) == bracketed(distance->name)) {
    mapping.relative_distance = relative;
  }
  mapping.latitude = pof_column(columns, {"latitude"});
  mapping.longitude = pof_column(columns, {"longitude"});
  if (!mapping.latitude || !mapping.longitude) {
    mapping.latitude.reset();
    mapping.longitude.reset();
  }
  return mapping;
}

}  // namespace

ColumnMapping load_column_mapping(const std::string& path) {
  return Reader(load_yaml(path), path).read();
}

ColumnMapping parse_column_mapping(const std::string& text, const std::string& path) {
  return Reader(parse_yaml(text, path), path).read();
}

std::optional<ColumnMapping> pof_column_mapping(std::string_view header) {
  for (const char delimiter : {',', ';', '\t', '|'}) {
    const CsvRows rows = read_csv_rows(header, delimiter);
    if (rows.rows.empty()) {
      return std::nullopt;
    }
    std::vector<std::string> columns = rows.rows.front().cells;
    std::ranges::transform(columns, columns.begin(), folded);
    if (auto mapping = pof_mapping_of(columns)) {
      mapping->delimiter = delimiter;
      return mapping;
    }
  }
  return std::nullopt;
}

}  // namespace pipescout::ledger
