// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "pipescout/runtime/executor.hpp"

namespace pipescout::host {

/// An executor that spins on a thread of its own. Components catch their own exceptions; one that
/// leaves the executor all the same ends the spinning and is kept as `failure`.
class Spinner {
 public:
  /// `on_failure` is called on that thread.
  Spinner(Executor& executor, std::function<void()> on_failure)
      : executor_(executor), thread_([this, on_failure = std::move(on_failure)] {
          try {
            executor_.spin();
            return;
          } catch (const std::exception& error) {
            keep(error.what());
          } catch (...) {
            keep("an exception of unknown type");
          }
          on_failure();
        }) {}
  Spinner(const Spinner&) = delete;
  Spinner& operator=(const Spinner&) = delete;
  ~Spinner() {
    executor_.stop();
    thread_.join();
  }

  [[nodiscard]] bool failed() const noexcept { return failed_; }
  [[nodiscard]] std::string failure() const {
    const std::lock_guard lock(mutex_);
    return failure_;
  }

 private:
  void keep(const char* what) {
    {
      const std::lock_guard lock(mutex_);
      failure_ = std::string("a callback of the process failed: ") + what;
    }
    failed_ = true;
  }

  Executor& executor_;
  mutable std::mutex mutex_;
  std::string failure_;
  std::atomic<bool> failed_ = false;
  std::thread thread_;
};

}  // namespace pipescout::host
