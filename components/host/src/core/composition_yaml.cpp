// SPDX-License-Identifier: Apache-2.0
#include "core/composition.hpp"

namespace pipescout::host {
namespace {

std::string quoted(const std::string& text) {
  return to_yaml(ParameterValue(text));
}

std::string to_yaml(const ExecutorSettings& settings) {
  std::string out = settings.threads == 1
                        ? "{type: single_threaded"
                        : "{type: multi_threaded, threads: " + std::to_string(settings.threads);
  if (settings.nice) {
    out += ", nice: " + std::to_string(*settings.nice);
  }
  if (settings.fifo) {
    out += ", fifo: " + std::to_string(*settings.fifo);
  }
  return out + "}";
}

}  // namespace

std::string to_yaml(const Composition& composition,
                    const std::vector<std::vector<NamedParameter>>& parameters) {
  std::string out = "# As it was run, from " + composition.path + "\n";
  out += "name: " + quoted(composition.name) + "\n";
  if (!composition.arguments.empty()) {
    out += "arguments:\n";
    for (const auto& [name, value] : composition.arguments) {
      out += "  " + quoted(name) + ": " + quoted(value) + "\n";
    }
  }
  out += "executor: " + to_yaml(composition.executor) + "\n";
  out += composition.components.empty() ? "components: []\n" : "components:\n";
  for (std::size_t i = 0; i < composition.components.size(); ++i) {
    const auto& entry = composition.components[i];
    out += "  - type: " + quoted(entry.type) + "\n";
    out += "    name: " + quoted(entry.name.name) + "\n";
    if (entry.name.ns != "/") {
      out += "    namespace: " + quoted(entry.name.ns) + "\n";
    }
    if (i < parameters.size() && !parameters[i].empty()) {
      out += "    parameters:\n";
      for (const auto& parameter : parameters[i]) {
        if (parameter.value.is_set()) {
          out += "      " + quoted(parameter.name) + ": " + to_yaml(parameter.value) + "\n";
        }
      }
    }
    if (!entry.remappings.empty()) {
      out += "    remappings:\n";
      for (const auto& rule : entry.remappings) {
        const auto scheme = rule.kind == RemapRule::Kind::kTopic     ? "rostopic://"
                            : rule.kind == RemapRule::Kind::kService ? "rosservice://"
                                                                     : "";
        out += "      " + quoted(scheme + rule.from) + ": " + quoted(rule.to) + "\n";
      }
    }
    if (entry.log_level) {
      out += "    log_level: " + std::string(to_string(*entry.log_level)) + "\n";
    }
    if (entry.executor) {
      out += "    executor: " + to_yaml(*entry.executor) + "\n";
    }
    if (entry.stops_last) {
      out += "    stops_last: true\n";
    }
    if (entry.isolate) {
      out += "    isolate: true\n";
      out += "    restart: {limit: " + std::to_string(entry.restart.limit) +
             ", backoff: " + to_yaml(ParameterValue(to_seconds(entry.restart.backoff))) + "}\n";
    }
  }
  if (composition.exports) {
    out += composition.exports->empty() ? "export: []\n" : "export:\n";
    for (const auto& entry : *composition.exports) {
      out += "  - {topic: " + quoted(entry.topic);
      if (!entry.as.empty()) {
        out += ", as: " + quoted(entry.as);
      }
      if (entry.rate) {
        out += ", rate: " + to_yaml(ParameterValue(*entry.rate));
      }
      if (entry.shrink > 1) {
        out += ", shrink: " + std::to_string(entry.shrink);
      }
      out += "}\n";
    }
  }
  if (!composition.complete_when.empty()) {
    out += "complete_when:\n";
    for (const auto& name : composition.complete_when) {
      out += "  - " + quoted(name.fully_qualified()) + "\n";
    }
  }
  if (!composition.summary.empty()) {
    out += "summary:\n";
    for (const auto& option : composition.summary) {
      out += "  " + quoted(option.name) + ": " + to_yaml(option.value) + "\n";
    }
  }
  return out;
}

}  // namespace pipescout::host
