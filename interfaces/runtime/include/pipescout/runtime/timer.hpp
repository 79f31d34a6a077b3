// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

#include "pipescout/runtime/clock.hpp"
#include "pipescout/runtime/executor.hpp"

namespace pipescout {

/// Calls a function every `period`. Periods that passed while the callback could not run are
/// skipped; the phase is kept. Destroying the handle stops the timer: no call begins afterwards;
/// one may still be running if another thread runs the group's callbacks. Thread-safe, except for
/// moving and destroying.
class Timer {
 public:
  /// `simulated` null: the period is measured by the steady clock. Throws std::invalid_argument
  /// unless the period is positive.
  Timer(std::shared_ptr<CallbackGroup> group, Duration period, std::function<void()> callback,
        std::shared_ptr<SimulatedClock> simulated = nullptr);
  /// A moved-from timer may only be destroyed or assigned to.
  Timer(Timer&&) noexcept;
  Timer& operator=(Timer&&) noexcept;
  ~Timer();

  [[nodiscard]] Duration period() const noexcept;
  /// While disabled nothing is called; enabling starts a new period.
  void set_enabled(bool enabled);
  /// Restarts the period.
  void reset();
  /// Measures the period by another clock from now on, null: the steady clock. Restarts the period.
  void follow(std::shared_ptr<SimulatedClock> simulated);

 private:
  class Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace pipescout
