// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>

namespace pipescout {

/// How a time is written.
enum class UtcForm {
  kIso,       ///< ISO 8601 to the millisecond: "2026-03-01T09:30:00.250Z"
  kFileName,  ///< without colons: "2026-03-01T09-30-00Z"
  kReadable,  ///< "2026-03-01 09:30:00 UTC"
};

/// A time since 1970 as text, whatever the locale. Forms without a fraction give the second that
/// has begun. Empty outside the years 1 to 9999.
[[nodiscard]] std::string utc_text(std::chrono::sys_time<std::chrono::milliseconds> time,
                                   UtcForm form);

}  // namespace pipescout
