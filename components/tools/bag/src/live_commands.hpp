// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/command_line/command.hpp"

/// The subcommands that take part in the network, with the options of rosbag2.
namespace pipescout::bag_command {

void add_record_command(CLI::App& app, command_line::Action& action);
void add_play_command(CLI::App& app, command_line::Action& action);

}  // namespace pipescout::bag_command
