// SPDX-License-Identifier: Apache-2.0
#include "core/actions.hpp"

#include <optional>
#include <string_view>

namespace pipescout::host {
namespace {

std::string_view without_suffix(std::string_view text, std::string_view suffix) {
  return text.ends_with(suffix) ? text.substr(0, text.size() - suffix.size()) : text;
}

/// The action whose feedback topic that is.
std::optional<std::string> action_of(std::string_view topic) {
  const std::string_view action = without_suffix(topic, "/_action/feedback");
  return action.size() < topic.size() && !action.empty() ? std::optional(std::string(action))
                                                         : std::nullopt;
}

std::string type_of(std::string_view feedback_type) {
  return std::string(without_suffix(feedback_type, "_FeedbackMessage"));
}

std::string type_of(const GraphEndpoint& endpoint) {
  return type_of(demangle_type_name(endpoint.wire_type).value_or(endpoint.wire_type));
}

std::optional<std::string> action_of(const GraphEndpoint& endpoint, bool servers) {
  if (endpoint.is_publisher != servers) {
    return std::nullopt;
  }
  const auto topic = demangle_topic_name(endpoint.wire_topic);
  return topic && topic->kind == DdsTopicKind::kTopic ? action_of(topic->name) : std::nullopt;
}

}  // namespace

NamesAndTypes actions_in(const NamesAndTypes& topics) {
  NamesAndTypes actions;
  for (const auto& [topic, types] : topics) {
    if (const auto action = action_of(topic)) {
      for (const auto& type : types) {
        actions[*action].insert(type_of(type));
      }
    }
  }
  return actions;
}

std::map<NodeName, std::set<std::string>> nodes_of_action(
    const std::vector<GraphEndpoint>& endpoints, const std::string& action, bool servers) {
  std::map<NodeName, std::set<std::string>> nodes;
  for (const auto& endpoint : endpoints) {
    if (endpoint.node && action_of(endpoint, servers) == action) {
      nodes[*endpoint.node].insert(type_of(endpoint));
    }
  }
  return nodes;
}

NamesAndTypes actions_of_node(const std::vector<GraphEndpoint>& endpoints, const NodeName& node,
                              bool servers) {
  NamesAndTypes actions;
  for (const auto& endpoint : endpoints) {
    if (endpoint.node != node) {
      continue;
    }
    if (const auto action = action_of(endpoint, servers)) {
      actions[*action].insert(type_of(endpoint));
    }
  }
  return actions;
}

}  // namespace pipescout::host
