// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iostream>
#include <memory>
#include <set>
#include <stdexcept>

#include "cli/command.hpp"
#include "cli/message_text.hpp"
#include "core/interfaces.hpp"
#include "core/ros2_export.hpp"

namespace pipescout::host {
namespace {

struct InterfaceOptions {
  std::string name;
  std::string folder;
  bool only_messages = false;
  bool only_services = false;
  bool only_actions = false;
  bool no_quotes = false;
  ShowOptions show;

  /// Without any of the three options all are wanted.
  [[nodiscard]] bool wants(InterfaceKind kind) const {
    if (!only_messages && !only_services && !only_actions) {
      return true;
    }
    return kind == InterfaceKind::kMessage   ? only_messages
           : kind == InterfaceKind::kService ? only_services
                                             : only_actions;
  }
};

int list_interfaces(const InterfaceOptions& options) {
  constexpr std::pair<InterfaceKind, const char*> kGroups[] = {
      {InterfaceKind::kMessage, "Messages:"},
      {InterfaceKind::kService, "Services:"},
      {InterfaceKind::kAction, "Actions:"}};
  const auto names = known_interfaces();
  for (const auto& [kind, title] : kGroups) {
    if (!options.wants(kind)) {
      continue;
    }
    std::cout << title << '\n';
    for (const auto& name : names) {
      if (name.kind == kind) {
        std::cout << "    " << name.text() << '\n';
      }
    }
  }
  return kExitOk;
}

int list_packages(const InterfaceOptions& options) {
  std::set<std::string> packages;
  for (const auto& name : known_interfaces()) {
    if (options.wants(name.kind)) {
      packages.insert(name.package);
    }
  }
  for (const auto& package : packages) {
    std::cout << package << '\n';
  }
  return kExitOk;
}

int list_package(const InterfaceOptions& options) {
  bool found = false;
  for (const auto& name : known_interfaces()) {
    if (name.package == options.name) {
      found = true;
      std::cout << name.text() << '\n';
    }
  }
  if (!found) {
    throw CommandError("Unknown package '" + options.name + "'");
  }
  return kExitOk;
}

/// The name that the user gave. Throws CommandError.
InterfaceName named(const std::string& text) {
  try {
    return parse_interface_name(text);
  } catch (const std::invalid_argument& error) {
    throw CommandError(error.what());
  }
}

int show(const InterfaceOptions& options) {
  try {
    std::cout << show_interface(named(options.name), options.show);
  } catch (const MessageTypeError& error) {
    throw CommandError("Could not find the interface '" + options.name + "': " + error.what());
  }
  return kExitOk;
}

/// What `topic pub`, `service call` and `action send_goal` take, with all defaults.
int prototype(const InterfaceOptions& options) {
  const MessageType* type = nullptr;
  try {
    type = parts_of(named(options.name)).front();
  } catch (const MessageTypeError& error) {
    throw CommandError("Could not find the interface '" + options.name + "': " + error.what());
  }
  const auto message = type->create();
  const char* const quote = options.no_quotes ? "" : "\"";
  std::cout << quote << to_yaml({type, message.get()}, {.truncate = std::nullopt}) << quote << '\n';
  return kExitOk;
}

int export_package(const InterfaceOptions& options) {
  try {
    const auto exported = export_to_ros2(options.name, options.folder);
    std::cout << exported.folder.string() << ": " << exported.interfaces << " interfaces";
    const char* separator = "; uses ";
    for (const auto& dependency : exported.dependencies) {
      std::cout << separator << dependency;
      separator = ", ";
    }
    std::cout << '\n';
  } catch (const ExportError& error) {
    throw CommandError(error.what());
  } catch (const MessageTypeError& error) {
    throw CommandError(error.what());
  }
  return kExitOk;
}

CLI::App* add(CLI::App& group, Action& action, const char* name, const char* description,
              const std::shared_ptr<InterfaceOptions>& options,
              int (*body)(const InterfaceOptions&)) {
  auto* const command = group.add_subcommand(name, description);
  command->callback(
      [options, body, &action] { action = [options, body] { return body(*options); }; });
  return command;
}

void add_kinds(CLI::App& command, InterfaceOptions& options) {
  command.add_flag("-m,--only-msgs", options.only_messages, "Messages");
  command.add_flag("-s,--only-srvs", options.only_services, "Services");
  command.add_flag("-a,--only-actions", options.only_actions, "Actions");
}

}  // namespace

void add_interface_commands(CLI::App& app, Action& action) {
  auto* const group = app.add_subcommand("interface", "Messages, services and actions");
  group->require_subcommand(1);
  const auto options = std::make_shared<InterfaceOptions>();
  add_kinds(*add(*group, action, "list", "List all of them", options, list_interfaces), *options);
  add_kinds(
      *add(*group, action, "packages", "List the packages with interfaces", options, list_packages),
      *options);
  add(*group, action, "package", "List the interfaces of a package", options, list_package)
      ->add_option("package", options->name, "Name of the package")
      ->required();
  auto* const show_command = add(*group, action, "show", "Show a definition", options, show);
  show_command->add_option("type", options->name, "Such as std_msgs/msg/Header")->required();
  auto* const all = show_command->add_flag("--all-comments", options->show.all_comments,
                                           "Show the comments of nested messages too");
  show_command->add_flag("--no-comments", options->show.no_comments, "Show no comments")
      ->excludes(all);
  auto* const proto =
      add(*group, action, "proto", "Print a message with its defaults as YAML", options, prototype);
  proto->add_option("type", options->name, "Such as std_msgs/msg/Header")->required();
  proto->add_flag("--no-quotes", options->no_quotes, "Without quotes around");
  auto* const exporting =
      add(*group, action, "export", "Write a package for ROS 2", options, export_package);
  exporting->add_option("package", options->name, "Name of the package")->required();
  exporting
      ->add_option(
          "--ros2", options->folder,
          "Folder of a ROS 2 workspace; the package is written to a subfolder with its name")
      ->required();
}

}  // namespace pipescout::host
