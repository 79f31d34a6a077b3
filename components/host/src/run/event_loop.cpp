// SPDX-License-Identifier: Apache-2.0
#include "run/event_loop.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <ctime>
#include <system_error>
#include <utility>

namespace pipescout::host {

EventLoop::EventLoop() : wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (wake_ < 0) {
    throw std::system_error(errno, std::generic_category(), "eventfd");
  }
}

EventLoop::~EventLoop() {
  close(wake_);
}

void EventLoop::watch(int fd, std::function<void()> ready) {
  watched_[fd] = std::move(ready);
}

void EventLoop::unwatch(int fd) {
  watched_.erase(fd);
}

void EventLoop::post(std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    posted_.push_back(std::move(work));
  }
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = write(wake_, &one, sizeof one);
}

void EventLoop::on_turn(std::function<std::optional<SteadyTime>(SteadyTime)> turn) {
  turn_ = std::move(turn);
}

void EventLoop::take_posted() {
  std::vector<std::function<void()>> work;
  {
    const std::lock_guard lock(mutex_);
    work.swap(posted_);
  }
  for (const auto& item : work) {
    item();
  }
}

bool EventLoop::run_until(const std::function<bool()>& done, std::optional<SteadyTime> deadline) {
  while (true) {
    take_posted();
    const SteadyTime now = steady_now();
    auto wake_at = deadline;
    if (turn_) {
      if (const auto due = turn_(now)) {
        wake_at = wake_at ? std::min(*wake_at, *due) : *due;
      }
    }
    if (done()) {
      return true;
    }
    if (deadline && now >= *deadline) {
      return false;
    }
    std::vector<pollfd> descriptors{{wake_, POLLIN, 0}};
    for (const auto& [fd, ready] : watched_) {
      descriptors.push_back({fd, POLLIN, 0});
    }
    timespec timeout{};
    if (wake_at) {
      const auto wait = std::max(Duration::zero(), *wake_at - now);
      timeout.tv_sec = std::chrono::duration_cast<std::chrono::seconds>(wait).count();
      timeout.tv_nsec = (wait % std::chrono::seconds(1)).count();
    }
    const int count =
        ppoll(descriptors.data(), descriptors.size(), wake_at ? &timeout : nullptr, nullptr);
    if (count < 0 && errno != EINTR) {
      throw std::system_error(errno, std::generic_category(), "ppoll");
    }
    if (count <= 0) {
      continue;
    }
    if (descriptors.front().revents != 0) {
      std::uint64_t wakes = 0;
      [[maybe_unused]] const auto size = read(wake_, &wakes, sizeof wakes);
    }
    for (std::size_t i = 1; i < descriptors.size(); ++i) {
      // An earlier handler may have ended the watch.
      const auto watch = watched_.find(descriptors[i].fd);
      if (descriptors[i].revents != 0 && watch != watched_.end()) {
        const auto ready = watch->second;
        ready();
      }
    }
  }
}

}  // namespace pipescout::host
