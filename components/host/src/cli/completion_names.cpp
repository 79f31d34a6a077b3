// SPDX-License-Identifier: Apache-2.0
#include "cli/completion_names.hpp"

#include <set>

#include "cli/session.hpp"
#include "core/actions.hpp"
#include "core/interfaces.hpp"
#include "pipescout/runtime/component_registry.hpp"

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

/// Of the running system.
std::vector<std::string> found_names(const std::string& kind) {
  Session session({.spin_time = kPatience});
  (void)session.discover(kQuiet);  // what is missing cannot be said here
  // `bag record` takes several.
  if (kind == "topic" || kind == "topics") {
    return shown(session.graph().topics());
  }
  if (kind == "service") {
    return shown(session.graph().services());
  }
  if (kind == "action") {
    return shown(actions_in(session.graph().topics()));
  }
  std::vector<std::string> result;
  for (const auto& node : session.nodes(false)) {
    if (kind == "node" ||
        session.serves(node, "_container/list_nodes", "composition_interfaces/srv/ListNodes")) {
      result.push_back(node.fully_qualified());
    }
  }
  return result;
}

}  // namespace

std::vector<std::string> completion_names(const std::string& kind) {
  if (kind == "type") {
    std::vector<std::string> result;
    for (const auto& name : known_interfaces()) {
      result.push_back(name.text());
    }
    return result;
  }
  if (kind == "package" || kind == "plugin") {
    std::set<std::string> result;
    const ComponentRegistry registry;
    for (const auto& type : registry.types()) {
      result.insert(kind == "plugin" ? type.class_name : type.package);
    }
    if (kind == "package") {
      for (const auto& name : known_interfaces()) {
        result.insert(name.package);
      }
    }
    return {result.begin(), result.end()};
  }
  static const std::set<std::string> kFound{"node",   "container", "topic",
                                            "topics", "service",   "action"};
  return kFound.contains(kind) ? found_names(kind) : std::vector<std::string>();
}

}  // namespace pipescout::host
