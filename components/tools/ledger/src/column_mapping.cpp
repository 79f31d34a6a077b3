// SPDX-License-Identifier: Apache-2.0
#include "column_mapping.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "pipescout/command_line/suggestion.hpp"
#include "pipescout/csv/csv_table.hpp"
#include "pipescout/files/yaml_location.hpp"

namespace pipescout::ledger {
namespace {

using command_line::suggestion;

struct LengthUnit {
  const char* name;
  const char* symbol;
  double metres;
};
constexpr std::array<LengthUnit, 5> kUnits{{{"metres", "m", 1.0},
                                            {"millimetres", "mm", 1e-3},
                                            {"centimetres", "cm", 1e-2},
                                            {"kilometres", "km", 1e3},
                                            {"feet", "ft", 0.3048}}};
constexpr std::array kKeys{"delimiter",
                           "distance",
                           "unit",
                           "kind",
                           "girth_weld",
                           "clock",
                           "relative_distance",
                           "latitude",
                           "longitude",
                           "height",
                           "height_unit",
                           "odometer_standard_deviation",
                           "weld_standard_deviation",
                           "position_standard_deviation"};

class Reader {
 public:
  Reader(const YAML::Node& root, const std::string& path) : root_(root), path_(path) {}

  ColumnMapping read() const {
    if (!root_.IsMap()) {
      fail(root_, "a mapping of columns must be a map of keys: " + known_keys());
    }
    check_keys();
    ColumnMapping mapping;
    mapping.path = path_;
    mapping.delimiter = delimiter();
    mapping.distance = *column("distance", true);
    mapping.metres_per_unit = metres_per("unit", true);
    mapping.kind = *column("kind", true);
    mapping.girth_welds = girth_welds();
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
    mapping.position_standard_deviation =
        number("position_standard_deviation", mapping.position_standard_deviation, 1000.0);
    return mapping;
  }

 private:
  [[noreturn]] void fail(const YAML::Node& node, const std::string& message) const {
    throw YamlError(path_, node.Mark(), message);
  }

  static std::string known_keys() {
    std::string list;
    for (const char* key : kKeys) {
      list += (list.empty() ? "" : ", ") + std::string(key);
    }
    return list;
  }

  void check_keys() const {
    const std::vector<std::string> known(kKeys.begin(), kKeys.end());
    for (const auto& entry : root_) {
      const auto& key = entry.first.Scalar();
      if (std::find(known.begin(), known.end(), key) == known.end()) {
        fail(entry.first, "unknown key '" + key + "' in a mapping of columns" +
                              suggestion(key, known) + " (known: " + known_keys() + ")");
      }
    }
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
    std::string names;
    for (const auto& unit : kUnits) {
      if (*name == unit.name || *name == unit.symbol) {
        return unit.metres;
      }
      names += (names.empty() ? "" : ", ") + std::string(unit.name) + " (" + unit.symbol + ")";
    }
    fail(root_[key], key + " must be one of " + names + ", not '" + *name + "'");
  }

  char delimiter() const {
    const auto word = text("delimiter", false);
    if (!word) {
      return ',';
    }
    if (*word == "tab") {
      return '\t';
    }
    if (word->size() == 1 && std::string_view(",;|\t").find(*word) != std::string_view::npos) {
      return word->front();
    }
    fail(root_["delimiter"], "delimiter must be ',', ';', '|' or tab, not '" + *word + "'");
  }

  std::vector<std::string> girth_welds() const {
    const auto node = root_["girth_weld"];
    if (!node || node.IsScalar()) {
      return {*text("girth_weld", true)};
    }
    std::vector<std::string> names;
    for (const auto& entry : node) {
      if (!node.IsSequence() || !entry.IsScalar() || entry.Scalar().empty()) {
        fail(node, "girth_weld must be a text or a list of texts");
      }
      names.push_back(entry.Scalar());
    }
    if (names.empty()) {
      fail(node, "girth_weld must be a text or a list of texts");
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

}  // namespace

ColumnMapping load_column_mapping(const std::string& path) {
  return Reader(load_yaml(path), path).read();
}

ColumnMapping parse_column_mapping(const std::string& text, const std::string& path) {
  return Reader(parse_yaml(text, path), path).read();
}

}  // namespace pipescout::ledger
