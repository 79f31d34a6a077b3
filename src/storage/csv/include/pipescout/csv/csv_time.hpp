// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string_view>

/// Times in other people's tables. Pure functions; thread-safe.
namespace pipescout {

enum class TimeUnit { kSeconds, kMilliseconds, kMicroseconds, kNanoseconds };

/// "s", "ms", "us", "ns".
[[nodiscard]] const char* to_string(TimeUnit unit) noexcept;
/// The unit that a word means: the above, "µs", "sec", "seconds", "milliseconds", ... Nothing for
/// other words.
[[nodiscard]] std::optional<TimeUnit> time_unit(std::string_view word);
/// The unit that the name of a column says: in brackets, "t [ms]", or behind its last '_', "t_ns".
[[nodiscard]] std::optional<TimeUnit> time_unit_of_name(std::string_view name);

/// A number with a decimal point and no exponent in a unit, exact to the nanosecond. Nothing for
/// other text, and beyond 2^31 s to either side.
[[nodiscard]] std::optional<std::chrono::nanoseconds> parse_time(std::string_view number,
                                                                 TimeUnit unit);

struct DateAndTime {
  std::chrono::nanoseconds since_1970{};
  bool has_zone = false;  ///< false: taken for UTC
};
/// ISO 8601 with all digits, "2026-11-29T07:36:05.25Z", "2026-11-29 07:36:05,25+01:00",
/// "20261129T073605Z", or the order of day, month and year that dots say: "29.11.2026 07:36:05".
/// Seconds may be missing. Nothing for other text, among it dates with slashes, whose order
/// depends on the country, and without zero padding in front of the year's, and for times that no
/// stamp can hold (before 1970, after 2038).
[[nodiscard]] std::optional<DateAndTime> parse_date_and_time(std::string_view text);

}  // namespace pipescout
