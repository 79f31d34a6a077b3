// SPDX-License-Identifier: Apache-2.0
#include "run/name_guard.hpp"

#include <utility>

namespace pipescout::host {

NameClaim::Pace NameGuard::pace_for(const DdsOptions& options) {
  using std::chrono::milliseconds;
  if (!options.discovery_servers.empty()) {
    // What is lost on the way to or from a server is sent again, within half a second; and each
    // change is told to all its clients.
    return {.period = milliseconds(500), .rounds = 5};
  }
  if (options.localhost_only) {
    // Nothing is lost there; what counts is how soon a busy machine lets the other one answer.
    return {.period = milliseconds(100), .rounds = 8};
  }
  return {};
}

NameGuard::NameGuard(std::shared_ptr<Announcements> announcements, Gid self,
                     const std::vector<NodeName>& names, NameClaim::Pace pace,
                     std::function<void()> changed)
    : announcements_(std::move(announcements)),
      changed_(std::move(changed)),
      claim_(self, names, pace, steady_now()) {
  announcements_->on_heard([this] {
    {
      const std::lock_guard lock(mutex_);
      has_news_ = true;
    }
    wake_.notify_one();
  });
  has_news_ = true;  // what was heard before
  thread_ = std::thread([this] { run(); });
}

NameGuard::~NameGuard() {
  announcements_->on_heard({});
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

NameClaim::State NameGuard::state() const {
  const std::lock_guard lock(mutex_);
  return claim_.state();
}

std::optional<NameClaim::Rival> NameGuard::rival() const {
  const std::lock_guard lock(mutex_);
  return rival_;
}

void NameGuard::run() {
  std::unique_lock lock(mutex_);
  while (!ends_) {
    const auto state = claim_.state();
    const auto rival = rival_;
    if (std::exchange(has_news_, false)) {
      claim_.hear(announcements_->others(), steady_now());
    }
    rival_ = claim_.rival();
    const auto text = claim_.on_time(steady_now());
    const bool has_changed = claim_.state() != state || rival_ != rival;
    if (text || has_changed) {
      // The transport may call on_heard meanwhile, and hold locks that it needs for this.
      lock.unlock();
      if (text) {
        announcements_->say(*text);
      }
      if (has_changed) {
        changed_();
      }
      lock.lock();
      continue;
    }
    const auto is_awake = [this] { return ends_ || has_news_; };
    if (const auto due = claim_.due()) {
      wake_.wait_until(lock, *due, is_awake);
    } else {
      wake_.wait(lock, is_awake);
    }
  }
}

}  // namespace pipescout::host
