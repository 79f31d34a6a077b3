// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

/// Words for the constants of `pipescout_msgs/FusedOdometer`, as recordings and logs have them.
/// "unknown" for a value that is none of them.
namespace pipescout {

/// REJECTED_*: "none", "unsupported", "marked invalid", "not a number", "bad sigma", "absent",
/// "incomplete", "stuck", "drifted".
[[nodiscard]] const char* rejection_text(std::uint8_t reason) noexcept;

/// HEALTH_*: "ok", "worn", "slipping", "stuck", "bad values", "silent".
[[nodiscard]] const char* health_text(std::uint8_t health) noexcept;

/// STATUS_*: "ok", "no consensus", "no data".
[[nodiscard]] const char* fusion_status_text(std::uint8_t status) noexcept;

}  // namespace pipescout
