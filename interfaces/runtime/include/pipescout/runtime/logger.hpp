// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <source_location>
#include <string>
#include <string_view>

namespace pipescout {

/// The levels of rcl_interfaces/msg/Log.
enum class LogSeverity : std::uint8_t {
  kDebug = 10,
  kInfo = 20,
  kWarn = 30,
  kError = 40,
  kFatal = 50
};

[[nodiscard]] const char* to_string(LogSeverity severity) noexcept;

/// "debug", "info", "warn", "error" or "fatal", in any case; nothing for another text.
[[nodiscard]] std::optional<LogSeverity> log_severity(std::string_view name);

/// Writes a node's messages to the standard error stream ("[WARN] [1718.123456789] [robot.fusion]:
/// text") and, once connected, to `/rosout`. Thread-safe; copies share the state.
class Logger {
 public:
  using Location = std::source_location;
  /// Receives messages at or above the threshold, with their source location.
  using Sink = std::function<void(LogSeverity, const std::string& text, const Location& where)>;

  /// `name`: as in ROS 2, the fully qualified node name with dots: "robot_1.odometry_fusion".
  explicit Logger(std::string name);

  void log(LogSeverity severity, std::string_view text,
           const Location& where = Location::current()) const;
  void debug(std::string_view text, const Location& where = Location::current()) const {
    log(LogSeverity::kDebug, text, where);
  }
  void info(std::string_view text, const Location& where = Location::current()) const {
    log(LogSeverity::kInfo, text, where);
  }
  void warn(std::string_view text, const Location& where = Location::current()) const {
    log(LogSeverity::kWarn, text, where);
  }
  void error(std::string_view text, const Location& where = Location::current()) const {
    log(LogSeverity::kError, text, where);
  }
  void fatal(std::string_view text, const Location& where = Location::current()) const {
    log(LogSeverity::kFatal, text, where);
  }

  /// Messages below it are dropped. Default: info.
  void set_threshold(LogSeverity severity);
  [[nodiscard]] LogSeverity threshold() const;
  /// Replaces the second sink (`/rosout`); an empty one removes it.
  void set_sink(Sink sink);
  [[nodiscard]] const std::string& name() const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace pipescout
