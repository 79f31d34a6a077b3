// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "pipescout/runtime/executor.hpp"

namespace pipescout {

/// An executor that spins on a thread of its own until this object goes. Components catch their own
/// exceptions; one that leaves the executor all the same ends the spinning and is kept as
/// `failure`. The member functions are thread-safe.
class ExecutorThread {
 public:
  struct Callbacks {
    /// Called on the thread before it spins; the further threads of the executor are made by it and
    /// take its priority over. Must not throw.
    std::function<void()> before = nullptr;
    /// Called on the thread when the spinning failed.
    std::function<void()> on_failure = nullptr;
  };

  /// `executor` must outlive this object, and nobody else may let it spin.
  ExecutorThread(Executor& executor, Callbacks callbacks);
  ExecutorThread(const ExecutorThread&) = delete;
  ExecutorThread& operator=(const ExecutorThread&) = delete;
  /// Returns once the running callbacks have returned.
  ~ExecutorThread();

  [[nodiscard]] bool failed() const noexcept { return failed_; }
  /// Why; empty unless `failed()`.
  [[nodiscard]] std::string failure() const;

 private:
  void run(const Callbacks& callbacks);
  void keep(const char* what);

  Executor& executor_;
  mutable std::mutex mutex_;
  std::string failure_;
  std::atomic<bool> failed_ = false;
  std::thread thread_;
};

}  // namespace pipescout
