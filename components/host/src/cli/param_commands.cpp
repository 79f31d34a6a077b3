// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iostream>
#include <rcl_interfaces/srv/describe_parameters.hpp>
#include <rcl_interfaces/srv/get_parameters.hpp>
#include <rcl_interfaces/srv/list_parameters.hpp>

#include "cli/param_changes.hpp"
#include "cli/session.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/hint.hpp"
#include "pipescout/runtime/parameter_yaml.hpp"

namespace pipescout::host {
namespace {

using rcl_interfaces::srv::DescribeParameters;
using rcl_interfaces::srv::GetParameters;
using rcl_interfaces::srv::ListParameters;

struct ParamOptions {
  DiscoveryOptions discovery;
  std::string node;
  std::string name;
  std::vector<std::string> names;
  bool flag = false;  ///< --param-type, --hide-type
  bool hidden = false;
};

std::string service_of(const NodeName& node, const char* service) {
  return node.fully_qualified() + "/" + service;
}

std::vector<std::string> list_names(Session& session, const NodeName& node,
                                    const std::vector<std::string>& prefixes) {
  ListParameters::Request request;
  request.prefixes = prefixes;
  const auto response =
      session.call<ListParameters>(service_of(node, "list_parameters"), std::move(request));
  auto names = response->result.names;
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<ParameterDescriptor> describe(Session& session, const NodeName& node,
                                          const std::vector<std::string>& names) {
  DescribeParameters::Request request;
  request.names = names;
  const auto response =
      session.call<DescribeParameters>(service_of(node, "describe_parameters"), std::move(request));
  std::vector<ParameterDescriptor> descriptors;
  for (const auto& descriptor : response->descriptors) {
    descriptors.push_back(from_message(descriptor));
  }
  return descriptors;
}

std::vector<ParameterValue> get_values(Session& session, const NodeName& node,
                                       const std::vector<std::string>& names) {
  GetParameters::Request request;
  request.names = names;
  const auto response =
      session.call<GetParameters>(service_of(node, "get_parameters"), std::move(request));
  std::vector<ParameterValue> values;
  for (const auto& value : response->values) {
    values.push_back(from_message(value));
  }
  return values;
}

void print_names(Session& session, const NodeName& node, const ParamOptions& options) {
  const auto names = list_names(session, node, options.names);
  std::vector<ParameterDescriptor> descriptors;
  if (options.flag && !names.empty()) {
    descriptors = describe(session, node, names);
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::cout << "  " << names[i];
    if (i < descriptors.size()) {
      std::cout << " (type: " << to_string(descriptors[i].type) << ')';
    }
    std::cout << '\n';
  }
}

int list(Session& session, const ParamOptions& options) {
  if (!options.node.empty()) {
    print_names(session, session.find_node(options.node), options);
    return kExitOk;
  }
  session.settle();
  int code = kExitOk;
  for (const auto& node : session.nodes(options.hidden)) {
    if (!session.serves(node, "list_parameters", "rcl_interfaces/srv/ListParameters")) {
      continue;
    }
    std::cout << node.fully_qualified() << ":\n";
    try {
      print_names(session, node, options);
    } catch (const CommandError& error) {
      std::cerr << error.what() << '\n';
      code = kExitError;
    }
  }
  return code;
}

/// Throws what to say of a parameter that a node does not have.
[[noreturn]] void not_declared(Session& session, const NodeName& node, const std::string& name) {
  const auto nearest = nearest_name(name, list_names(session, node, {}));
  throw CommandError("Parameter '" + name + "' is not declared by " + node.fully_qualified() +
                     (nearest ? did_you_mean(name, *nearest) : ""));
}

int get(Session& session, const ParamOptions& options) {
  const auto node = session.find_node(options.node);
  const auto& name = options.name;
  const auto values = get_values(session, node, {name});
  if (values.empty()) {
    not_declared(session, node, name);
  }
  const auto& value = values.front();
  if (options.flag) {
    std::cout << to_string(value) << '\n';
  } else {
    std::cout << value_label(value.type());
    if (value.is_set()) {
      std::cout << ' ' << to_string(value);
    }
    std::cout << '\n';
  }
  return kExitOk;
}

template <class Range>
void print_range(const Range& range) {
  std::cout << "    Min value: " << to_string(ParameterValue(range.from))
            << "\n    Max value: " << to_string(ParameterValue(range.to)) << '\n';
  if (range.step != 0) {
    std::cout << "    Step: " << to_string(ParameterValue(range.step)) << '\n';
  }
}

int describe(Session& session, const ParamOptions& options) {
  const auto node = session.find_node(options.node);
  auto names = options.names;
  if (names.empty()) {
    names = list_names(session, node, {});
  }
  const auto descriptors = describe(session, node, names);
  for (const auto& name : names) {
    const auto found = std::find_if(descriptors.begin(), descriptors.end(),
                                    [&](const ParameterDescriptor& d) { return d.name == name; });
    if (found == descriptors.end()) {
      not_declared(session, node, name);
    }
    std::cout << "Parameter name: " << found->name << "\n  Type: " << to_string(found->type)
              << '\n';
    if (!found->description.empty()) {
      std::cout << "  Description: " << found->description << '\n';
    }
    std::cout << "  Constraints:\n";
    if (found->read_only) {
      std::cout << "    Read only: true\n";
    }
    if (found->floating_point_range) {
      print_range(*found->floating_point_range);
    } else if (found->integer_range) {
      print_range(*found->integer_range);
    }
    if (!found->additional_constraints.empty()) {
      std::cout << "    Additional constraints: " << found->additional_constraints << '\n';
    }
  }
  return kExitOk;
}

int dump(Session& session, const ParamOptions& options) {
  const auto node = session.find_node(options.node);
  const auto names = list_names(session, node, {});
  const auto values = get_values(session, node, names);
  if (values.size() != names.size()) {
    throw CommandError("the parameters of " + node.fully_qualified() +
                       " changed while they were read");
  }
  std::vector<NamedParameter> parameters;
  for (std::size_t i = 0; i < names.size(); ++i) {
    parameters.push_back({names[i], values[i]});
  }
  std::cout << dump_parameter_yaml(node.fully_qualified(), parameters);
  return kExitOk;
}

}  // namespace

void add_param_commands(CLI::App& app, Action& action) {
  auto* group = app.add_subcommand("param", "Parameters of nodes");
  group->require_subcommand(1);
  const auto add = [&](const char* name, const char* description,
                       int (*body)(Session&, const ParamOptions&)) {
    return add_session_command<ParamOptions>(*group, action, name, description, true, body);
  };
  using Body = int (*)(Session&, const ParamOptions&);
  constexpr const char* kNode = "Name of the node";

  auto [list_command, list_options] = add("list", "List the parameters of a node, or of all", list);
  list_command->add_option("node", list_options->node, kNode);
  list_command->add_option("--param-prefixes", list_options->names,
                           "Only parameters with these prefixes");
  list_command->add_flag("--param-type", list_options->flag, "Print the types too");
  list_command->add_flag("-a,--include-hidden-nodes", list_options->hidden, "Hidden nodes too");

  auto [get_command, get_options] = add("get", "Print the value of a parameter", get);
  get_command->add_option("node", get_options->node, kNode)->required();
  get_command->add_option("parameter", get_options->name, "Name of the parameter")->required();
  get_command->add_flag("--hide-type", get_options->flag, "Print only the value");

  add_param_changes(*group, action);

  auto [describe_command, describe_options] =
      add("describe", "Describe parameters", static_cast<Body>(describe));
  describe_command->add_option("node", describe_options->node, kNode)->required();
  describe_command->add_option("parameters", describe_options->names,
                               "Names of the parameters; none: all");

  auto [dump_command, dump_options] = add("dump", "Print all parameters of a node as YAML", dump);
  dump_command->add_option("node", dump_options->node, kNode)->required();
}

}  // namespace pipescout::host
