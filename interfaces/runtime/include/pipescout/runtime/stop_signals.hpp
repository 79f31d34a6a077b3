// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <thread>

#include "pipescout/runtime/time.hpp"

namespace pipescout {

/// SIGINT, SIGTERM and SIGHUP as calls on a thread of its own, where any code is safe. The first
/// one asks the program to end; the second ends it at once, and so does time: a program that was
/// asked to end and has not done so in time is ended with a message.
class StopSignals {
 public:
  /// Keeps the signals from every thread. Call first of all, before a thread exists.
  static void block();

  /// `on_stop` is called once, with the first signal. `before_forced_end` is called before the
  /// program is ended by force. Throws std::system_error.
  StopSignals(Duration grace, std::function<void(int signal)> on_stop,
              std::function<void()> before_forced_end);
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;
  ~StopSignals();

  /// The program ends by itself: from now on it has the time of grace. Thread-safe.
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
