// SPDX-License-Identifier: Apache-2.0
#include "column_mapping.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "pipescout/command_line/known_keys.hpp"
#include "pipescout/command_line/map_texts.hpp"
#include "pipescout/csv/csv_cell.hpp"
#include "pipescout/csv/csv_words.hpp"
#include "pipescout/files/yaml_location.hpp"

namespace pipescout::ledger {
namespace {

constexpr std::array kKeys{"delimiter",
                           "decimal_mark",
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
    mapping.format.settings = path_;
    for (const char* key : {"delimiter", "decimal_mark"}) {
      set_format(key, mapping.format);
    }
    mapping.distance = *column("distance", true);
    mapping.metres_per_unit = metres_per("unit", true);
    const std::string said = bracketed(mapping.distance.name);
    const auto metres = metres_per_list_unit(said);
    if (metres && *metres != mapping.metres_per_unit) {
      fail(root_["unit"], "unit is '" + root_["unit"].Scalar() + "', and the column '" +
                              mapping.distance.name + "' says " + said);
    }
    mapping.kind = *column("kind", true);
    mapping.girth_welds = command_line::map_texts(root_, "girth_weld", path_);
    for (const auto& [key, kind] : kLandmarkKeys) {
      if (root_[key]) {
        mapping.landmarks.push_back({kind, command_line::map_texts(root_, key, path_)});
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

  std::optional<std::string> text_of(const std::string& key, bool required) const {
    return required ? command_line::required_map_text(root_, key, path_)
                    : command_line::map_text(root_, key, path_);
  }

  std::optional<MappedColumn> column(const std::string& key, bool required) const {
    const auto name = text_of(key, required);
    if (!name) {
      return std::nullopt;
    }
    return MappedColumn{.name = *name, .location = location(path_, root_[key].Mark())};
  }

  double metres_per(const std::string& key, bool required) const {
    const auto name = text_of(key, required);
    if (!name) {
      return 1.0;
    }
    const auto metres = metres_per_list_unit(*name);
    if (!metres) {
      fail(root_[key], key + " must be one of " + list_unit_names() + ", not '" + *name + "'");
    }
    return *metres;
  }

  void set_format(const char* key, CsvFormat& format) const {
    try {
      format.set(key, text_of(key, false).value_or(""));
    } catch (const std::invalid_argument& error) {
      fail(root_[key], error.what());
    }
  }

  double number(const std::string& key, double fallback, double largest) const {
    const auto word = text_of(key, false);
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

}  // namespace

ColumnMapping load_column_mapping(const std::string& path) {
  return Reader(load_yaml(path), path).read();
}

ColumnMapping parse_column_mapping(const std::string& text, const std::string& path) {
  return Reader(parse_yaml(text, path), path).read();
}

std::optional<ColumnMapping> pof_column_mapping(const std::vector<std::string>& columns,
                                                const CsvFormat& format) {
  ColumnMapping mapping;
  mapping.format = format;
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

}  // namespace pipescout::ledger
