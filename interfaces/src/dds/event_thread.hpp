// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
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

  /// Events run in the order of their posting.
  void post(const void* owner, std::function<void()> event);

  /// Drops the pending events of the owner; returns once none of them is running, at once when
  /// called by such an event itself.
  void cancel(const void* owner);

 private:
  struct Event {
    const void* owner;
    std::function<void()> call;
  };

  void run();

  std::mutex mutex_;
  std::condition_variable posted_;
  std::condition_variable finished_;
  std::deque<Event> pending_;
  const void* running_ = nullptr;  // owner of the event in progress
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace pipescout::dds
