// SPDX-License-Identifier: Apache-2.0
#include "pipescout/files/utc_text.hpp"

#include <array>
#include <cstdio>

namespace pipescout {

std::string utc_text(std::chrono::sys_time<std::chrono::milliseconds> time, UtcForm form) {
  using namespace std::chrono_literals;
  constexpr std::chrono::sys_days kFirst{1y / 1 / 1};
  constexpr std::chrono::sys_days kBehindLast{10000y / 1 / 1};
  if (time < kFirst || time >= kBehindLast) {
    return "";
  }
  const auto day = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss<std::chrono::milliseconds> clock(time - day);
  const char between = form == UtcForm::kReadable ? ' ' : 'T';
  const char colon = form == UtcForm::kFileName ? '-' : ':';
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "%04d-%02u-%02u%c%02d%c%02d%c%02d",
                static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                static_cast<unsigned>(date.day()), between, static_cast<int>(clock.hours().count()),
                colon, static_cast<int>(clock.minutes().count()), colon,
                static_cast<int>(clock.seconds().count()));
  std::string result = text.data();
  switch (form) {
    case UtcForm::kIso:
      std::snprintf(text.data(), text.size(), ".%03dZ",
                    static_cast<int>(clock.subseconds().count()));
      return result + text.data();
    case UtcForm::kFileName:
      return result + "Z";
    case UtcForm::kReadable:
      return result + " UTC";
  }
  return result;
}

}  // namespace pipescout
