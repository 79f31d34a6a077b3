// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

namespace pipescout {

/// The levels of diagnostic_msgs/msg/DiagnosticStatus.
enum class DiagnosticLevel : std::uint8_t { kOk = 0, kWarn = 1, kError = 2, kStale = 3 };

/// Health of a component: counters of faults, further values, and one level with a message. The
/// component publishes it on `/diagnostics` once a second and after each change of level.
/// Thread-safe.
class Diagnostics {
 public:
  /// The last status of `set_status`.
  struct Status {
    DiagnosticLevel level = DiagnosticLevel::kOk;
    std::string message;
    bool operator==(const Status&) const = default;
  };
  struct Snapshot {
    DiagnosticLevel level = DiagnosticLevel::kOk;
    std::string message;
    std::map<std::string, std::string> values;
  };

  /// Counts a fault of the input or of the component: "readings.not_a_number". While a counter has
  /// grown since the previous snapshot, the level is at least WARN.
  void count(std::string_view counter, std::uint64_t times = 1);
  void set_value(std::string_view key, std::string value);
  /// Valid until the next call.
  void set_status(DiagnosticLevel level, std::string message);

  [[nodiscard]] Status status() const;
  [[nodiscard]] std::uint64_t counter(std::string_view counter) const;
  /// Returns the state to publish, and starts a new period for the counters. The values contain the
  /// counters; if counters alone cause the level WARN, the message names them.
  [[nodiscard]] Snapshot take();

  /// Calls `callback` when the level differs from that of the last snapshot (initially: OK), at
  /// most once until the next snapshot, on the thread that changed it; it must return soon.
  /// Replaces the callback; an empty one removes it.
  void on_level_changed(std::function<void()> callback);

 private:
  [[nodiscard]] DiagnosticLevel current_level() const;  // under mutex_
  /// The callback, if it has to be called after a change. Under mutex_.
  [[nodiscard]] std::function<void()> notification();

  mutable std::mutex mutex_;
  Status status_;
  std::map<std::string, std::string, std::less<>> values_;
  std::map<std::string, std::uint64_t, std::less<>> counters_;
  std::map<std::string, std::uint64_t, std::less<>> taken_;
  bool counted_ = false;  // a counter has grown since the last snapshot
  DiagnosticLevel taken_level_ = DiagnosticLevel::kOk;
  bool notified_ = false;
  std::function<void()> level_changed_;
};

}  // namespace pipescout
