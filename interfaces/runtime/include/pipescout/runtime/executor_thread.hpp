// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "pipescout/runtime/executor.hpp"

namespace pipescout {

/// Spins an executor on a separate thread until this object is destroyed. Components handle their
/// exceptions; one that still leaves the executor ends the thread and is stored as `failure`. The
/// member functions are thread-safe.
class ExecutorThread {
 public:
  struct Callbacks {
    /// Called on the thread before it spins; further threads of the executor are created by it and
    /// inherit its priority. Must not throw.
    std::function<void()> before = nullptr;
    /// Called on the thread after a failure.
    std::function<void()> on_failure = nullptr;
  };

  /// `executor` must outlive this object, and must not spin elsewhere.
  ExecutorThread(Executor& executor, Callbacks callbacks);
  ExecutorThread(const ExecutorThread&) = delete;
  ExecutorThread& operator=(const ExecutorThread&) = delete;
  /// Returns once the running callbacks have returned.
  ~ExecutorThread();

  [[nodiscard]] bool failed() const noexcept { return failed_; }
  /// The reason; empty unless `failed()`.
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
