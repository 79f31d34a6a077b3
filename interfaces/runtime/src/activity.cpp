// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/activity.hpp"

#include <algorithm>
#include <utility>

namespace pipescout {

std::uint64_t Activity::look(std::set<std::string>& busy) {
  std::uint64_t arrived = 1;  // a moment is never 0
  std::erase_if(sources_, [](const auto& weak) { return weak.expired(); });
  for (const auto& weak : sources_) {
    if (const auto source = weak.lock()) {
      std::uint64_t units = 0;
      source->look(busy, units);
      arrived += units;
    }
  }
  for (const std::string& node : left_out_) {
    busy.erase(node);
  }
  return arrived;
}

// Sources are looked at one after the other. Work may pass from one that is not looked at yet to
// one that was idle; it has arrived there then, so a second look tells.
Activity::Moment Activity::quiescent_moment() {
  std::set<std::string> busy;
  const std::uint64_t before = look(busy);
  if (!busy.empty()) {
    return 0;
  }
  const std::uint64_t after = look(busy);
  return busy.empty() && before == after ? after : 0;
}

void Activity::when_quiescent(Quiescent quiescent) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(quiescent));
    awaited_ = true;
  }
  check();
}

void Activity::check() {
  std::vector<Quiescent> told;
  Moment moment = 0;
  {
    const std::lock_guard lock(mutex_);
    if (waiting_.empty()) {
      return;
    }
    moment = quiescent_moment();
    if (moment == 0) {
      return;
    }
    told.swap(waiting_);
    awaited_ = false;
  }
  for (const Quiescent& tell : told) {
    tell(moment);
  }
}

bool Activity::is_quiescent_since(Moment moment) {
  const std::lock_guard lock(mutex_);
  return quiescent_moment() == moment;
}

std::set<std::string> Activity::busy_nodes() {
  const std::lock_guard lock(mutex_);
  std::set<std::string> busy;
  look(busy);
  return busy;
}

void Activity::leave_out(const std::string& node) {
  {
    const std::lock_guard lock(mutex_);
    left_out_.insert(node);
  }
  check();
}

void Activity::add(const std::shared_ptr<Source>& source) {
  const std::lock_guard lock(mutex_);
  const auto known = [&](const auto& weak) { return weak.lock() == source; };
  if (std::none_of(sources_.begin(), sources_.end(), known)) {
    sources_.push_back(source);
  }
}

}  // namespace pipescout
