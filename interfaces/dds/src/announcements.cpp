// SPDX-License-Identifier: Apache-2.0
#include "pipescout/dds/announcements.hpp"

#include <stdexcept>
#include <utility>

namespace pipescout {

void Announcements::say(const std::string& text) {
  if (text.find_first_of(std::string(";\0", 2)) != std::string::npos) {
    throw std::invalid_argument("an announcement contains ';' or '\\0': '" + text + "'");
  }
  const std::lock_guard sending(sending_mutex_);
  {
    const std::lock_guard lock(mutex_);
    text_ = text;
  }
  if (send_) {
    send_(text);
  }
}

std::map<Gid, std::string> Announcements::others() const {
  const std::lock_guard lock(mutex_);
  return others_;
}

void Announcements::on_heard(std::function<void()> heard) {
  const std::lock_guard hearing(hearing_mutex_);
  heard_ = std::move(heard);
}

void Announcements::connect(std::function<void(const std::string& text)> send) {
  const std::lock_guard sending(sending_mutex_);
  send_ = std::move(send);
}

std::string Announcements::text() const {
  const std::lock_guard lock(mutex_);
  return text_;
}

void Announcements::hear(const Gid& participant, const std::string& text) {
  {
    const std::lock_guard lock(mutex_);
    const auto known = others_.find(participant);
    if ((known == others_.end() ? std::string() : known->second) == text) {
      return;
    }
    if (text.empty()) {
      others_.erase(known);
    } else {
      others_[participant] = text;
    }
  }
  const std::lock_guard hearing(hearing_mutex_);
  if (heard_) {
    heard_();
  }
}

}  // namespace pipescout
