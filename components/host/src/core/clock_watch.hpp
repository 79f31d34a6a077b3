// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "pipescout/runtime/time.hpp"

namespace pipescout::host {

/// How the clock of the system was set.
struct ClockStep {
  Duration by{};  ///< negative: back
  Time from{};    ///< what it would say now
  Time to{};      ///< what it says
};

/// Finds out when somebody sets the clock of the system, by comparing it with the steady clock.
/// A service that disciplines it (NTP) lets it run a little faster or slower while it can, which is
/// no step. Reads no clock itself; not thread-safe.
class ClockWatch {
 public:
  /// Both clocks, read at the same moment. The first time nothing is known yet.
  [[nodiscard]] std::optional<ClockStep> look(Time system, SteadyTime steady);

 private:
  struct Look {
    Time system;
    SteadyTime steady;
  };
  std::optional<Look> last_;
};

/// "the system clock of this machine was set back by 60.0 s, from
/// 2026-11-29T07:45:10.250Z to 2026-11-29T07:44:10.250Z: stamps go with it".
[[nodiscard]] std::string to_text(const ClockStep& step);

}  // namespace pipescout::host
