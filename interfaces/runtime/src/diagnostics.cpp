// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/diagnostics.hpp"

#include <utility>

#include "pipescout/runtime/severity.hpp"

namespace pipescout {

DiagnosticLevel Diagnostics::current_level() const {
  return counted_ ? worse(status_.level, DiagnosticLevel::kWarn) : status_.level;
}

std::function<void()> Diagnostics::notification() {
  if (notified_ || current_level() == taken_level_) {
    return {};
  }
  notified_ = true;
  return level_changed_;
}

void Diagnostics::count(std::string_view counter, std::uint64_t times) {
  if (times == 0) {
    return;
  }
  std::function<void()> notify;
  {
    const std::lock_guard lock(mutex_);
    auto found = counters_.find(counter);
    if (found == counters_.end()) {
      found = counters_.emplace(std::string(counter), 0).first;
    }
    found->second += times;
    counted_ = true;
    notify = notification();
  }
  if (notify) {
    notify();
  }
}

void Diagnostics::set_value(std::string_view key, std::string value) {
  const std::lock_guard lock(mutex_);
  if (const auto found = values_.find(key); found != values_.end()) {
    found->second = std::move(value);
  } else {
    values_.emplace(std::string(key), std::move(value));
  }
}

void Diagnostics::set_status(DiagnosticLevel level, std::string message) {
  std::function<void()> notify;
  {
    const std::lock_guard lock(mutex_);
    status_ = {level, std::move(message)};
    notify = notification();
  }
  if (notify) {
    notify();
  }
}

Diagnostics::Status Diagnostics::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

std::uint64_t Diagnostics::counter(std::string_view counter) const {
  const std::lock_guard lock(mutex_);
  const auto found = counters_.find(counter);
  return found == counters_.end() ? 0 : found->second;
}

Diagnostics::Snapshot Diagnostics::take() {
  const std::lock_guard lock(mutex_);
  Snapshot snapshot;
  snapshot.level = current_level();
  snapshot.message = status_.message;
  snapshot.values.insert(values_.begin(), values_.end());
  std::string growth;
  for (const auto& [name, total] : counters_) {
    snapshot.values.insert_or_assign(name, std::to_string(total));
    auto& before = taken_[name];
    if (total > before) {
      growth += growth.empty() ? "" : ", ";
      growth += name + " +" + std::to_string(total - before);
      before = total;
    }
  }
  // The component's own words come first where they say something worse.
  if (!growth.empty() && status_.level == DiagnosticLevel::kOk) {
    snapshot.message = growth;
  } else if (!growth.empty()) {
    snapshot.message += (snapshot.message.empty() ? "" : "; ") + growth;
  }
  counted_ = false;
  notified_ = false;
  taken_level_ = snapshot.level;
  return snapshot;
}

void Diagnostics::on_level_changed(std::function<void()> callback) {
  const std::lock_guard lock(mutex_);
  level_changed_ = std::move(callback);
}

}  // namespace pipescout
