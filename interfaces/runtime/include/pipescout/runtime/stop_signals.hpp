// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <thread>

#include "pipescout/runtime/time.hpp"

namespace pipescout {

/// Handles SIGINT, SIGTERM and SIGHUP on a dedicated thread, where any code is safe. The first
/// signal requests the end of the program; the second ends it at once. A program that does not end
/// within the grace period is terminated with a message.
class StopSignals {
 public:
  /// Blocks the signals in every thread. Call it first, before another thread exists.
  static void block();

  /// `on_stop` is called once, with the first signal. `before_forced_end` is called before the
  /// program is terminated. Throws std::system_error.
  StopSignals(Duration grace, std::function<void(int signal)> on_stop,
              std::function<void()> before_forced_end);
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;
  ~StopSignals();

  /// The program ends without a signal: starts the grace period. Thread-safe.
  void expect_end();

 private:
  void run();
  [[noreturn]] void end_by_force(int code, const char* why) const;

  Duration grace_;
  std::function<void(int)> on_stop_;
  std::function<void()> before_forced_end_;
  int signals_ = -1;
  int wake_ = -1;
  std::thread thread_;
};

}  // namespace pipescout
