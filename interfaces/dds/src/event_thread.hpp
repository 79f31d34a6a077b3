// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <thread>

namespace pipescout::dds {

/// Delivers matching, liveliness and graph events from one thread that holds no lock of Fast DDS.
/// Fast DDS itself reports them while it holds its discovery locks, and some from the thread that
/// creates an endpoint; a listener that takes a lock of its own there would deadlock against a
/// thread that holds it while it creates, destroys or writes.
class EventThread {
 public:
  EventThread();
  EventThread(const EventThread&) = delete;
  EventThread& operator=(const EventThread&) = delete;
  /// Drops what is pending. Must not run on the event thread.
  ~EventThread();

  /// From now on events of this owner are taken. What the owner's thread did before is seen by
  /// them.
  void admit(const void* owner);

  /// Events run in the order of their posting; that of an owner who is not admitted is dropped.
  void post(const void* owner, std::function<void()> event);
  /// The same, once the time is over.
  void post_after(const void* owner, std::chrono::nanoseconds delay, std::function<void()> event);

  /// Takes no more events of the owner and drops the pending ones; returns once none of them is
  /// running, at once when called by such an event itself.
  void dismiss(const void* owner);

 private:
  struct Event {
    const void* owner;
    std::function<void()> call;
  };

  void run();
  void collect_due();  // under mutex_

  std::mutex mutex_;
  std::condition_variable posted_;
  std::condition_variable finished_;
  std::set<const void*> owners_;
  std::deque<Event> pending_;
  std::multimap<std::chrono::steady_clock::time_point, Event> timed_;
  const void* running_ = nullptr;  // owner of the event in progress
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace pipescout::dds
