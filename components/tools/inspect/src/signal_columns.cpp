// SPDX-License-Identifier: Apache-2.0
#include "signal_columns.hpp"

#include <yaml-cpp/yaml.h>

#include <stdexcept>

#include "pipescout/command_line/known_keys.hpp"
#include "pipescout/command_line/map_texts.hpp"
#include "pipescout/csv/csv_words.hpp"
#include "pipescout/files/yaml_location.hpp"
#include "pipescout/odometry/weld_detector.hpp"

namespace pipescout::inspect {
namespace {

class SignalColumnsReader {
 public:
  SignalColumnsReader(const YAML::Node& root, const std::string& path) : root_(root), path_(path) {}

  [[nodiscard]] SignalColumns read() const {
    command_line::require_known_keys(root_, path_, "the columns of a signal",
                                     {"delimiter", "decimal_mark", "distance", "unit", "x", "y"});
    SignalColumns columns;
    columns.path = path_;
    columns.format.settings = path_;
    for (const char* key : {"delimiter", "decimal_mark"}) {
      try {
        columns.format.set(key, command_line::map_text(root_, key, path_).value_or(""));
      } catch (const std::invalid_argument& error) {
        fail(root_[key], error.what());
      }
    }
    columns.distance = command_line::required_map_text(root_, "distance", path_);
    const std::string unit = command_line::required_map_text(root_, "unit", path_);
    const auto metres = metres_per_list_unit(unit);
    if (!metres) {
      fail(root_["unit"], "unit must be one of " + list_unit_names() + ", not '" + unit + "'");
    }
    columns.metres_per_unit = *metres;
    columns.x = command_line::map_texts(root_, "x", path_);
    columns.y = command_line::map_texts(root_, "y", path_);
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

  const YAML::Node root_;
  const std::string& path_;
};

}  // namespace

SignalColumns load_signal_columns(const std::string& path) {
  return SignalColumnsReader(load_yaml(path), path).read();
}

}  // namespace pipescout::inspect
