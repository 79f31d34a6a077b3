// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/timer.hpp"

#include <algorithm>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>

namespace pipescout {

class Timer::Impl final : public Waitable, public std::enable_shared_from_this<Timer::Impl> {
 public:
  Impl(std::shared_ptr<CallbackGroup> group, Duration period, std::function<void()> callback,
       std::shared_ptr<SimulatedClock> simulated)
      : group_(std::move(group)),
        period_(period),
        callback_(std::move(callback)),
        simulated_(std::move(simulated)) {}

  void execute() override {
    {
      const std::lock_guard lock(mutex_);
      if (!enabled_) {
        return;
      }
      const Time now = read();
      if (now < next_) {
        // Simulated time jumped back, or the timer was reset after this work was queued.
        next_ = std::min(next_, add_saturated(now, period_));
        arm();
        return;
      }
      next_ = add_saturated(next_, (now - next_) / period_ * period_);
      next_ = add_saturated(next_, period_);
      arm();
    }
    callback_();
  }

  void set_enabled(bool enabled) {
    const std::lock_guard lock(mutex_);
    if (enabled == enabled_) {
      return;
    }
    enabled_ = enabled;
    if (enabled) {
      restart();
    } else {
      disarm();
    }
  }

  void reset() {
    const std::lock_guard lock(mutex_);
    if (enabled_) {
      restart();
    }
  }

  void follow(std::shared_ptr<SimulatedClock> simulated) {
    const std::lock_guard lock(mutex_);
    if (simulated == simulated_) {
      return;
    }
    if (enabled_) {
      disarm();
    }
    simulated_ = std::move(simulated);
    if (enabled_) {
      restart();
    }
  }

  Duration period() const noexcept { return period_; }

 private:
  // Steady time is kept as `Time` too; the epochs of the two never meet.
  Time read() const {
    return simulated_ ? simulated_->now() : Time(steady_now().time_since_epoch());
  }
  void restart() {
    next_ = add_saturated(read(), period_);
    arm();
  }
  void arm() {
    if (simulated_) {
      simulated_->schedule_at(next_, group_, shared_from_this());
    } else {
      group_->schedule_at(SteadyTime(next_.time_since_epoch()), shared_from_this());
    }
  }
  void disarm() {
    if (simulated_) {
      simulated_->cancel(this);
    } else {
      group_->cancel(shared_from_this());
    }
  }

  const std::shared_ptr<CallbackGroup> group_;
  const Duration period_;
  const std::function<void()> callback_;
  std::mutex mutex_;
  std::shared_ptr<SimulatedClock> simulated_;  // null: the steady clock
  bool enabled_ = false;
  Time next_{};
};

Timer::Timer(std::shared_ptr<CallbackGroup> group, Duration period, std::function<void()> callback,
             std::shared_ptr<SimulatedClock> simulated) {
  if (period <= Duration::zero()) {
    throw std::invalid_argument("timer period = " + std::to_string(period.count()) +
                                " ns is not positive");
  }
  impl_ =
      std::make_shared<Impl>(std::move(group), period, std::move(callback), std::move(simulated));
  impl_->set_enabled(true);
}

Timer::Timer(Timer&&) noexcept = default;

Timer& Timer::operator=(Timer&& other) noexcept {
  Timer replaced(std::move(*this));
  impl_ = std::move(other.impl_);
  return *this;
}

Timer::~Timer() {
  if (impl_) {
    impl_->set_enabled(false);
  }
}

Duration Timer::period() const noexcept {
  return impl_->period();
}
void Timer::set_enabled(bool enabled) {
  impl_->set_enabled(enabled);
}
void Timer::follow(std::shared_ptr<SimulatedClock> simulated) {
  impl_->follow(std::move(simulated));
}
void Timer::reset() {
  impl_->reset();
}

}  // namespace pipescout
