// SPDX-License-Identifier: Apache-2.0
#include "logger_services.hpp"

#include <array>
#include <optional>
#include <string>

namespace pipescout {
namespace {

using rcl_interfaces::msg::LoggerLevel;
using rcl_interfaces::msg::SetLoggerLevelsResult;
using rcl_interfaces::srv::GetLoggerLevels;
using rcl_interfaces::srv::SetLoggerLevels;

std::optional<LogSeverity> severity_of(std::uint32_t level) {
  for (const auto severity : {LogSeverity::kDebug, LogSeverity::kInfo, LogSeverity::kWarn,
                              LogSeverity::kError, LogSeverity::kFatal}) {
    if (level == static_cast<std::uint32_t>(severity)) {
      return severity;
    }
  }
  return std::nullopt;
}

SetLoggerLevelsResult set_level(Logger logger, const LoggerLevel& wanted) {
  SetLoggerLevelsResult result;
  const auto severity = severity_of(wanted.level);
  if (wanted.name != logger.name()) {
    result.reason = "there is no logger '" + wanted.name + "' here, but '" + logger.name() + "'";
  } else if (!severity) {
    result.reason = "unknown level " + std::to_string(wanted.level) +
                    ": 10 (debug), 20 (info), 30 (warn), 40 (error) or 50 (fatal)";
  } else {
    logger.set_threshold(*severity);
    result.successful = true;
  }
  return result;
}

}  // namespace

LoggerServices::LoggerServices(Node& node)
    : get_(node.create_service<GetLoggerLevels>(
          "~/get_logger_levels",
          [logger = node.logger()](const GetLoggerLevels::Request& request,
                                   GetLoggerLevels::Response& response) {
            for (const auto& name : request.names) {
              LoggerLevel level;
              level.name = name;
              if (name == logger.name()) {
                level.level = static_cast<std::uint32_t>(logger.threshold());
              }
              response.levels.push_back(std::move(level));
            }
          },
          {.managed = false})),
      set_(node.create_service<SetLoggerLevels>(
          "~/set_logger_levels",
          [logger = node.logger()](const SetLoggerLevels::Request& request,
                                   SetLoggerLevels::Response& response) {
            for (const auto& level : request.levels) {
              response.results.push_back(set_level(logger, level));
            }
          },
          {.managed = false})) {}

}  // namespace pipescout
