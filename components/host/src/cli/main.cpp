// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include "cli/command.hpp"
#include "core/composition.hpp"

namespace pipescout::host {
namespace {

/// A value such as -1 or -.inf, which is no option.
bool is_negative_number(const std::string& text) {
  return text.size() > 1 && text[0] == '-' &&
         ((text[1] >= '0' && text[1] <= '9') || text[1] == '.');
}

/// The words after the program's name, as CLI11 wants them: last first.
std::vector<std::string> arguments_of(int argc, char** argv) {
  std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() > 2 && words[0] == "param" && words[1] == "set" &&
      is_negative_number(words.back())) {
    words.insert(words.end() - 1, "--");
  }
  return {words.rbegin(), words.rend()};
}

/// What to say when the words name a command that does not exist; empty when they do.
std::string unknown_command(const CLI::App& app, int argc, char** argv) {
  const CLI::App* group = &app;
  for (int i = 1; i < argc && argv[i][0] != '-'; ++i) {
    const auto commands = group->get_subcommands([](const CLI::App*) { return true; });
    if (commands.empty()) {
      break;
    }
    std::vector<std::string> names;
    const CLI::App* chosen = nullptr;
    for (const auto* command : commands) {
      names.push_back(command->get_name());
      chosen = command->get_name() == argv[i] ? command : chosen;
    }
    if (chosen == nullptr) {
      return "unknown command '" + std::string(argv[i]) + "'" + suggestion(argv[i], names) +
             " Run with --help for what there is.";
    }
    group = chosen;
  }
  return "";
}

int run(int argc, char** argv) {
  CLI::App app("Pipescout: runs compositions of robot components, and looks into running ones",
               "pipescout");
  app.set_version_flag("--version", PIPESCOUT_VERSION);
  app.require_subcommand(1);
  Action action;
  add_run_command(app, action);
  add_component_commands(app, action);
  add_topic_commands(app, action);
  add_interface_commands(app, action);
  add_node_commands(app, action);
  add_param_commands(app, action);
  add_lifecycle_commands(app, action);
  add_service_commands(app, action);
  add_summary_command(app, action);
  add_reproduce_command(app, action);
  add_ledger_commands(app, action);
  add_plot_commands(app, action);
  add_inspect_commands(app, action);
  if (const auto problem = unknown_command(app, argc, argv); !problem.empty()) {
    std::cerr << problem << '\n';
    return kExitUsage;
  }
  try {
    app.parse(arguments_of(argc, argv));
  } catch (const CLI::ParseError& error) {
    // Help and version come this way too, with exit code 0.
    return app.exit(error) == 0 ? kExitOk : kExitUsage;
  }
  try {
    const int code = action();
    std::cout.flush();
    return code;
  } catch (const CommandInterrupted& stop) {
    std::cout.flush();
    return 128 + stop.signal();
  } catch (const CommandError& error) {
    std::cout.flush();
    std::cerr << error.what() << '\n';
  } catch (const std::exception& error) {
    std::cout.flush();
    std::cerr << "error: " << error.what() << '\n';
  }
  return kExitError;
}

}  // namespace
}  // namespace pipescout::host

int main(int argc, char** argv) {
  try {
    return pipescout::host::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return pipescout::host::kExitError;
  }
}
