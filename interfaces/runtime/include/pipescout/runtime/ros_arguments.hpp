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

/// An argument cannot be used; what() names it and says why.
class RosArgumentError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// `[LOGGER:=]LEVEL` of `--log-level`.
struct LogLevelRule {
  std::string logger;  ///< "robot_1.fusion"; empty: every logger that no other rule names
  LogSeverity severity = LogSeverity::kInfo;

  bool operator==(const LogLevelRule&) const = default;
};

/// What stands behind `--ros-args` on a command line.
struct RosArguments {
  RemapRules remap_rules;
  /// Of all `--params-file` and `-p` in the order given, so that of two values for a parameter the
  /// later counts. What `-p` gives has a source that begins with "-p " or "--param ".
  ParameterFile parameters;
  std::vector<LogLevelRule> log_levels;  ///< in the order given
  std::optional<std::string> enclave;    ///< of the last `-e`
  /// The arguments that are not of ROS, without the program's name.
  std::vector<std::string> others;

  /// The threshold of a logger, by the rule of its name, else of the nearest name above it ("a" is
  /// above "a.b"), else of all loggers; the last one of those for the same name. Nothing without
  /// such a rule.
  [[nodiscard]] std::optional<LogSeverity> log_threshold(std::string_view logger) const;
};

/// Takes the sections `--ros-args ... [--]` out of a command line, as rcl (Humble) does:
///
///     -r, --remap RULE                `from:=to`, `node:from:=to`, `__node:=name`,
///     `__ns:=/namespace` -p, --param [NODE:]NAME:=VALUE  VALUE is YAML; NODE: only for the node of
///     that name
///     --params-file FILE              parameters of nodes, YAML
///     --log-level [LOGGER:=]LEVEL     debug, info, warn, error or fatal, in any case
///     -e, --enclave ENCLAVE           security enclave
///     --enable-rosout-logs, --enable-stdout-logs    which is so in any case
///
/// What rcl takes beyond these is refused with the reason, as is what it does not know. Reads the
/// parameter files. Throws RosArgumentError.
[[nodiscard]] RosArguments parse_ros_arguments(const std::vector<std::string>& arguments);

/// The same for what `main` gets, without argv[0].
[[nodiscard]] RosArguments parse_ros_arguments(int argc, const char* const* argv);

}  // namespace pipescout
