// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/composition.hpp"
#include "pipescout/runtime/executor_thread.hpp"

namespace pipescout::host {

/// The executors of a process, each on a thread of its own, and whether they still run callbacks.
/// For the main thread.
class Executors {
 public:
  struct Callbacks {
    std::function<void()> on_failure;              ///< on the thread of an executor that failed
    std::function<void(const std::string&)> warn;  ///< on that of one whose priority is refused
  };

  explicit Executors(Callbacks callbacks) : callbacks_(std::move(callbacks)) {}
  Executors(const Executors&) = delete;
  Executors& operator=(const Executors&) = delete;
  ~Executors() { stop(); }

  /// An executor that does not spin yet. `name` is for messages. The reference stays valid.
  Executor& add(std::string name, const ExecutorSettings& settings);
  /// Lets all spin that were added.
  void start();
  /// Ends the threads, once their callbacks have returned.
  void stop();

  /// One of them failed. Then nothing that is left to do in it will happen.
  [[nodiscard]] bool failed() const;
  [[nodiscard]] std::string failure() const;

  /// Queues a callback in each executor that has answered the one before.
  void ask();
  /// The names of those that have not answered yet: their threads are in callbacks that have not
  /// returned. (One of several threads is enough to answer.)
  [[nodiscard]] std::vector<std::string> silent() const;

 private:
  struct One {
    One(std::string its_name, const ExecutorSettings& its_settings)
        : name(std::move(its_name)),
          settings(its_settings),
          executor(its_settings.threads),
          group(executor.create_callback_group()) {}

    std::string name;
    ExecutorSettings settings;
    Executor executor;
    std::shared_ptr<CallbackGroup> group;  ///< of the questions
    std::atomic<bool> asked = false;
    std::optional<ExecutorThread> thread;
  };

  const Callbacks callbacks_;
  std::deque<One> all_;
};

}  // namespace pipescout::host
