// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "pipescout/runtime/graph.hpp"

/// Actions in the graph: each is known by its feedback topic, as rcl_action has it.
namespace pipescout::host {

/// Names of actions with their types ("nav2_msgs/action/NavigateToPose").
[[nodiscard]] NamesAndTypes actions_in(const NamesAndTypes& topics);

/// The nodes that serve an action, or use it, and the types under which they do. `action`: fully
/// qualified. Endpoints that belong to no node are left out.
[[nodiscard]] std::map<NodeName, std::set<std::string>> nodes_of_action(
    const std::vector<GraphEndpoint>& endpoints, const std::string& action, bool servers);

/// The actions that a node serves, or uses.
[[nodiscard]] NamesAndTypes actions_of_node(const std::vector<GraphEndpoint>& endpoints,
                                            const NodeName& node, bool servers);

}  // namespace pipescout::host
