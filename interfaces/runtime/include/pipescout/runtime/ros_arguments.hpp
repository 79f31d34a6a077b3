// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/runtime/logger.hpp"
#include "pipescout/runtime/names.hpp"
#include "pipescout/runtime/parameter_yaml.hpp"

namespace pipescout {

/// An invalid argument; what() names it and gives the reason.
class RosArgumentError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// `[LOGGER:=]LEVEL` of `--log-level`.
struct LogLevelRule {
  std::string logger;  ///< "robot_1.fusion"; empty: every logger without another rule
  LogSeverity severity = LogSeverity::kInfo;

  bool operator==(const LogLevelRule&) const = default;
};

/// The content of `--ros-args` on a command line.
struct RosArguments {
  RemapRules remap_rules;
  /// From all `--params-file` and `-p` in the given order, so that the last value of a parameter is
  /// used. The source of a value from `-p` begins with "-p " or "--param ".
  ParameterFile parameters;
  std::vector<LogLevelRule> log_levels;  ///< in the order given
  std::optional<std::string> enclave;    ///< of the last `-e`
  /// The arguments that are not of ROS, without the program's name.
  std::vector<std::string> others;

  /// The threshold of a logger, by the rule for its name, else for its nearest ancestor ("a" is an
  /// ancestor of "a.b"), else for all loggers; of several rules for the same name the last one.
  /// Nothing without such a rule.
  [[nodiscard]] std::optional<LogSeverity> log_threshold(std::string_view logger) const;
};

/// Takes the sections `--ros-args ... [--]` out of a command line, as rcl (Humble) does:
///
///     -r, --remap RULE                from:=to, node:from:=to, __node:=name, __ns:=/namespace
///     -p, --param [NODE:]NAME:=VALUE  VALUE is YAML; NODE: only for the node of that name
///     --params-file FILE              parameters of nodes, YAML
///     --log-level [LOGGER:=]LEVEL     debug, info, warn, error or fatal, in any case
///     -e, --enclave ENCLAVE           security enclave
///     --enable-rosout-logs, --enable-stdout-logs    accepted; both are always enabled
///
/// Other arguments of rcl, and unknown ones, are refused with the reason. Reads the parameter
/// files. Throws RosArgumentError.
[[nodiscard]] RosArguments parse_ros_arguments(const std::vector<std::string>& arguments);

/// The same for the arguments of `main`, without argv[0].
[[nodiscard]] RosArguments parse_ros_arguments(int argc, const char* const* argv);

}  // namespace pipescout
