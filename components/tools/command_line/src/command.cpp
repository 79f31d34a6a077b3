// SPDX-License-Identifier: Apache-2.0
#include "pipescout/command_line/command.hpp"

#include <algorithm>
#include <iostream>
#include <sstream>
#include <utility>

#include "pipescout/command_line/completion.hpp"
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

/// Before a word behind "--", so that CLI11 takes it for no option. Of itself CLI11 knows "--" only
/// where the command still lacks an argument.
constexpr char kArgumentMark = '\x01';

std::string unmarked(std::string text) {
  std::erase(text, kArgumentMark);
  return text;
}

/// All arguments of all commands take the mark off their values before anything looks at them.
void accept_marked(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    if (option->get_positional()) {
      option->transform(CLI::Validator(
          [](std::string& value) {
            value = unmarked(value);
            return std::string();
          },
          "", ""));
    }
  }
  for (CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    accept_marked(*command);
  }
}

/// As POSIX has it (utility conventions, guideline 10): the first "--" ends the options and is
/// itself no argument.
std::vector<std::string> with_marks(CLI::App& app, std::vector<std::string> words) {
  const auto end = std::find(words.begin(), words.end(), "--");
  if (end != words.end()) {
    accept_marked(app);
    for (auto word = words.erase(end); word != words.end(); ++word) {
      word->insert(0, 1, kArgumentMark);
    }
  }
  return words;
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
    std::vector<std::string> marked = with_marks(app, words);
    // CLI11 takes the last word first.
    std::reverse(marked.begin(), marked.end());
    app.parse(std::move(marked));
  } catch (const CLI::ParseError& error) {
    // Help and version come this way too, with exit code 0.
    std::ostringstream problem;
    const int code = app.exit(error, std::cout, problem);
    std::cerr << unmarked(problem.str());
    return code == 0 ? kExitOk : kExitUsage;
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
    const auto words = words_of(argc, argv);
    if (!words.empty() && words.front() == kComplete) {
      print_completions(app, words);
      return kExitOk;
    }
    return run_command(app, action, words);
  } catch (const std::exception& error) {
    std::cerr << "error: " << error.what() << '\n';
    return kExitError;
  }
}

}  // namespace pipescout::command_line
