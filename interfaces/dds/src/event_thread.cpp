// SPDX-License-Identifier: Apache-2.0
#include "event_thread.hpp"

#include <utility>

#include "contain.hpp"

namespace pipescout::dds {

EventThread::EventThread() : thread_([this] { run(); }) {}

EventThread::~EventThread() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  posted_.notify_one();
  thread_.join();
}

void EventThread::admit(const void* owner) {
  const std::lock_guard lock(mutex_);
  owners_.insert(owner);
}

void EventThread::post(const void* owner, std::function<void()> event) {
  {
    const std::lock_guard lock(mutex_);
    if (!owners_.contains(owner)) {
      return;
    }
    pending_.push_back({owner, std::move(event)});
  }
  posted_.notify_one();
}

void EventThread::post_after(const void* owner, std::chrono::nanoseconds delay,
                             std::function<void()> event) {
  {
    const std::lock_guard lock(mutex_);
    if (!owners_.contains(owner)) {
      return;
    }
    timed_.emplace(std::chrono::steady_clock::now() + delay, Event{owner, std::move(event)});
  }
  posted_.notify_one();
}

void EventThread::dismiss(const void* owner) {
  std::unique_lock lock(mutex_);
  owners_.erase(owner);
  std::erase_if(pending_, [owner](const Event& event) { return event.owner == owner; });
  std::erase_if(timed_, [owner](const auto& entry) { return entry.second.owner == owner; });
  if (std::this_thread::get_id() != thread_.get_id()) {
    finished_.wait(lock, [&] { return running_ != owner; });
  }
}

void EventThread::collect_due() {
  const auto now = std::chrono::steady_clock::now();
  while (!timed_.empty() && timed_.begin()->first <= now) {
    pending_.push_back(std::move(timed_.begin()->second));
    timed_.erase(timed_.begin());
  }
}

void EventThread::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    collect_due();
    if (stop_) {
      return;
    }
    if (pending_.empty()) {
      if (timed_.empty()) {
        posted_.wait(lock);
      } else {
        const auto due = timed_.begin()->first;  // the entry may go meanwhile
        posted_.wait_until(lock, due);
      }
      continue;
    }
    Event event = std::move(pending_.front());
    pending_.pop_front();
    running_ = event.owner;
    lock.unlock();
    contain("an event", event.call);
    event.call = nullptr;  // what it holds goes before the owner is told that it ended
    lock.lock();
    running_ = nullptr;
    finished_.notify_all();
  }
}

}  // namespace pipescout::dds
