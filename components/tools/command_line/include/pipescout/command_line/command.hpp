// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <exception>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

/// Common code of the commands of `pipescout`, built in or separate executables (`pipescout-NAME`).
namespace pipescout::command_line {

/// Exit codes, as `ros2` has them.
inline constexpr int kExitOk = 0;
inline constexpr int kExitError = 1;
inline constexpr int kExitUsage = 2;

/// A command failed; what() is shown to the user unchanged.
class CommandError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A signal interrupted the command before its result.
class CommandInterrupted : public std::exception {
 public:
  explicit CommandInterrupted(int signal) : signal_(signal) {}
  [[nodiscard]] int signal() const noexcept { return signal_; }
  [[nodiscard]] const char* what() const noexcept override { return "interrupted"; }

 private:
  int signal_;
};

/// The check of an option that counts something: CLI::PositiveNumber shows its upper end in 309
/// digits when it refuses a value.
[[nodiscard]] CLI::Range count_range();

/// The action of the parsed command line; returns the exit code.
using Action = std::function<int()>;

/// Parses the words behind the program's name and runs what they ask for: `action`, which the
/// callbacks of the (sub)commands of `app` set. Returns the exit code: kExitUsage when the words
/// cannot be parsed or name an unknown subcommand, kExitError when the action throws, 128 + signal
/// when it throws CommandInterrupted. Errors go to stderr. A word such as -1 or -.inf is a value
/// only behind "--", which ends the options of any command.
[[nodiscard]] int run_command(CLI::App& app, const Action& action,
                              const std::vector<std::string>& words);

/// argv as the words behind the program's name.
[[nodiscard]] std::vector<std::string> words_of(int argc, char** argv);

/// The body of `main`: adds the commands of an executable to `app` and runs what argv asks for, or
/// answers a shell that asks how a word can be completed (completion.hpp).
/// Exceptions of `add_commands` are errors like those of actions.
[[nodiscard]] int command_main(
    const std::string& description, const std::string& name,
    const std::function<void(CLI::App& app, Action& action)>& add_commands, int argc, char** argv);

}  // namespace pipescout::command_line
