// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

/// Times in CSV: seconds with nine decimals. Pure functions; thread-safe.
namespace pipescout {

/// A time of measurement, as in messages: since the Unix epoch, or since the start of a simulation.
using Stamp = std::chrono::sys_time<std::chrono::nanoseconds>;

/// "12.000000345".
[[nodiscard]] std::string format_stamp(std::chrono::nanoseconds stamp);
/// Seconds to nanoseconds: exact with up to nine decimals, otherwise rounded. Nothing unless it is
/// a number in [0, 2^31).
[[nodiscard]] std::optional<std::chrono::nanoseconds> parse_stamp(std::string_view cell);

}  // namespace pipescout
