// SPDX-License-Identifier: Apache-2.0
#include <composition_interfaces/srv/list_nodes.hpp>
#include <composition_interfaces/srv/load_node.hpp>
#include <composition_interfaces/srv/unload_node.hpp>
#include <iostream>
#include <map>

#include "cli/session.hpp"
#include "pipescout/runtime/component_registry.hpp"
#include "pipescout/runtime/conversions.hpp"

namespace pipescout::host {
namespace {

using composition_interfaces::srv::ListNodes;
using composition_interfaces::srv::LoadNode;
using composition_interfaces::srv::UnloadNode;

int list_types(const std::string& package) {
  const ComponentRegistry registry;
  std::map<std::string, std::vector<std::string>> classes;
  for (const auto& type : registry.types()) {
    classes[type.package].push_back(type.class_name);
  }
  for (const auto& problem : registry.problems()) {
    std::cerr << "warning: " << problem << '\n';
  }
  if (!package.empty()) {
    const auto found = classes.find(package);
    if (found == classes.end()) {
      throw CommandError("Unable to find package '" + package + "'");
    }
    for (const auto& name : found->second) {
      std::cout << name << '\n';
    }
    return kExitOk;
  }
  for (const auto& [name, list] : classes) {
    std::cout << name << '\n';
    for (const auto& type : list) {
      std::cout << "  " << type << '\n';
    }
  }
  return kExitOk;
}

bool is_container(Session& session, const NodeName& node) {
  return session.serves(node, "_container/load_node", "composition_interfaces/srv/LoadNode") &&
         session.serves(node, "_container/unload_node", "composition_interfaces/srv/UnloadNode") &&
         session.serves(node, "_container/list_nodes", "composition_interfaces/srv/ListNodes");
}

NodeName find_container(Session& session, const std::string& name) {
  const auto node = session.find_node(name);
  if (!session.wait_for([&] { return is_container(session, node); })) {
    throw CommandError("Unable to find container node '" + name + "'");
  }
  return node;
}

void list_container(Session& session, const NodeName& container, const char* indent) {
  const auto nodes =
      session.call<ListNodes>(container.fully_qualified() + "/_container/list_nodes");
  for (std::size_t i = 0; i < nodes->unique_ids.size() && i < nodes->full_node_names.size(); ++i) {
    std::cout << indent << nodes->unique_ids[i] << "  " << nodes->full_node_names[i] << '\n';
  }
}

struct ComponentListOptions {
  DiscoveryOptions discovery;
  std::string container;
  bool containers_only = false;
};

int list_components(Session& session, const ComponentListOptions& options) {
  if (!options.container.empty()) {
    const auto node = find_container(session, options.container);
    if (!options.containers_only) {
      list_container(session, node, "");
    }
    return kExitOk;
  }
  session.settle();
  for (const auto& node : session.nodes(false)) {
    if (!is_container(session, node)) {
      continue;
    }
    std::cout << node.fully_qualified() << '\n';
    if (!options.containers_only) {
      list_container(session, node, "  ");
    }
  }
  return kExitOk;
}

struct LoadOptions {
  DiscoveryOptions discovery;
  std::string container;
  std::string package;
  std::string plugin;
  std::string name;
  std::string ns;
  std::string log_level;
  std::vector<std::string> remap_rules;
  std::vector<std::string> parameters;
  std::vector<std::string> extra_arguments;
};

std::vector<rcl_interfaces::msg::Parameter> to_parameters(const std::vector<std::string>& texts) {
  std::vector<rcl_interfaces::msg::Parameter> result;
  for (const auto& text : texts) {
    const auto separator = text.find(":=");
    if (separator == std::string::npos || separator == 0) {
      throw CommandError("'" + text + "' must have the form name:=value");
    }
    try {
      result.push_back(to_message(NamedParameter{
          text.substr(0, separator), parse_parameter_value(text.substr(separator + 2))}));
    } catch (const std::invalid_argument& error) {
      throw CommandError(text + ": " + error.what());
    }
  }
  return result;
}

std::uint8_t to_log_level(const std::string& text) {
  static const std::map<std::string, LogSeverity> kLevels{{"debug", LogSeverity::kDebug},
                                                          {"info", LogSeverity::kInfo},
                                                          {"warn", LogSeverity::kWarn},
                                                          {"error", LogSeverity::kError},
                                                          {"fatal", LogSeverity::kFatal}};
  return text.empty() ? 0 : static_cast<std::uint8_t>(kLevels.at(text));
}

int load(Session& session, const LoadOptions& options) {
  LoadNode::Request request;
  request.package_name = options.package;
  request.plugin_name = options.plugin;
  request.node_name = options.name;
  request.node_namespace = options.ns;
  request.log_level = to_log_level(options.log_level);
  request.remap_rules = options.remap_rules;
  request.parameters = to_parameters(options.parameters);
  request.extra_arguments = to_parameters(options.extra_arguments);
  const auto container = find_container(session, options.container);
  const auto response = session.call<LoadNode>(
      container.fully_qualified() + "/_container/load_node", std::move(request));
  if (!response->success) {
    throw CommandError("Failed to load component: " + response->error_message);
  }
  std::cout << "Loaded component " << response->unique_id << " into '" << options.container
            << "' container node as '" << response->full_node_name << "'\n";
  return kExitOk;
}

struct UnloadOptions {
  DiscoveryOptions discovery;
  std::string container;
  std::vector<std::uint64_t> ids;
  bool quiet = false;
};

int unload(Session& session, const UnloadOptions& options) {
  const auto container = find_container(session, options.container);
  for (const auto id : options.ids) {
    UnloadNode::Request request;
    request.unique_id = id;
    const auto response = session.call<UnloadNode>(
        container.fully_qualified() + "/_container/unload_node", std::move(request));
    if (!response->success) {
      throw CommandError("Failed to unload component " + std::to_string(id) + " from '" +
                         options.container + "' container node\n    " + response->error_message);
    }
    if (options.quiet) {
      std::cout << id << '\n';
    } else {
      std::cout << "Unloaded component " << id << " from '" << options.container
                << "' container node\n";
    }
  }
  return kExitOk;
}

void add_types(CLI::App& group, Action& action) {
  auto package = std::make_shared<std::string>();
  auto* command = group.add_subcommand("types", "List the installed component classes");
  command->add_option("package", *package, "Only those of this package");
  command->callback([=, &action] { action = [=] { return list_types(*package); }; });
}

void add_list(CLI::App& group, Action& action) {
  const auto [command, options] = add_session_command<ComponentListOptions>(
      group, action, "list", "List running containers and their components", true, list_components);
  command->add_option("container", options->container, "Name of a container node");
  command->add_flag("--containers-only", options->containers_only, "List container nodes only");
}

void add_load(CLI::App& group, Action& action) {
  const auto [command, options] = add_session_command<LoadOptions>(
      group, action, "load", "Load a component into a running container", true, load);
  command->add_option("container", options->container, "Name of the container node")->required();
  command->add_option("package", options->package, "Package of the component")->required();
  command->add_option("plugin", options->plugin, "Class of the component")->required();
  command->add_option("-n,--node-name", options->name, "Name of the component's node");
  command->add_option("--node-namespace", options->ns, "Namespace of the component's node");
  command->add_option("--log-level", options->log_level, "Log level")
      ->check(CLI::IsMember({"debug", "info", "warn", "error", "fatal"}));
  const auto add_list_option = [command = command](const char* name,
                                                   std::vector<std::string>& values,
                                                   const char* description) {
    command->add_option(name, values, description)
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  };
  add_list_option("-r,--remap-rule", options->remap_rules, "Remapping, FROM:=TO");
  add_list_option("-p,--parameter", options->parameters, "Parameter, NAME:=VALUE");
  add_list_option("-e,--extra-argument", options->extra_arguments,
                  "Argument for the container, NAME:=VALUE; autostart:=false leaves the component "
                  "unconfigured");
}

void add_unload(CLI::App& group, Action& action) {
  const auto [command, options] = add_session_command<UnloadOptions>(
      group, action, "unload", "Unload components from a running container", true, unload);
  command->add_option("container", options->container, "Name of the container node")->required();
  command->add_option("ids", options->ids, "Unique numbers of the components")->required();
  command->add_flag("-q,--quiet", options->quiet, "Print the numbers only");
}

}  // namespace

void add_component_commands(CLI::App& app, Action& action) {
  auto* group = app.add_subcommand("component", "Component classes and containers");
  group->require_subcommand(1);
  add_types(*group, action);
  add_list(*group, action);
  add_load(*group, action);
  add_unload(*group, action);
}

}  // namespace pipescout::host
