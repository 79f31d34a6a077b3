// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "pipescout/command_line/command.hpp"

namespace pipescout::host {

class Session;

/// What the command line asks for, and what there is to do it with.
struct Action : command_line::Action {
  using command_line::Action::operator=;

  std::vector<std::string> words;  ///< of the command line
  /// The session of the daemon, when it is the daemon that is asked; else commands join the network
  /// themselves.
  Session* resident = nullptr;
};

using command_line::CommandError;
using command_line::CommandInterrupted;
using command_line::count_range;
using command_line::kExitError;
using command_line::kExitOk;
using command_line::kExitUsage;

// Each adds its commands to `app`. Parsing one of them sets `action`.
void add_run_command(CLI::App& app, Action& action);
void add_component_commands(CLI::App& app, Action& action);
void add_topic_commands(CLI::App& app, Action& action);
void add_interface_commands(CLI::App& app, Action& action);
void add_node_commands(CLI::App& app, Action& action);
void add_param_commands(CLI::App& app, Action& action);
void add_lifecycle_commands(CLI::App& app, Action& action);
void add_service_commands(CLI::App& app, Action& action);
void add_log_commands(CLI::App& app, Action& action);
void add_doctor_command(CLI::App& app, Action& action);
void add_tf_commands(CLI::App& app, Action& action);
void add_action_commands(CLI::App& app, Action& action);
void add_fleet_commands(CLI::App& app, Action& action);
void add_discovery_commands(CLI::App& app, Action& action);
void add_daemon_commands(CLI::App& app, Action& action);

/// All of these.
void add_commands(CLI::App& app, Action& action);

}  // namespace pipescout::host
