// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>

#include "pipescout/runtime/executor.hpp"
#include "pipescout/runtime/publisher.hpp"
#include "pipescout/runtime/time.hpp"

namespace pipescout {

/// Counts occurrences of something and tells a callback, which is queued at most once however often
/// the event occurs before it runs. After `close` no call begins. Made by make_shared. Thread-safe.
class CountedEvent final : public Waitable, public std::enable_shared_from_this<CountedEvent> {
 public:
  CountedEvent(std::shared_ptr<CallbackGroup> group, std::function<void(EventCount)> callback)
      : group_(std::move(group)), callback_(std::move(callback)) {}

  void add(std::uint64_t occurrences = 1) {
    {
      const std::lock_guard lock(mutex_);
      total_ += occurrences;
      if (!callback_ || closed_ || queued_) {
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
      if (closed_) {
        return;
      }
      count = {total_, total_ - told_};
      told_ = total_;
    }
    callback_(count);
  }

  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
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
  bool closed_ = false;
};

/// Tells a callback the latest of a changing value; values that are overtaken are not told. After
/// `close` no call begins. Made by make_shared. Thread-safe.
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
      if (closed_ || std::exchange(queued_, true)) {
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
      if (closed_) {
        return;
      }
      value = value_;
    }
    callback_(value);
  }

  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }

 private:
  const std::shared_ptr<CallbackGroup> group_;
  const std::function<void(const T&)> callback_;
  std::mutex mutex_;
  T value_{};
  bool queued_ = false;
  bool closed_ = false;
};

/// Tells of a QoS mismatch and how many there were.
class IncompatibleQosEvent {
 public:
  IncompatibleQosEvent(const std::shared_ptr<CallbackGroup>& group,
                       const std::function<void(const IncompatibleQos&)>& callback)
      : policy_(std::make_shared<std::atomic<QosPolicy>>(QosPolicy::kReliability)) {
    std::function<void(EventCount)> told;
    if (callback) {
      told = [callback, policy = policy_](EventCount count) { callback({count, *policy}); };
    }
    count_ = std::make_shared<CountedEvent>(group, std::move(told));
  }

  void add(QosPolicy policy) {
    *policy_ = policy;
    count_->add();
  }
  [[nodiscard]] std::uint64_t total() const { return count_->total(); }
  void close() { count_->close(); }

 private:
  std::shared_ptr<std::atomic<QosPolicy>> policy_;
  std::shared_ptr<CountedEvent> count_;
};

/// Tells `on_lapse` when nobody called `touch` for `period`; starts with the first touch. The
/// period is measured on the steady clock, and the lapse is noticed by the group's executor. Made
/// by make_shared. Thread-safe.
class Watchdog final : public Waitable, public std::enable_shared_from_this<Watchdog> {
 public:
  enum class Lapse {
    kOnce,        ///< told once; the next touch starts it again
    kEachPeriod,  ///< told again for each further period without a touch
  };

  /// `on_lapse` gets the number of periods that passed since it was told last.
  Watchdog(std::shared_ptr<CallbackGroup> group, Duration period, Lapse lapse,
           std::function<void(std::uint64_t)> on_lapse)
      : group_(std::move(group)), period_(period), lapse_(lapse), on_lapse_(std::move(on_lapse)) {}

  /// Returns true when the watchdog had lapsed or stopped, or is touched for the first time.
  bool touch() {
    const std::lock_guard lock(mutex_);
    last_ = steady_now();
    if (armed_) {
      return false;
    }
    armed_ = true;
    arm();
    return true;
  }

  void stop() {
    const std::lock_guard lock(mutex_);
    armed_ = false;
    group_->cancel(shared_from_this());
  }

  [[nodiscard]] bool is_armed() const {
    const std::lock_guard lock(mutex_);
    return armed_;
  }

  void execute() override {
    std::uint64_t periods = 1;
    {
      const std::lock_guard lock(mutex_);
      if (!armed_) {
        return;
      }
      const SteadyTime time = steady_now();
      if (time < add_saturated(last_, period_)) {
        arm();
        return;
      }
      if (lapse_ == Lapse::kEachPeriod) {
        const auto passed = (time - last_) / period_;
        last_ += passed * period_;
        periods = static_cast<std::uint64_t>(passed);
        arm();
      } else {
        armed_ = false;
      }
    }
    on_lapse_(periods);
  }

 private:
  void arm() { group_->schedule_at(add_saturated(last_, period_), shared_from_this()); }

  const std::shared_ptr<CallbackGroup> group_;
  const Duration period_;
  const Lapse lapse_;
  const std::function<void(std::uint64_t)> on_lapse_;
  mutable std::mutex mutex_;
  SteadyTime last_{};
  bool armed_ = false;
};

}  // namespace pipescout
