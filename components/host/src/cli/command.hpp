// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <exception>
#include <functional>
#include <stdexcept>
#include <string>

namespace pipescout::host {

/// Exit codes, as `ros2` has them.
inline constexpr int kExitOk = 0;
inline constexpr int kExitError = 1;
inline constexpr int kExitUsage = 2;

/// A command cannot do what was asked; what() is shown to the user as it is.
class CommandError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A signal asked the command to end before it had its answer.
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
inline CLI::Range count_range() {
  return {1, 1000000000};
}

/// What the parsed command line asks for; returns the exit code.
using Action = std::function<int()>;

// Each adds its commands to `app`. Parsing one of them sets `action`.
void add_run_command(CLI::App& app, Action& action);
void add_component_commands(CLI::App& app, Action& action);
void add_topic_commands(CLI::App& app, Action& action);
void add_interface_commands(CLI::App& app, Action& action);
void add_node_commands(CLI::App& app, Action& action);
void add_param_commands(CLI::App& app, Action& action);
void add_lifecycle_commands(CLI::App& app, Action& action);
void add_service_commands(CLI::App& app, Action& action);
void add_summary_command(CLI::App& app, Action& action);
void add_reproduce_command(CLI::App& app, Action& action);
void add_ledger_commands(CLI::App& app, Action& action);
void add_plot_commands(CLI::App& app, Action& action);
void add_inspect_commands(CLI::App& app, Action& action);

}  // namespace pipescout::host
