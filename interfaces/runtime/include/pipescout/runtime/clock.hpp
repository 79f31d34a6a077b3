// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "pipescout/runtime/executor.hpp"
#include "pipescout/runtime/time.hpp"

namespace pipescout {

/// Source of ROS time for a component. Thread-safe.
class Clock {
 public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual Time now() const = 0;
  /// True when `/clock`, not the system clock, drives the time.
  [[nodiscard]] virtual bool is_simulated() const noexcept = 0;
};

/// The clock of the operating system.
class SystemClock final : public Clock {
 public:
  [[nodiscard]] Time now() const override;
  [[nodiscard]] bool is_simulated() const noexcept override { return false; }
};

/// A clock that stays at zero until it is set, by `/clock` or a test.
class SimulatedClock final : public Clock {
 public:
  [[nodiscard]] Time now() const override;
  [[nodiscard]] bool is_simulated() const noexcept override { return true; }

  /// Moves the time, forwards or backwards. Work that became due is scheduled in the order of its
  /// times; a jump backwards schedules all waiting work, so that timers can start again from the
  /// new time.
  void set(Time now);
  /// The same from one of several redundant sources, such as the subscriptions of one topic: while
  /// the first source exists, the others are ignored. Otherwise they would make the time jump back
  /// and forth.
  void set_from(const std::shared_ptr<const void>& source, Time now);
  /// Calls `set_back` when the time is set to an earlier one, before any work is scheduled for
  /// that, on the thread that sets it; it must return soon. Until the returned handle is gone.
  [[nodiscard]] std::shared_ptr<void> on_set_back(std::function<void()> set_back);

  /// Schedules `waitable` in `group` once, when this clock reaches `when`. Replaces an earlier call
  /// for the same waitable.
  void schedule_at(Time when, const std::shared_ptr<CallbackGroup>& group,
                   const std::shared_ptr<Waitable>& waitable);
  void cancel(const Waitable* waitable);
  /// The earliest time at which something is scheduled: whoever drives the clock in leaps stops
  /// there, so that no timer is late.
  [[nodiscard]] std::optional<Time> next_due() const;

 private:
  struct Waiting {
    Time when;
    std::uint64_t order = 0;  // of scheduling: decides between equal times
    std::weak_ptr<CallbackGroup> group;
    std::weak_ptr<Waitable> waitable;
  };
  mutable std::mutex mutex_;
  Time now_{};
  std::weak_ptr<const void> source_;
  std::uint64_t last_order_ = 0;
  std::map<const Waitable*, Waiting> waiting_;
  std::vector<std::weak_ptr<std::function<void()>>> set_back_;
};

}  // namespace pipescout
