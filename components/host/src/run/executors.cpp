// SPDX-License-Identifier: Apache-2.0
#include "run/executors.hpp"

#include <algorithm>
#include <utility>

#include "run/thread_priority.hpp"

namespace pipescout::host {

Executor& Executors::add(std::string name, const ExecutorSettings& settings) {
  return all_.emplace_back(std::move(name), settings).executor;
}

void Executors::start() {
  for (auto& one : all_) {
    if (one.thread) {
      continue;
    }
    one.thread.emplace(one.executor,
                       ExecutorThread::Callbacks{
                           .before =
                               [this, &one] {
                                 if (const auto refusal = apply_to_this_thread(one.settings);
                                     !refusal.empty()) {
                                   callbacks_.warn("executor of " + one.name + ": " + refusal);
                                 }
                               },
                           .on_failure = callbacks_.on_failure});
  }
}

void Executors::stop() {
  for (auto& one : all_) {
    one.thread.reset();
    one.group->close();
  }
}

bool Executors::failed() const {
  return !failure().empty();
}

std::string Executors::failure() const {
  for (const auto& one : all_) {
    if (one.thread && one.thread->failed()) {
      return one.thread->failure();
    }
  }
  return {};
}

void Executors::ask() {
  for (auto& one : all_) {
    if (!one.asked.exchange(true)) {
      one.group->post([&one] { one.asked = false; });
    }
  }
}

std::vector<std::string> Executors::silent() const {
  std::vector<std::string> names;
  for (const auto& one : all_) {
    if (one.asked) {
      names.push_back(one.name);
    }
  }
  return names;
}

}  // namespace pipescout::host
