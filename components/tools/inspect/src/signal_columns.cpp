// SPDX-License-Identifier: Apache-2.0
#include "signal_columns.hpp"

#include <yaml-cpp/yaml.h>

#include <optional>

#include "pipescout/command_line/known_keys.hpp"
#include "pipescout/csv/list_table.hpp"
#include "pipescout/files/yaml_location.hpp"
#include "pipescout/odometry/weld_detector.hpp"

namespace pipescout::inspect {
namespace {

class SignalColumnsReader {
 public:
  SignalColumnsReader(const YAML::Node& root, const std::string& path) : root_(root), path_(path) {}

  [[nodiscard]] SignalColumns read() const {
    command_line::require_known_keys(root_, path_, "the columns of a signal",
                                     {"delimiter", "distance", "unit", "x", "y"});
    SignalColumns columns;
    columns.path = path_;
    if (const auto word = text("delimiter")) {
      const auto delimiter = list_delimiter(*word);
      if (!delimiter) {
        fail(root_["delimiter"], "delimiter must be ',', ';', '|' or tab, not '" + *word + "'");
      }
      columns.delimiter = *delimiter;
    }
    columns.distance = required_text("distance");
    const std::string unit = required_text("unit");
    const auto metres = metres_per_list_unit(unit);
    if (!metres) {
      fail(root_["unit"], "unit must be one of " + list_unit_names() + ", not '" + unit + "'");
    }
    columns.metres_per_unit = *metres;
    columns.x = texts("x");
    columns.y = texts("y");
    if (columns.x.size() != columns.y.size()) {
      fail(root_["y"], std::to_string(columns.y.size()) + " columns of y for " +
                           std::to_string(columns.x.size()) + " of x");
    }
    if (columns.x.size() > odometry::kMaxEddyCurrentChannels) {
      fail(root_["x"], std::to_string(columns.x.size()) + " channels; at most " +
                           std::to_string(odometry::kMaxEddyCurrentChannels) + " are possible");
    }
    return columns;
  }

 private:
  [[noreturn]] void fail(const YAML::Node& node, const std::string& message) const {
    throw YamlError(path_, node.Mark(), message);
  }

  [[nodiscard]] std::optional<std::string> text(const std::string& key) const {
    const auto node = root_[key];
    if (!node) {
      return std::nullopt;
    }
    if (!node.IsScalar() || node.Scalar().empty()) {
      fail(node, key + " must be a text");
    }
    return node.Scalar();
  }

  [[nodiscard]] std::string required_text(const std::string& key) const {
    const auto value = text(key);
    if (!value) {
      fail(root_, "key '" + key + "' is missing");
    }
    return *value;
  }

  /// One text, or a list of texts.
  [[nodiscard]] std::vector<std::string> texts(const std::string& key) const {
    const auto node = root_[key];
    if (!node || !node.IsSequence()) {
      return {required_text(key)};
    }
    std::vector<std::string> names;
    for (const auto& entry : node) {
      if (!entry.IsScalar() || entry.Scalar().empty()) {
        fail(entry, key + " must be a text or a list of texts");
      }
      names.push_back(entry.Scalar());
    }
    if (names.empty()) {
      fail(node, key + " must be a text or a list of texts");
    }
    return names;
  }

  const YAML::Node root_;
  const std::string& path_;
};

}  // namespace

SignalColumns load_signal_columns(const std::string& path) {
  return SignalColumnsReader(load_yaml(path), path).read();
}

}  // namespace pipescout::inspect
