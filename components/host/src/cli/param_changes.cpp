// SPDX-License-Identifier: Apache-2.0
#include "cli/param_changes.hpp"

#include <iostream>
#include <rcl_interfaces/srv/set_parameters.hpp>

#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/parameter_yaml.hpp"

namespace pipescout::host {
namespace {

struct ParamChangeOptions {
  DiscoveryOptions discovery;
  std::string node;
  std::string name;
  std::string value;
  std::string file;
  bool no_wildcard = false;
};

int set(Session& session, const ParamChangeOptions& options) {
  NamedParameter parameter{options.name, {}};
  try {
    parameter.value = parse_parameter_value(options.value);
  } catch (const std::exception& error) {
    throw CommandError(error.what());
  }
  const auto result = set_parameter(session, session.find_node(options.node), parameter);
  const auto reason = result.reason.empty() ? "" : ": " + result.reason;
  if (!result.successful) {
    throw CommandError("Setting parameter failed" + reason);
  }
  std::cout << "Set parameter successful" << reason << '\n';
  return kExitOk;
}

int remove(Session& session, const ParamChangeOptions& options) {
  // A value that is not set undeclares a parameter.
  const auto result = set_parameter(session, session.find_node(options.node), {options.name, {}});
  if (!result.successful) {
    throw CommandError("Deleting parameter failed: " + result.reason);
  }
  std::cout << "Deleted parameter successfully\n";
  return kExitOk;
}

int load(Session& session, const ParamChangeOptions& options) {
  ParameterFile file;
  try {
    file = load_parameter_yaml(options.file);
  } catch (const YamlError& error) {
    throw CommandError(error.what());
  }
  const auto node = session.find_node(options.node);
  const auto name = node.fully_qualified();
  if (options.no_wildcard) {
    auto entries = file.nodes();
    std::erase_if(entries, [&](const NodeParameters& entry) { return entry.pattern != name; });
    file = ParameterFile(std::move(entries));
  }
  const auto parameters = file.overrides_for(name);
  if (parameters.empty()) {
    throw CommandError(options.file + " has no parameters for " + name);
  }
  int code = kExitOk;
  for (const auto& parameter : parameters) {
    const auto result = set_parameter(session, node, {parameter.name, parameter.value});
    const auto reason = result.reason.empty() ? "" : ": " + result.reason;
    if (result.successful) {
      std::cout << "Set parameter " << parameter.name << " successful" << reason << '\n';
    } else {
      std::cerr << parameter.source << ": Set parameter " << parameter.name << " failed" << reason
                << '\n';
      code = kExitError;
    }
  }
  return code;
}

}  // namespace

SetResult set_parameter(Session& session, const NodeName& node, const NamedParameter& parameter) {
  using rcl_interfaces::srv::SetParameters;
  SetParameters::Request request;
  request.parameters = {to_message(parameter)};
  const auto response =
      session.call<SetParameters>(node.fully_qualified() + "/set_parameters", std::move(request));
  if (response->results.size() != 1) {
    throw CommandError("Setting parameter failed: the node gave " +
                       std::to_string(response->results.size()) + " results instead of one");
  }
  return from_message(response->results.front());
}

void add_param_changes(CLI::App& group, Action& action) {
  const auto add = [&](const char* name, const char* description,
                       int (*body)(Session&, const ParamChangeOptions&)) {
    auto added =
        add_session_command<ParamChangeOptions>(group, action, name, description, true, body);
    added.first->add_option("node", added.second->node, "Name of the node")->required();
    return added;
  };
  const auto [set_command, set_options] = add("set", "Set a parameter", set);
  set_command->add_option("parameter", set_options->name, "Name of the parameter")->required();
  set_command->add_option("value", set_options->value, "Its new value, as YAML")->required();

  const auto [delete_command, delete_options] =
      add("delete", "Delete a parameter that the node declared as dynamically typed", remove);
  delete_command->add_option("parameter", delete_options->name, "Name of the parameter")
      ->required();

  const auto [load_command, load_options] = add("load", "Set parameters from a file", load);
  load_command
      ->add_option("file", load_options->file,
                   "Parameter file, as `param dump` of this program or of ros2 writes it")
      ->required();
  load_command->add_flag("--no-use-wildcard", load_options->no_wildcard,
                         "Leave out what the file says for patterns such as /**");
}

}  // namespace pipescout::host
