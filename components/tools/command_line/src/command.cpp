// SPDX-License-Identifier: Apache-2.0
#include "pipescout/command_line/command.hpp"

#include <iostream>

#include "pipescout/command_line/suggestion.hpp"

namespace pipescout::command_line {
namespace {

/// What to say when the words name a command that does not exist; empty when they do.
std::string unknown_command(const CLI::App& app, const std::vector<std::string>& words) {
  const CLI::App* group = &app;
  for (const auto& word : words) {
    const auto commands = group->get_subcommands([](const CLI::App*) { return true; });
    if (word.starts_with('-') || commands.empty()) {
      break;
    }
    std::vector<std::string> names;
    const CLI::App* chosen = nullptr;
    for (const auto* command : commands) {
      names.push_back(command->get_name());
      chosen = command->get_name() == word ? command : chosen;
    }
    if (chosen == nullptr) {
      return "unknown command '" + word + "'" + suggestion(word, names) +
             " Run with --help for the list of commands.";
    }
    group = chosen;
  }
  return "";
}

}  // namespace

CLI::Range count_range() {
  return {1, 1000000000};
}

std::vector<std::string> words_of(int argc, char** argv) {
  return argc > 1 ? std::vector<std::string>(argv + 1, argv + argc) : std::vector<std::string>();
}

int run_command(CLI::App& app, const Action& action, const std::vector<std::string>& words) {
  if (const auto problem = unknown_command(app, words); !problem.empty()) {
    std::cerr << problem << '\n';
    return kExitUsage;
  }
  try {
    // CLI11 takes the last word first.
    app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
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

int command_main(const std::string& description, const std::string& name,
                 const std::function<void(CLI::App& app, Action& action)>& add_commands, int argc,
                 char** argv) {
  try {
    CLI::App app(description, name);
    Action action;
    add_commands(app, action);
    return run_command(app, action, words_of(argc, argv));
  } catch (const std::exception& error) {
    std::cerr << "error: " << error.what() << '\n';
    return kExitError;
  }
}

}  // namespace pipescout::command_line
