// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/logger.hpp"

#include <spdlog/logger.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/ansicolor_sink.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <mutex>
#include <utility>

namespace pipescout {

namespace {

spdlog::level::level_enum spdlog_level(LogSeverity severity) noexcept {
  switch (severity) {
    case LogSeverity::kDebug:
      return spdlog::level::debug;
    case LogSeverity::kInfo:
      return spdlog::level::info;
    case LogSeverity::kWarn:
      return spdlog::level::warn;
    case LogSeverity::kError:
      return spdlog::level::err;
    case LogSeverity::kFatal:
      return spdlog::level::critical;
  }
  return spdlog::level::info;
}

LogSeverity severity_of(spdlog::level::level_enum level) noexcept {
  switch (level) {
    case spdlog::level::trace:
    case spdlog::level::debug:
      return LogSeverity::kDebug;
    case spdlog::level::warn:
      return LogSeverity::kWarn;
    case spdlog::level::err:
      return LogSeverity::kError;
    case spdlog::level::critical:
      return LogSeverity::kFatal;
    default:
      return LogSeverity::kInfo;
  }
}

/// The severity as ROS 2 writes it; spdlog's own names differ.
class SeverityFlag final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm&,
              spdlog::memory_buf_t& destination) override {
    const std::string_view text = to_string(severity_of(message.level));
    destination.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<SeverityFlag>();
  }
};

/// One for the process, so that lines of different nodes and threads do not mix. Colours only where
/// the stream is a terminal.
std::shared_ptr<spdlog::sinks::sink> standard_error() {
  static const auto sink = [] {
    auto made = std::make_shared<spdlog::sinks::ansicolor_stderr_sink_mt>();
    auto formatter = std::make_unique<spdlog::pattern_formatter>();
    formatter->add_flag<SeverityFlag>('*').set_pattern("%^[%*] [%E.%F] [%n]: %v%$");
    made->set_formatter(std::move(formatter));
    made->set_color(spdlog::level::debug, made->green);
    made->set_color(spdlog::level::info, made->reset);
    made->set_color(spdlog::level::warn, made->yellow);
    made->set_color(spdlog::level::err, made->red);
    made->set_color(spdlog::level::critical, made->red_bold);
    return made;
  }();
  return sink;
}

}  // namespace

const char* to_string(LogSeverity severity) noexcept {
  switch (severity) {
    case LogSeverity::kDebug:
      return "DEBUG";
    case LogSeverity::kInfo:
      return "INFO";
    case LogSeverity::kWarn:
      return "WARN";
    case LogSeverity::kError:
      return "ERROR";
    case LogSeverity::kFatal:
      return "FATAL";
  }
  return "UNKNOWN";
}

std::optional<LogSeverity> log_severity(std::string_view name) {
  std::string upper(name);
  std::transform(upper.begin(), upper.end(), upper.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  for (const auto severity : {LogSeverity::kDebug, LogSeverity::kInfo, LogSeverity::kWarn,
                              LogSeverity::kError, LogSeverity::kFatal}) {
    if (upper == to_string(severity)) {
      return severity;
    }
  }
  return std::nullopt;
}

struct Logger::State {
  explicit State(std::string name) : console(std::move(name), standard_error()) {
    console.set_level(spdlog::level::trace);  // `threshold` decides, for both sinks
  }

  spdlog::logger console;
  std::atomic<LogSeverity> threshold{LogSeverity::kInfo};
  std::mutex mutex;
  std::shared_ptr<const Sink> sink;
};

Logger::Logger(std::string name) : state_(std::make_shared<State>(std::move(name))) {}

void Logger::log(LogSeverity severity, std::string_view text, const Location& where) const {
  if (severity < state_->threshold.load(std::memory_order_relaxed)) {
    return;
  }
  state_->console.log(spdlog_level(severity), spdlog::string_view_t(text.data(), text.size()));
  std::shared_ptr<const Sink> sink;
  {
    const std::lock_guard lock(state_->mutex);
    sink = state_->sink;
  }
  // Outside the lock: a sink may log itself.
  if (sink) {
    (*sink)(severity, std::string(text), where);
  }
}

void Logger::set_threshold(LogSeverity severity) {
  state_->threshold.store(severity, std::memory_order_relaxed);
}

LogSeverity Logger::threshold() const {
  return state_->threshold.load(std::memory_order_relaxed);
}

void Logger::set_sink(Sink sink) {
  auto shared = sink ? std::make_shared<const Sink>(std::move(sink)) : nullptr;
  const std::lock_guard lock(state_->mutex);
  state_->sink.swap(shared);
}

const std::string& Logger::name() const {
  return state_->console.name();
}

}  // namespace pipescout
