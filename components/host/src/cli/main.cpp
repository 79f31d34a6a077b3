// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

#include "cli/command.hpp"
#include "cli/completion_names.hpp"
#include "cli/external_commands.hpp"
#include "pipescout/command_line/completion.hpp"
#include "pipescout/command_line/suggestion.hpp"

namespace pipescout::host {
namespace {

constexpr const char* kHelp = "help";
// For environment/completion.bash alone, as kComplete: the names of a kind.
constexpr const char* kNames = "__names";
using command_line::kComplete;

/// A value such as -1 or -.inf, which is no option.
bool is_negative_number(const std::string& text) {
  return text.size() > 1 && text[0] == '-' &&
         ((text[1] >= '0' && text[1] <= '9') || text[1] == '.');
}

/// The words after the program's name in the form that the commands know.
std::vector<std::string> plain_words(std::vector<std::string> words) {
  const bool options_ended = std::find(words.begin(), words.end(), "--") != words.end();
  if (words.size() > 2 && words[0] == "param" && words[1] == "set" && !options_ended &&
      is_negative_number(words.back())) {
    words.insert(words.end() - 1, "--");
  }
  // "help topic echo" is "topic echo --help".
  if (!words.empty() && words[0] == kHelp) {
    words.erase(words.begin());
    words.emplace_back("--help");
  }
  return words;
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const auto* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

bool has_command(const CLI::App& app, const std::string& name) {
  const auto names = command_names(app);
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// For the list of commands and for what is near to a misspelt one.
void add_external_commands(CLI::App& app, const ExternalCommandPlaces& places) {
  for (const auto& command : list_external_commands(places)) {
    if (!has_command(app, command.name)) {
      app.add_subcommand(command.name,
                         command.summary.empty() ? command.executable.string() : command.summary)
          ->group("Subcommands from other packages (executables pipescout-NAME)");
    }
  }
}

/// Prints what a shell offers for the last word: "__complete -- topic ec".
int print_completions(CLI::App& app, std::vector<std::string> words) {
  words.erase(words.begin(), words.begin() + std::min<std::ptrdiff_t>(2, std::ssize(words)));
  if (words.size() > 1 && words.front() == kHelp) {
    words.erase(words.begin());
  }
  if (words.size() <= 1) {
    add_external_commands(app, external_command_places());
  } else if (!has_command(app, words.front())) {
    const auto command = find_external_command(words.front(), external_command_places());
    if (command && command->completes) {
      words.front() = "--";
      words.insert(words.begin(), kComplete);
      become(*command, words);
    }
    return kExitOk;
  }
  auto completion = command_line::complete(app, words);
  if (!completion.kind.empty()) {
    const auto names =
        command_line::beginning_with(words.back(), completion_names(completion.kind));
    completion.words.insert(completion.words.end(), names.begin(), names.end());
  }
  for (const auto& word : completion.words) {
    std::cout << word << '\n';
  }
  return kExitOk;
}

int print_names(const std::vector<std::string>& words) {
  for (const auto& name : completion_names(words.size() > 1 ? words[1] : "")) {
    std::cout << name << '\n';
  }
  return kExitOk;
}

/// Those whose packages are not built, as "reproduce (pipescout_reproduce)".
std::string commands_not_built(const CLI::App& app) {
  std::string list;
  for (const auto& command : project_commands()) {
    if (!has_command(app, std::string(command.name))) {
      list += (list.empty() ? "" : ", ") + std::string(command.name) + " (" +
              std::string(command.package) + ")";
    }
  }
  return list;
}

/// What to say of a command that is not there.
std::string unknown_command(const CLI::App& app, const std::string& name) {
  for (const auto& command : project_commands()) {
    if (command.name == name) {
      const std::string package(command.package);
      return "unknown command '" + name + "': it comes with the package " + package +
             ", which is not built here. In the root of the project: colcon build "
             "--packages-up-to " +
             package;
    }
  }
  auto names = command_names(app);
  for (const auto& command : project_commands()) {
    names.emplace_back(command.name);
  }
  const auto near = command_line::suggestion(name, names);
  return "unknown command '" + name + "'" +
         (near.empty() ? ": no executable pipescout-" + name +
                             " is in bin/ or lib/PACKAGE/ of AMENT_PREFIX_PATH and "
                             "CMAKE_PREFIX_PATH, or in PATH."
                       : near) +
         " Run with --help for the list of commands.";
}

int run(const std::vector<std::string>& words) {
  CLI::App app("Pipescout: runs compositions of robot components, and inspects running ones",
               "pipescout");
  app.set_version_flag("--version", PIPESCOUT_VERSION);
  app.require_subcommand(1);
  Action action;
  action.words = words;
  add_commands(app, action);
  app.add_subcommand(kHelp, "Show the help of a command: help COMMAND");
  if (!words.empty() && words.front() == kComplete) {
    return print_completions(app, words);
  }
  if (!words.empty() && words.front() == kNames) {
    return print_names(words);
  }
  if (words.empty() || words.front().starts_with('-')) {
    add_external_commands(app, external_command_places());
    if (const auto missing = commands_not_built(app); !missing.empty()) {
      app.footer("Subcommands whose packages are not built: " + missing);
    }
  } else if (!has_command(app, words.front())) {
    const auto places = external_command_places();
    if (const auto command = find_external_command(words.front(), places)) {
      become(*command, {words.begin() + 1, words.end()});
    }
    add_external_commands(app, places);
    std::cerr << unknown_command(app, words.front()) << '\n';
    return kExitUsage;
  }
  return command_line::run_command(app, action, words);
}

}  // namespace

void add_commands(CLI::App& app, Action& action) {
  add_run_command(app, action);
  add_component_commands(app, action);
  add_topic_commands(app, action);
  add_interface_commands(app, action);
  add_node_commands(app, action);
  add_param_commands(app, action);
  add_lifecycle_commands(app, action);
  add_service_commands(app, action);
  add_log_commands(app, action);
  add_doctor_command(app, action);
  add_tf_commands(app, action);
  add_action_commands(app, action);
  add_fleet_commands(app, action);
  add_discovery_commands(app, action);
  add_daemon_commands(app, action);
}

}  // namespace pipescout::host

int main(int argc, char** argv) {
  using namespace pipescout;  // NOLINT(google-build-using-namespace): of this function alone
  try {
    return host::run(host::plain_words(command_line::words_of(argc, argv)));
  } catch (const command_line::CommandError& error) {
    std::cerr << error.what() << '\n';
  } catch (const std::exception& error) {
    std::cerr << "error: " << error.what() << '\n';
  }
  return command_line::kExitError;
}
