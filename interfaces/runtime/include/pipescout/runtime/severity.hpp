// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/runtime/diagnostics.hpp"

namespace pipescout {

/// The level that somebody should look at first. The numbers of DiagnosticStatus do not say it:
/// STALE, of what has not begun, is the largest, and less than a warning.
[[nodiscard]] constexpr DiagnosticLevel worse(DiagnosticLevel a, DiagnosticLevel b) noexcept {
  constexpr auto severity = [](DiagnosticLevel level) {
    switch (level) {
      case DiagnosticLevel::kOk:
        return 0;
      case DiagnosticLevel::kStale:
        return 1;
      case DiagnosticLevel::kWarn:
        return 2;
      case DiagnosticLevel::kError:
        break;
    }
    return 3;
  };
  return severity(a) < severity(b) ? b : a;
}

}  // namespace pipescout
