// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <lifecycle_msgs/srv/change_state.hpp>
#include <lifecycle_msgs/srv/get_available_transitions.hpp>
#include <lifecycle_msgs/srv/get_state.hpp>

#include "cli/session.hpp"

namespace pipescout::host {
namespace {

using lifecycle_msgs::srv::ChangeState;
using lifecycle_msgs::srv::GetAvailableTransitions;
using lifecycle_msgs::srv::GetState;

bool is_managed(Session& session, const NodeName& node) {
  return session.serves(node, "get_state", "lifecycle_msgs/srv/GetState");
}

/// Waits for a managed node that the user named.
NodeName find_managed(Session& session, const std::string& name) {
  const auto node = session.find_node(name);
  if (!session.wait_for([&] { return is_managed(session, node); })) {
    throw CommandError("Node " + node.fully_qualified() + " has no managed lifecycle");
  }
  return node;
}

std::vector<NodeName> managed_nodes(Session& session, bool hidden) {
  session.settle();
  auto nodes = session.nodes(hidden);
  std::erase_if(nodes, [&](const NodeName& node) { return !is_managed(session, node); });
  return nodes;
}

std::string state_of(Session& session, const NodeName& node) {
  const auto response = session.call<GetState>(node.fully_qualified() + "/get_state");
  const auto& state = response->current_state;
  return state.label + " [" + std::to_string(state.id) + "]";
}

int get_state(Session& session, const std::string& name, bool hidden) {
  if (!name.empty()) {
    std::cout << state_of(session, find_managed(session, name)) << '\n';
    return kExitOk;
  }
  int code = kExitOk;
  for (const auto& node : managed_nodes(session, hidden)) {
    try {
      std::cout << node.fully_qualified() << ": " << state_of(session, node) << '\n';
    } catch (const CommandError& error) {
      std::cerr << error.what() << '\n';
      code = kExitError;
    }
  }
  return code;
}

int set_state(Session& session, const std::string& name, const std::string& wanted) {
  const auto node = find_managed(session, name);
  const auto available =
      session.call<GetAvailableTransitions>(node.fully_qualified() + "/get_available_transitions");
  const lifecycle_msgs::msg::Transition* found = nullptr;
  for (const auto& description : available->available_transitions) {
    const auto& transition = description.transition;
    if (transition.label == wanted || std::to_string(transition.id) == wanted) {
      found = &transition;
      break;
    }
  }
  if (found == nullptr) {
    std::string text = "Unknown transition requested, available ones are:";
    for (const auto& description : available->available_transitions) {
      text += "\n- " + description.transition.label + " [" +
              std::to_string(description.transition.id) + "]";
    }
    throw CommandError(text);
  }
  ChangeState::Request request;
  request.transition = *found;
  const auto response =
      session.call<ChangeState>(node.fully_qualified() + "/change_state", std::move(request));
  if (!response->success) {
    throw CommandError("Transitioning failed");
  }
  std::cout << "Transitioning successful\n";
  return kExitOk;
}

int list_transitions(Session& session, const std::string& name, bool all) {
  const auto node = find_managed(session, name);
  const auto response = session.call<GetAvailableTransitions>(
      node.fully_qualified() + (all ? "/get_transition_graph" : "/get_available_transitions"));
  for (const auto& description : response->available_transitions) {
    std::cout << "- " << description.transition.label << " ["
              << std::to_string(description.transition.id)
              << "]\n\tStart: " << description.start_state.label
              << "\n\tGoal: " << description.goal_state.label << '\n';
  }
  return kExitOk;
}

int list_managed(Session& session, bool hidden, bool count) {
  const auto nodes = managed_nodes(session, hidden);
  if (count) {
    std::cout << nodes.size() << '\n';
    return kExitOk;
  }
  for (const auto& node : nodes) {
    std::cout << node.fully_qualified() << '\n';
  }
  return kExitOk;
}

struct LifecycleOptions {
  DiscoveryOptions discovery;
  std::string node;
  std::string transition;
  bool all = false;
  bool count = false;
};

}  // namespace

void add_lifecycle_commands(CLI::App& app, Action& action) {
  auto* group = app.add_subcommand("lifecycle", "States of managed nodes");
  group->require_subcommand(1);
  const auto add = [&](const char* name, const char* description,
                       int (*body)(Session&, const LifecycleOptions&)) {
    return add_session_command<LifecycleOptions>(*group, action, name, description, true, body);
  };

  auto [get, get_options] = add("get", "Print the state of a node, or of all",
                                [](Session& session, const LifecycleOptions& o) {
                                  return get_state(session, o.node, o.all);
                                });
  get->add_option("node", get_options->node, "Name of the node");
  get->add_flag("-a,--include-hidden-nodes", get_options->all, "Hidden nodes too");

  auto [set, set_options] =
      add("set", "Trigger a transition of a node", [](Session& session, const LifecycleOptions& o) {
        return set_state(session, o.node, o.transition);
      });
  set->add_option("node", set_options->node, "Name of the node")->required();
  set->add_option("transition", set_options->transition, "Label or number of the transition")
      ->required();

  auto [list, list_options] =
      add("list", "List the transitions that the current state of a node allows",
          [](Session& session, const LifecycleOptions& o) {
            return list_transitions(session, o.node, o.all);
          });
  list->add_option("node", list_options->node, "Name of the node")->required();
  list->add_flag("-a,--all", list_options->all, "All transitions of all states");

  auto [nodes, nodes_options] =
      add("nodes", "List the managed nodes", [](Session& session, const LifecycleOptions& o) {
        return list_managed(session, o.all, o.count);
      });
  nodes->add_flag("-a,--all", nodes_options->all, "Hidden nodes too");
  nodes->add_flag("-c,--count-nodes", nodes_options->count, "Print only the count");
}

}  // namespace pipescout::host
