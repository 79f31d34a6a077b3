// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "core/composition.hpp"
#include "pipescout/command_line/suggestion.hpp"

namespace pipescout::host {

void apply_parameter_arguments(Composition& composition, const std::vector<std::string>& names,
                               const std::vector<std::string>& arguments) {
  const auto is_component = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  for (const auto& argument : arguments) {
    ParameterRule rule;
    try {
      rule = ParameterRule::parse(argument, "--param " + argument);
    } catch (const std::invalid_argument& error) {
      throw CompositionError(std::string("--param: ") + error.what());
    }
    const auto dot = rule.parameter.name.find('.');
    if (rule.node.empty() && dot != std::string::npos &&
        is_component(rule.parameter.name.substr(0, dot))) {
      rule.node = rule.parameter.name.substr(0, dot);
      rule.parameter.name.erase(0, dot + 1);
      rule.parameter.from_wildcard = false;
    }
    if (!rule.node.empty() && !is_component(rule.node)) {
      throw CompositionError("--param " + argument + ": no component '" + rule.node + "' in " +
                             composition.path + command_line::suggestion(rule.node, names));
    }
    for (auto& entry : composition.components) {
      if (rule.node.empty() || rule.node == entry.name.name) {
        entry.parameters.push_back(rule.parameter);
      }
    }
  }
}

std::string located(const ComponentEntry& entry, const std::string& message) {
  const bool names_place =
      std::any_of(entry.parameters.begin(), entry.parameters.end(),
                  [&](const ParameterOverride& p) { return message.starts_with(p.source + ":"); });
  return names_place ? message : entry.location + ": " + message;
}

std::optional<std::set<std::string>> exported_topics(const Composition& composition) {
  if (!composition.exports) {
    return std::nullopt;
  }
  std::set<std::string> names;
  for (const auto& entry : *composition.exports) {
    names.insert(entry.leaves_as());
  }
  return names;
}

std::vector<std::size_t> stop_order(const std::vector<ComponentEntry>& components) {
  std::vector<std::size_t> order;
  for (const bool last : {false, true}) {
    for (std::size_t k = components.size(); k-- > 0;) {
      if (components[k].stops_last == last) {
        order.push_back(k);
      }
    }
  }
  return order;
}

}  // namespace pipescout::host
