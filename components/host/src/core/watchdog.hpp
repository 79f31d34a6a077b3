// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pipescout/runtime/time.hpp"

namespace pipescout::host {

/// Says that a process is alive as long as all that must work in it answers: a timer alone would
/// say so of a process in which everything hangs. Knows no clock; not thread-safe.
class Watchdog {
 public:
  struct Callbacks {
    std::function<void()> ask;                         ///< those that have answered so far
    std::function<std::vector<std::string>()> silent;  ///< who has not answered yet
    std::function<void()> alive;
    std::function<void(const std::string&)> warn;
  };

  /// `period`: within which `alive` must be called, so that a callback may take half of it. It is
  /// called at once, when all begins.
  Watchdog(Duration period, SteadyTime now, Callbacks callbacks);

  /// To be called when it is due, or more often. Returns when that is.
  SteadyTime on_time(SteadyTime now);

 private:
  Duration interval_;
  SteadyTime due_;
  Callbacks callbacks_;
  bool warned_ = false;
};

}  // namespace pipescout::host
