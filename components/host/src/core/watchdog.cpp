// SPDX-License-Identifier: Apache-2.0
#include "core/watchdog.hpp"

#include <utility>

namespace pipescout::host {

Watchdog::Watchdog(Duration period, SteadyTime now, Callbacks callbacks)
    : interval_(period / 4), due_(now + interval_), callbacks_(std::move(callbacks)) {
  callbacks_.alive();
  callbacks_.ask();
}

SteadyTime Watchdog::on_time(SteadyTime now) {
  if (now < due_) {
    return due_;
  }
  due_ = now + interval_;
  const auto silent = callbacks_.silent();
  if (silent.empty()) {
    warned_ = false;
    callbacks_.alive();
    callbacks_.ask();
    return due_;
  }
  if (!warned_) {
    warned_ = true;
    std::string names;
    for (const auto& name : silent) {
      names += (names.empty() ? "" : ", ") + name;
    }
    callbacks_.warn("no answer from the executor of " + names +
                    ": a callback has not returned. The service manager is not told that the "
                    "process is alive until it does");
  }
  // Those that work go on being asked.
  callbacks_.ask();
  return due_;
}

}  // namespace pipescout::host
