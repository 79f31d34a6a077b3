// SPDX-License-Identifier: Apache-2.0
#include "mission_info.hpp"

#include <yaml-cpp/yaml.h>

#include <set>
#include <stdexcept>

#include "pipescout/runtime/names.hpp"
#include "pipescout/runtime/parameter_yaml.hpp"

namespace pipescout::summary {
namespace {

namespace fs = std::filesystem;

std::string text(const YAML::Node& node) {
  return node && node.IsScalar() ? node.Scalar() : "";
}

NodeName node_of(const YAML::Node& component) {
  const std::string ns = text(component["namespace"]);
  return {ns.empty() ? "/" : ns, text(component["name"])};
}

std::string source_of(const YAML::Node& components) {
  for (const YAML::Node& component : components) {
    const std::string source = text(component["parameters"]["source"]);
    if (text(component["type"]) == "pipescout::BagRecorder" && !source.empty()) {
      return expand_topic_name(source, node_of(component));
    }
  }
  return "";
}

/// Of the one consensus fusion of each namespace.
std::map<std::string, std::vector<double>> offsets_of(const YAML::Node& components) {
  std::map<std::string, std::vector<double>> offsets;
  std::set<std::string> ambiguous;
  for (const YAML::Node& component : components) {
    const YAML::Node& added = component["parameters"]["offsets"];
    if (text(component["type"]) != "pipescout::OdometryFusion" || !added) {
      continue;
    }
    const std::string ns = text(component["namespace"]);
    if (!offsets.emplace(ns.empty() ? "/" : ns, added.as<std::vector<double>>()).second) {
      ambiguous.insert(ns.empty() ? "/" : ns);
    }
  }
  for (const std::string& ns : ambiguous) {
    offsets.erase(ns);
  }
  return offsets;
}

}  // namespace

MissionInfo read_mission_info(const fs::path& mission_folder) {
  MissionInfo info;
  const fs::path file = mission_folder / "mission.yaml";
  if (!fs::exists(file)) {
    return info;
  }
  try {
    const YAML::Node root = YAML::LoadFile(file.string());
    if (!root.IsMap()) {
      throw std::invalid_argument(file.string() + ": is no composition");
    }
    if (root["components"]) {
      info.source = source_of(root["components"]);
      info.odometer_offsets = offsets_of(root["components"]);
      for (const YAML::Node& component : root["components"]) {
        info.nodes.push_back(node_of(component).fully_qualified());
      }
    }
    for (const YAML::Node& node : root["complete_when"]) {
      info.complete_when.push_back(text(node));
    }
    if (root["summary"]) {
      info.options = read_table_options(read_parameter_map(root["summary"], file.string()));
    }
  } catch (const YAML::Exception& error) {
    throw std::invalid_argument(file.string() + ": " + error.what());
  }
  return info;
}

std::vector<fs::path> bags_of(const fs::path& mission_folder) {
  std::vector<fs::path> bags;
  fs::path bag = mission_folder / "bag";
  for (int i = 2; fs::exists(bag); ++i) {
    bags.push_back(bag);
    bag = mission_folder / ("bag_" + std::to_string(i));
  }
  return bags;
}

}  // namespace pipescout::summary
