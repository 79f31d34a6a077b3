// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iostream>
#include <map>
#include <set>

#include "cli/session.hpp"
#include "core/actions.hpp"

namespace pipescout::host {
namespace {

struct NodeCommandOptions {
  DiscoveryOptions discovery;
  std::string node;
  bool hidden = false;
  bool count = false;
};

int list_nodes(Session& session, const NodeCommandOptions& options) {
  session.settle();
  const auto nodes = session.nodes(options.hidden);
  if (options.count) {
    std::cout << nodes.size() << '\n';
    return kExitOk;
  }
  for (const auto& node : nodes) {
    std::cout << node.fully_qualified() << '\n';
  }
  if (std::adjacent_find(nodes.begin(), nodes.end()) != nodes.end()) {
    std::cerr << "WARNING: Be aware that there are nodes in the graph that share an exact name, "
                 "which can have unintended side effects.\n";
  }
  return kExitOk;
}

/// What a node does with names of one kind.
NamesAndTypes names_of(const std::vector<GraphEndpoint>& endpoints, const NodeName& node,
                       bool publishers, DdsTopicKind kind, bool hidden) {
  NamesAndTypes result;
  for (const auto& endpoint : endpoints) {
    if (endpoint.node != node || endpoint.is_publisher != publishers) {
      continue;
    }
    const auto topic = demangle_topic_name(endpoint.wire_topic);
    if (!topic || topic->kind != kind || (!hidden && is_hidden(topic->name))) {
      continue;
    }
    const auto type = kind == DdsTopicKind::kTopic ? demangle_type_name(endpoint.wire_type)
                                                   : demangle_service_type_name(endpoint.wire_type);
    result[topic->name].insert(type.value_or(endpoint.wire_type));
  }
  return result;
}

void print_section(const char* title, const NamesAndTypes& names) {
  std::cout << "  " << title << ":\n";
  for (const auto& [name, types] : names) {
    std::cout << "    " << name << ": ";
    const char* separator = "";
    for (const auto& type : types) {
      std::cout << separator << type;
      separator = ", ";
    }
    std::cout << '\n';
  }
  if (names.empty()) {
    std::cout << '\n';
  }
}

int node_info(Session& session, const NodeCommandOptions& options) {
  const auto node = session.find_node(options.node);
  // Its endpoints follow one by one.
  session.settle();
  const auto nodes = session.graph().nodes();
  if (const auto count = std::count(nodes.begin(), nodes.end(), node); count > 1) {
    std::cerr << "There are " << count << " nodes in the graph with the exact name \""
              << node.fully_qualified()
              << "\". You are seeing information about only one of them.\n";
  }
  const auto endpoints = session.graph().endpoints();
  const auto names = [&](bool publishers, DdsTopicKind kind) {
    return names_of(endpoints, node, publishers, kind, options.hidden);
  };
  std::cout << node.fully_qualified() << '\n';
  print_section("Subscribers", names(false, DdsTopicKind::kTopic));
  print_section("Publishers", names(true, DdsTopicKind::kTopic));
  print_section("Service Servers", names(false, DdsTopicKind::kServiceRequest));
  print_section("Service Clients", names(true, DdsTopicKind::kServiceRequest));
  print_section("Action Servers", actions_of_node(endpoints, node, true));
  print_section("Action Clients", actions_of_node(endpoints, node, false));
  return kExitOk;
}

}  // namespace

void add_node_commands(CLI::App& app, Action& action) {
  auto* group = app.add_subcommand("node", "Nodes on the network");
  group->require_subcommand(1);

  const auto [list, list_options] =
      add_graph_command<NodeCommandOptions>(*group, action, "list", "List the nodes", list_nodes);
  list->add_flag("-a,--all", list_options->hidden, "Hidden nodes too");
  list->add_flag("-c,--count-nodes", list_options->count, "Print only the count");

  const auto [info, info_options] = add_graph_command<NodeCommandOptions>(
      *group, action, "info", "Show the publishers, subscriptions and services of a node",
      node_info);
  info->add_option("node", info_options->node, "Name of the node")->required();
  info->add_flag("--include-hidden", info_options->hidden, "Hidden topics and services too");
}

}  // namespace pipescout::host
