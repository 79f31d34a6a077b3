// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "pipescout/runtime/time.hpp"

namespace pipescout::host {

/// The main thread's loop: waits for file descriptors, posted work and a time; never polls.
class EventLoop {
 public:
  /// Throws std::system_error.
  EventLoop();
  EventLoop(const EventLoop&) = delete;
  EventLoop& operator=(const EventLoop&) = delete;
  ~EventLoop();

  /// Calls `ready` on the loop while the descriptor is readable or closed by its peer.
  void watch(int fd, std::function<void()> ready);
  void unwatch(int fd);
  /// Runs work on the loop. Thread-safe.
  void post(std::function<void()> work);
  /// Called on each turn; returns when the next turn is due at the latest.
  void on_turn(std::function<std::optional<SteadyTime>(SteadyTime now)> turn);

  /// Runs until `done` holds, asked after each event; false when the deadline comes first.
  bool run_until(const std::function<bool()>& done, std::optional<SteadyTime> deadline = {});

 private:
  void take_posted();

  int wake_ = -1;
  std::map<int, std::function<void()>> watched_;
  std::function<std::optional<SteadyTime>(SteadyTime)> turn_;
  std::mutex mutex_;
  std::vector<std::function<void()>> posted_;
};

}  // namespace pipescout::host
