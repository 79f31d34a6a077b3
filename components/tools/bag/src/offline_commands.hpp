// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/command_line/command.hpp"

/// The subcommands that only read and write files, with the options of rosbag2 where it has them.
namespace pipescout::bag_command {

void add_info_command(CLI::App& app, command_line::Action& action);
/// reindex, check, recover.
void add_repair_commands(CLI::App& app, command_line::Action& action);
/// convert, filter, merge.
void add_copy_commands(CLI::App& app, command_line::Action& action);
void add_export_command(CLI::App& app, command_line::Action& action);

}  // namespace pipescout::bag_command
