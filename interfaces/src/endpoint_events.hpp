// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <utility>

#include "pipescout/interfaces/executor.hpp"
#include "pipescout/interfaces/publisher.hpp"

namespace pipescout {

/// Counts occurrences of something and tells a callback, which is queued at most once however often
/// the event occurs before it runs. Made by make_shared. Thread-safe.
class CountedEvent final : public Waitable, public std::enable_shared_from_this<CountedEvent> {
 public:
  CountedEvent(std::shared_ptr<CallbackGroup> group, std::function<void(EventCount)> callback)
      : group_(std::move(group)), callback_(std::move(callback)) {}

  void add(std::uint64_t occurrences = 1) {
    {
      const std::lock_guard lock(mutex_);
      total_ += occurrences;
      if (!callback_ || queued_) {
        return;
      }
      queued_ = true;
    }
    group_->schedule(shared_from_this());
  }

  void execute() override {
    EventCount count;
    {
      const std::lock_guard lock(mutex_);
      queued_ = false;
      count = {total_, total_ - told_};
      told_ = total_;
    }
    callback_(count);
  }

  [[nodiscard]] std::uint64_t total() const {
    const std::lock_guard lock(mutex_);
    return total_;
  }

 private:
  const std::shared_ptr<CallbackGroup> group_;
  const std::function<void(EventCount)> callback_;
  mutable std::mutex mutex_;
  std::uint64_t total_ = 0;
  std::uint64_t told_ = 0;
  bool queued_ = false;
};

/// Tells a callback the latest of a changing value; values that are overtaken are not told.
template <class T>
class LatestEvent final : public Waitable, public std::enable_shared_from_this<LatestEvent<T>> {
 public:
  LatestEvent(std::shared_ptr<CallbackGroup> group, std::function<void(const T&)> callback)
      : group_(std::move(group)), callback_(std::move(callback)) {}

  void set(T value) {
    if (!callback_) {
      return;
    }
    {
      const std::lock_guard lock(mutex_);
      value_ = std::move(value);
      if (std::exchange(queued_, true)) {
        return;
      }
    }
    group_->schedule(this->shared_from_this());
  }

  void execute() override {
    T value;
    {
      const std::lock_guard lock(mutex_);
      queued_ = false;
      value = value_;
    }
    callback_(value);
  }

 private:
  const std::shared_ptr<CallbackGroup> group_;
  const std::function<void(const T&)> callback_;
  std::mutex mutex_;
  T value_{};
  bool queued_ = false;
};

/// Runs `on_lapse` when nobody called `touch` for `period`; again after each further period if
/// `repeat`. Starts with the first touch. The period is measured on the steady clock, and the lapse
/// is noticed by the group's executor. Made by make_shared. Thread-safe.
class Watchdog final : public Waitable, public std::enable_shared_from_this<Watchdog> {
 public:
  Watchdog(std::shared_ptr<CallbackGroup> group, Duration period, bool repeat,
           std::function<void()> on_lapse)
      : group_(std::move(group)),
        period_(period),
        repeat_(repeat),
        on_lapse_(std::move(on_lapse)) {}

  /// Returns true when the watchdog had lapsed, or is touched for the first time.
  bool touch() {
    const std::lock_guard lock(mutex_);
    last_ = now();
    if (armed_) {
      return false;
    }
    armed_ = true;
    group_->schedule_at(last_ + period_, shared_from_this());
    return true;
  }

  void stop() {
    const std::lock_guard lock(mutex_);
    armed_ = false;
    group_->cancel(shared_from_this());
  }

  void execute() override {
    {
      const std::lock_guard lock(mutex_);
      if (!armed_) {
        return;
      }
      const SteadyTime due = last_ + period_;
      if (now() < due) {
        group_->schedule_at(due, shared_from_this());
        return;
      }
      if (repeat_) {
        last_ = due;
        group_->schedule_at(last_ + period_, shared_from_this());
      } else {
        armed_ = false;
      }
    }
    on_lapse_();
  }

 private:
  static SteadyTime now() {
    return std::chrono::time_point_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now());
  }

  const std::shared_ptr<CallbackGroup> group_;
  const Duration period_;
  const bool repeat_;
  const std::function<void()> on_lapse_;
  std::mutex mutex_;
  SteadyTime last_{};
  bool armed_ = false;
};

}  // namespace pipescout
