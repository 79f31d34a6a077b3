// SPDX-License-Identifier: Apache-2.0
#include "cli/completion_names.hpp"

#include <set>

#include "cli/session.hpp"
#include "core/interfaces.hpp"

namespace pipescout::host {
namespace {

/// Whoever presses a key waits for so long at most.
constexpr double kPatience = 1.0;  // s
constexpr Duration kQuiet = std::chrono::milliseconds(100);

std::vector<std::string> shown(const NamesAndTypes& names) {
  std::vector<std::string> result;
  for (const auto& [name, types] : names) {
    if (!is_hidden(name)) {
      result.push_back(name);
    }
  }
  return result;
}

}  // namespace

std::vector<std::string> completion_names(const std::string& kind) {
  std::vector<std::string> result;
  if (kind == "type") {
    for (const auto& name : known_interfaces()) {
      result.push_back(name.text());
    }
  } else if (kind == "package") {
    std::set<std::string> packages;
    for (const auto& name : known_interfaces()) {
      packages.insert(name.package);
    }
    result.assign(packages.begin(), packages.end());
  } else if (kind == "node" || kind == "container" || kind == "topic" || kind == "service") {
    Session session({.spin_time = kPatience});
    session.settle(kQuiet);
    if (kind == "topic") {
      return shown(session.graph().topics());
    }
    if (kind == "service") {
      return shown(session.graph().services());
    }
    for (const auto& node : session.nodes(false)) {
      if (kind == "node" ||
          session.serves(node, "_container/list_nodes", "composition_interfaces/srv/ListNodes")) {
        result.push_back(node.fully_qualified());
      }
    }
  }
  return result;
}

}  // namespace pipescout::host
