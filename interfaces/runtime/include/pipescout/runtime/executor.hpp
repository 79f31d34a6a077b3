// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <exception>
#include <functional>
#include <memory>
#include <string>

#include "pipescout/runtime/time.hpp"

namespace pipescout {

class Activity;
class Executor;

enum class CallbackGroupType {
  kMutuallyExclusive,  ///< at most one callback of the group runs at a time
  kReentrant           ///< callbacks of the group may run at the same time, also the same one
};

/// A source of work: the queue of a subscription, a timer, an event. One object is scheduled at
/// most once per unit of work that it holds.
class Waitable {
 public:
  virtual ~Waitable() = default;
  /// Runs one unit of work on a thread of the executor, or does nothing when there is none.
  virtual void execute() = 0;
};

/// Callbacks with a common rule on concurrency. Created by an executor and run by it. Thread-safe.
class CallbackGroup {
 public:
  /// Called with an exception from a callback, on the thread that ran it. Without a handler the
  /// exception propagates out of `spin`.
  using ExceptionHandler = std::function<void(std::exception_ptr)>;

  virtual ~CallbackGroup() = default;

  [[nodiscard]] virtual CallbackGroupType type() const noexcept = 0;
  virtual void set_exception_handler(ExceptionHandler handler) = 0;

  /// Counts the callbacks of the group as those of `node` in the activity of a process.
  virtual void join(const std::shared_ptr<Activity>& activity, std::string node) = 0;

  /// Queues one unit of work of `waitable`. Wakes the executor.
  virtual void schedule(std::shared_ptr<Waitable> waitable) = 0;
  /// Queues a function.
  virtual void post(std::function<void()> function) = 0;
  /// Schedules the waitable once, when the steady clock reaches `when`. A later call for the same
  /// waitable replaces the earlier one.
  virtual void schedule_at(SteadyTime when, const std::shared_ptr<Waitable>& waitable) = 0;
  virtual void cancel(const std::shared_ptr<Waitable>& waitable) = 0;

  /// Until `release`, work is queued and timers become due, but no callback begins.
  virtual void hold() = 0;
  /// Lets callbacks begin, in the order in which their work arrived.
  virtual void release() = 0;

  /// True when no callback of the group is running. Otherwise `idle` is called once none is: after
  /// the last one, on its thread. It must neither block nor throw.
  virtual bool when_idle(std::function<void()> idle) = 0;

  /// Drops all queued work and refuses new work. Returns once no callback of the group is running,
  /// unless it is called from such a callback: then the group closes when that callback returns.
  virtual void close() = 0;
};

/// Runs callbacks. Threads sleep until work is scheduled or a timer is due; nothing polls.
///
/// With one thread (the default) all callbacks of the executor run one after the other in the order
/// in which their work arrived. With more, groups run concurrently.
class Executor {
 public:
  explicit Executor(std::size_t threads = 1);
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;
  /// Stops. Groups must have been closed, or nobody may use them any more.
  ~Executor();

  [[nodiscard]] std::shared_ptr<CallbackGroup> create_callback_group(
      CallbackGroupType type = CallbackGroupType::kMutuallyExclusive);

  /// Runs callbacks on the calling thread, and on `threads - 1` threads more, until `stop`. Throws
  /// what a callback of a group without exception handler threw, after the other threads ended.
  void spin();
  /// Runs all ready work, and work that becomes ready meanwhile, on the calling thread; never
  /// waits. Returns the number of callbacks that ran. Must not be called during a `spin`.
  std::size_t spin_ready();
  /// Runs callbacks on the calling thread until `done` returns true (checked after each callback)
  /// or the time-out has passed. Returns the last result of `done`. May be called while other
  /// threads are in `spin` or `spin_until`, which run the remaining work.
  bool spin_until(const std::function<bool()>& done, Duration timeout);
  /// Ends every `spin` and `spin_until` in progress once the running callbacks return; when there
  /// is none, the next one returns at once. The executor can then spin again. Thread-safe.
  void stop();

  [[nodiscard]] std::size_t threads() const noexcept;

  class Core;

 private:
  std::shared_ptr<Core> core_;
};

}  // namespace pipescout
