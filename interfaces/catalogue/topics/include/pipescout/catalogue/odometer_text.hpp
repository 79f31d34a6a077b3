// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

/// Names of the constants of `pipescout_msgs/FusedOdometer` in recordings and logs. "unknown" for
/// any other value.
namespace pipescout {

/// REJECTED_*: "none", "unsupported", "marked invalid", "not a number", "bad sigma", "absent",
/// "incomplete", "stuck", "drifted".
[[nodiscard]] const char* rejection_text(std::uint8_t reason) noexcept;

/// HEALTH_*: "ok", "worn", "slipping", "stuck", "bad values", "silent".
[[nodiscard]] const char* health_text(std::uint8_t health) noexcept;

/// STATUS_*: "ok", "no consensus", "no data".
[[nodiscard]] const char* fusion_status_text(std::uint8_t status) noexcept;

}  // namespace pipescout
