// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/clock.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

namespace pipescout {

Duration from_seconds(double seconds) noexcept {
  if (std::isnan(seconds)) {
    return Duration::zero();
  }
  const double nanoseconds = std::round(seconds * 1e9);
  // 2^63 is exact in double; the largest int64 is not.
  constexpr double kLimit = 9223372036854775808.0;
  if (nanoseconds >= kLimit) {
    return Duration::max();
  }
  if (nanoseconds < -kLimit) {
    return Duration::min();
  }
  return Duration(static_cast<Duration::rep>(nanoseconds));
}

Time SystemClock::now() const {
  return std::chrono::time_point_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now());
}

Time SimulatedClock::now() const {
  const std::lock_guard lock(mutex_);
  return now_;
}

void SimulatedClock::set(Time now) {
  std::vector<Waiting> due;
  std::vector<std::shared_ptr<std::function<void()>>> told;
  {
    const std::lock_guard lock(mutex_);
    const bool backwards = now < now_;
    now_ = now;
    if (backwards) {
      for (const auto& weak : set_back_) {
        if (auto callback = weak.lock()) {
          told.push_back(std::move(callback));
        }
      }
    }
    for (auto entry = waiting_.begin(); entry != waiting_.end();) {
      if (backwards || entry->second.when <= now) {
        due.push_back(std::move(entry->second));
        entry = waiting_.erase(entry);
      } else {
        ++entry;
      }
    }
  }
  for (const auto& callback : told) {
    (*callback)();
  }
  std::sort(due.begin(), due.end(), [](const Waiting& a, const Waiting& b) {
    return std::tie(a.when, a.order) < std::tie(b.when, b.order);
  });
  for (const auto& work : due) {
    const auto group = work.group.lock();
    auto waitable = work.waitable.lock();
    if (group && waitable) {
      group->schedule(std::move(waitable));
    }
  }
}

void SimulatedClock::set_from(const std::shared_ptr<const void>& source, Time now) {
  {
    const std::lock_guard lock(mutex_);
    const auto first = source_.lock();
    if (first && first != source) {
      return;
    }
    source_ = source;
  }
  set(now);
}

std::shared_ptr<void> SimulatedClock::on_set_back(std::function<void()> set_back) {
  auto callback = std::make_shared<std::function<void()>>(std::move(set_back));
  const std::lock_guard lock(mutex_);
  std::erase_if(set_back_, [](const auto& weak) { return weak.expired(); });
  set_back_.push_back(callback);
  return callback;
}

void SimulatedClock::schedule_at(Time when, const std::shared_ptr<CallbackGroup>& group,
                                 const std::shared_ptr<Waitable>& waitable) {
  {
    const std::lock_guard lock(mutex_);
    if (when > now_) {
      waiting_.insert_or_assign(waitable.get(), Waiting{when, ++last_order_, group, waitable});
      return;
    }
    waiting_.erase(waitable.get());
  }
  group->schedule(waitable);
}

std::optional<Time> SimulatedClock::next_due() const {
  std::optional<Time> next;
  const std::lock_guard lock(mutex_);
  for (const auto& [waitable, work] : waiting_) {
    if (!work.waitable.expired() && (!next || work.when < *next)) {
      next = work.when;
    }
  }
  return next;
}

void SimulatedClock::cancel(const Waitable* waitable) {
  const std::lock_guard lock(mutex_);
  waiting_.erase(waitable);
}

}  // namespace pipescout
