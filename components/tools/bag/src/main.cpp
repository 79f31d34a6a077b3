// SPDX-License-Identifier: Apache-2.0
#include "live_commands.hpp"
#include "offline_commands.hpp"

int main(int argc, char** argv) {
  return pipescout::command_line::command_main(
      PIPESCOUT_SUMMARY, "pipescout bag",
      [](CLI::App& app, pipescout::command_line::Action& action) {
        app.require_subcommand(1);
        pipescout::bag_command::add_record_command(app, action);
        pipescout::bag_command::add_play_command(app, action);
        pipescout::bag_command::add_info_command(app, action);
        pipescout::bag_command::add_copy_commands(app, action);
        pipescout::bag_command::add_repair_commands(app, action);
        pipescout::bag_command::add_export_command(app, action);
      },
      argc, argv);
}
