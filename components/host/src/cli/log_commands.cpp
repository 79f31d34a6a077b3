// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <iostream>
#include <rcl_interfaces/srv/get_logger_levels.hpp>
#include <rcl_interfaces/srv/set_logger_levels.hpp>

#include "cli/session.hpp"

namespace pipescout::host {
namespace {

using rcl_interfaces::srv::GetLoggerLevels;
using rcl_interfaces::srv::SetLoggerLevels;

struct Level {
  const char* name;
  LogSeverity severity;
};
constexpr std::array<Level, 5> kLevels{{{"debug", LogSeverity::kDebug},
                                        {"info", LogSeverity::kInfo},
                                        {"warn", LogSeverity::kWarn},
                                        {"error", LogSeverity::kError},
                                        {"fatal", LogSeverity::kFatal}}};

struct LogLevelOptions {
  DiscoveryOptions discovery;
  std::string node;
  std::string level;
};

/// The node, once it is known to serve `service`. Throws CommandError.
NodeName find_logging_node(Session& session, const std::string& name, const char* service,
                           const char* type) {
  const auto node = session.find_node(name);
  if (!session.wait_for([&] { return session.serves(node, service, type); })) {
    throw CommandError(node.fully_qualified() +
                       " does not let its log level be changed: it has no service ~/" + service +
                       ", which nodes of ROS 2 have from Iron on, where asked for");
  }
  return node;
}

int get(Session& session, const LogLevelOptions& options) {
  const auto node = find_logging_node(session, options.node, "get_logger_levels",
                                      "rcl_interfaces/srv/GetLoggerLevels");
  GetLoggerLevels::Request request;
  request.names = {logger_of(node)};
  const auto response =
      session.call<GetLoggerLevels>(node.fully_qualified() + "/get_logger_levels", request);
  if (response->levels.size() != 1) {
    throw CommandError("the node gave " + std::to_string(response->levels.size()) +
                       " levels instead of one");
  }
  const auto level = response->levels.front().level;
  const auto* const known = std::find_if(
      kLevels.begin(), kLevels.end(),
      [level](const Level& each) { return static_cast<std::uint32_t>(each.severity) == level; });
  std::cout << (known != kLevels.end() ? known->name : "unset") << '\n';
  return kExitOk;
}

int set(Session& session, const LogLevelOptions& options) {
  const auto node = find_logging_node(session, options.node, "set_logger_levels",
                                      "rcl_interfaces/srv/SetLoggerLevels");
  const auto* const wanted = std::find_if(kLevels.begin(), kLevels.end(), [&](const Level& each) {
    return options.level == each.name;
  });
  SetLoggerLevels::Request request;
  request.levels.resize(1);
  request.levels[0].name = logger_of(node);
  request.levels[0].level = static_cast<std::uint32_t>(wanted->severity);
  const auto response =
      session.call<SetLoggerLevels>(node.fully_qualified() + "/set_logger_levels", request);
  if (response->results.size() != 1 || !response->results[0].successful) {
    throw CommandError("Setting the log level failed" +
                       (response->results.size() == 1 ? ": " + response->results[0].reason : ""));
  }
  std::cout << "Set log level of " << node.fully_qualified() << " to " << options.level << '\n';
  return kExitOk;
}

}  // namespace

void add_log_commands(CLI::App& app, Action& action) {
  auto* const log = app.add_subcommand("log", "Logs of nodes");
  log->require_subcommand(1);
  auto* const level = log->add_subcommand("level", "From which level on a node logs");
  level->require_subcommand(1);
  const auto [get_command, get_options] =
      add_session_command<LogLevelOptions>(*level, action, "get", "Print it", true, get);
  get_command->add_option("node", get_options->node, "Name of the node")->required();
  const auto [set_command, set_options] = add_session_command<LogLevelOptions>(
      *level, action, "set", "Change it while the node runs", true, set);
  set_command->add_option("node", set_options->node, "Name of the node")->required();
  std::vector<std::string> names;
  for (const auto& each : kLevels) {
    names.emplace_back(each.name);
  }
  set_command->add_option("level", set_options->level, "debug, info, warn, error or fatal")
      ->required()
      ->check(CLI::IsMember(names));
}

}  // namespace pipescout::host
