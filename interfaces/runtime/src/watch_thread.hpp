// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <mutex>
#include <thread>

#include "pipescout/runtime/executor.hpp"

namespace pipescout {

/// The thread on which a process notices that a publisher of its own has fallen silent: it does not
/// wait for the callbacks of any component, one of which may be why. Starts when the first group is
/// made, and sleeps until a lease runs out. Thread-safe.
class WatchThread {
 public:
  WatchThread() = default;
  WatchThread(const WatchThread&) = delete;
  WatchThread& operator=(const WatchThread&) = delete;
  /// Not to be called on the thread itself; so what runs there owns nothing that leads here.
  ~WatchThread();

  /// A group whose callbacks run on this thread. They must neither block nor throw.
  [[nodiscard]] std::shared_ptr<CallbackGroup> create_group();

 private:
  Executor executor_;
  std::once_flag started_;
  std::thread thread_;
};

}  // namespace pipescout
