// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_stamp.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "pipescout/csv/csv_cell.hpp"

namespace pipescout {

namespace {

using std::chrono::nanoseconds;

/// ROS 2's stamps hold seconds as int32.
constexpr std::int64_t kStampLimitSeconds = std::int64_t{1} << 31U;
constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
constexpr std::size_t kStampDecimals = 9;

}  // namespace

std::string format_stamp(nanoseconds stamp) {
  const std::string decimals = std::to_string(std::abs(stamp.count() % kNanosecondsPerSecond));
  return (stamp.count() < 0 ? "-" : "") +
         std::to_string(std::abs(stamp.count() / kNanosecondsPerSecond)) + "." +
         std::string(kStampDecimals - decimals.size(), '0') + decimals;
}

std::optional<nanoseconds> parse_stamp(std::string_view cell) {
  const std::size_t point = cell.find('.');
  std::string digits(cell.substr(0, point));
  std::string decimals(point == std::string_view::npos ? "" : cell.substr(point + 1));
  const auto is_digit = [](char character) { return character >= '0' && character <= '9'; };
  const bool exact = !digits.empty() && digits.size() <= 10 && decimals.size() <= kStampDecimals &&
                     std::all_of(digits.begin(), digits.end(), is_digit) &&
                     std::all_of(decimals.begin(), decimals.end(), is_digit);
  if (exact) {
    decimals.resize(kStampDecimals, '0');
    const std::int64_t seconds = std::stoll(digits);
    if (seconds >= kStampLimitSeconds) {
      return std::nullopt;
    }
    return nanoseconds(seconds * kNanosecondsPerSecond + std::stoll(decimals));
  }
  const auto seconds = parse_csv_number(cell);
  if (!seconds || !(*seconds >= 0.0) || !(*seconds < static_cast<double>(kStampLimitSeconds))) {
    return std::nullopt;
  }
  return nanoseconds(std::llround(*seconds * 1e9));
}

}  // namespace pipescout
