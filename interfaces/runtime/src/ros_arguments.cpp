// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/ros_arguments.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace pipescout {
namespace {

constexpr std::string_view kAssignment = ":=";

/// Why an argument that rcl knows is refused; nothing for all others.
std::optional<std::string_view> refusal_of(std::string_view argument) {
  constexpr std::string_view kAlwaysOnRosout =
      "messages are always published on /rosout; select them with --log-level";
  constexpr std::string_view kAlwaysOnStderr =
      "messages are always written to the standard error stream; select them with --log-level, or "
      "redirect the stream";
  constexpr std::string_view kNoLogFiles =
      "there are no log files; redirect the standard error stream, or record /rosout";
  constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kRefused{
      {{"--disable-rosout-logs", kAlwaysOnRosout},
       {"--disable-stdout-logs", kAlwaysOnStderr},
       {"--disable-external-lib-logs", kNoLogFiles},
       {"--enable-external-lib-logs", kNoLogFiles},
       {"--log-config-file", kNoLogFiles}}};
  for (const auto& [name, why] : kRefused) {
    if (argument == name) {
      return why;
    }
  }
  return std::nullopt;
}

class Parser {
 public:
  explicit Parser(const std::vector<std::string>& arguments) : arguments_(arguments) {}

  RosArguments parse() {
    bool of_ros = false;
    while (next_ < arguments_.size()) {
      const std::string& argument = arguments_[next_++];
      if (argument == "--ros-args") {
        of_ros = true;
      } else if (of_ros && argument == "--") {
        of_ros = false;
      } else if (of_ros) {
        take(argument);
      } else {
        result_.others.push_back(argument);
      }
    }
    result_.parameters = ParameterFile(std::move(parameters_));
    return std::move(result_);
  }

 private:
  void take(const std::string& argument) {
    if (argument == "-r" || argument == "--remap") {
      take_remapping(argument, value_of(argument, "a rule FROM:=TO"));
    } else if (argument == "-p" || argument == "--param") {
      take_parameter(argument, value_of(argument, "NAME:=VALUE"));
    } else if (argument == "--params-file") {
      take_parameter_file(argument, value_of(argument, "the name of a file"));
    } else if (argument == "--log-level") {
      take_log_level(argument, value_of(argument, "[LOGGER:=]LEVEL"));
    } else if (argument == "-e" || argument == "--enclave") {
      result_.enclave = value_of(argument, "the name of an enclave");
    } else if (const auto why = refusal_of(argument)) {
      throw RosArgumentError(argument + " is not supported: " + std::string(*why));
    } else if (argument != "--enable-rosout-logs" && argument != "--enable-stdout-logs") {
      throw RosArgumentError("'" + argument + "' is not an argument of --ros-args");
    }
  }

  /// The word behind an argument, whatever it looks like.
  const std::string& value_of(const std::string& argument, const std::string& what) {
    if (next_ == arguments_.size()) {
      throw RosArgumentError(argument + " needs " + what + " behind it");
    }
    return arguments_[next_++];
  }

  void take_remapping(const std::string& argument, const std::string& rule) {
    try {
      result_.remap_rules.push_back(RemapRule::parse(rule));
    } catch (const InvalidName& error) {
      throw RosArgumentError(argument + " " + rule + ": " + error.what());
    }
  }

  void take_parameter(const std::string& argument, const std::string& text) {
    const std::string source = argument + " " + text;
    try {
      auto rule = ParameterRule::parse(text, source);
      parameters_.push_back({.pattern = rule.node.empty() ? "/**" : "/" + rule.node,
                             .source = source,
                             .parameters = {std::move(rule.parameter)}});
    } catch (const std::invalid_argument& error) {
      throw RosArgumentError(source + ": " + error.what());
    }
  }

  void take_parameter_file(const std::string& argument, const std::string& path) {
    try {
      const auto file = load_parameter_yaml(path);
      parameters_.insert(parameters_.end(), file.nodes().begin(), file.nodes().end());
    } catch (const YamlError& error) {
      throw RosArgumentError(argument + ": " + error.what());
    }
  }

  void take_log_level(const std::string& argument, const std::string& text) {
    const auto separator = text.find(kAssignment);
    const bool names_logger = separator != std::string::npos;
    const auto level = names_logger ? text.substr(separator + kAssignment.size()) : text;
    const auto severity = log_severity(level);
    if (!severity) {
      throw RosArgumentError(argument + " " + text + ": '" + level +
                             "' is not one of debug, info, warn, error, fatal");
    }
    if (names_logger && separator == 0) {
      throw RosArgumentError(argument + " " + text +
                             ": the name of a logger is missing before ':='");
    }
    result_.log_levels.push_back({names_logger ? text.substr(0, separator) : "", *severity});
  }

  const std::vector<std::string>& arguments_;
  std::size_t next_ = 0;
  std::vector<NodeParameters> parameters_;
  RosArguments result_;
};

}  // namespace

std::optional<LogSeverity> RosArguments::log_threshold(std::string_view logger) const {
  while (true) {
    const auto rule = std::find_if(log_levels.rbegin(), log_levels.rend(),
                                   [&](const LogLevelRule& one) { return one.logger == logger; });
    if (rule != log_levels.rend()) {
      return rule->severity;
    }
    if (logger.empty()) {
      return std::nullopt;
    }
    const auto dot = logger.rfind('.');
    logger = logger.substr(0, dot == std::string_view::npos ? 0 : dot);
  }
}

RosArguments parse_ros_arguments(const std::vector<std::string>& arguments) {
  return Parser(arguments).parse();
}

RosArguments parse_ros_arguments(int argc, const char* const* argv) {
  return parse_ros_arguments(argc > 1 ? std::vector<std::string>(argv + 1, argv + argc)
                                      : std::vector<std::string>());
}

}  // namespace pipescout
