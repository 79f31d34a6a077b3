// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_time.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <string>
#include <system_error>
#include <utility>

#include "pipescout/csv/csv_words.hpp"

namespace pipescout {
namespace {

using std::chrono::nanoseconds;

/// ROS 2's stamps hold seconds as int32.
constexpr std::int64_t kLargestSecond = std::int64_t{1} << 31U;

struct UnitNames {
  TimeUnit unit;
  std::array<std::string_view, 5> names;  // the first one is of to_string
  std::size_t decimals;                   // down to a nanosecond
};
constexpr std::array<UnitNames, 4> kUnits{
    {{TimeUnit::kSeconds, {"s", "sec", "secs", "second", "seconds"}, 9},
     {TimeUnit::kMilliseconds, {"ms", "msec", "millis", "millisecond", "milliseconds"}, 6},
     {TimeUnit::kMicroseconds, {"us", "usec", "\u00B5s", "\u03BCs", "microseconds"}, 3},
     {TimeUnit::kNanoseconds, {"ns", "nsec", "nanos", "nanosecond", "nanoseconds"}, 0}}};

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// Takes a text apart from its beginning.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : rest_(text) {}

  /// So many digits; -1: there are not.
  int digits(std::size_t count) {
    if (rest_.size() < count || !std::all_of(rest_.begin(), rest_.begin() + count, is_digit)) {
      return -1;
    }
    int value = 0;
    (void)std::from_chars(rest_.data(), rest_.data() + count, value);
    rest_.remove_prefix(count);
    return value;
  }
  bool take(std::string_view any_of) {
    const bool found = !rest_.empty() && any_of.find(rest_.front()) != std::string_view::npos;
    rest_.remove_prefix(found ? 1 : 0);
    return found;
  }
  /// Of a second: digits to the end of them, as nanoseconds.
  std::int64_t fraction() {
    std::int64_t value = 0;
    for (std::size_t i = 0; i < kUnits.front().decimals; ++i) {
      value *= 10;
      if (!rest_.empty() && is_digit(rest_.front())) {
        value += rest_.front() - '0';
        rest_.remove_prefix(1);
      }
    }
    rest_.remove_prefix(std::min(rest_.find_first_not_of("0123456789"), rest_.size()));
    return value;
  }
  [[nodiscard]] bool at_end() const { return rest_.empty(); }

 private:
  std::string_view rest_;
};

struct Date {
  int year = -1;
  int month = -1;
  int day = -1;
};

std::optional<Date> take_date(Scanner& text, std::string_view whole) {
  Date date;
  const std::size_t first = std::min(whole.find_first_not_of("0123456789"), whole.size());
  if (first == 2 && whole.size() > first && whole[first] == '.') {
    date.day = text.digits(2);
    (void)text.take(".");
    date.month = text.digits(2);
    const bool point = text.take(".");
    date.year = text.digits(4);
    return point ? std::optional(date) : std::nullopt;
  }
  date.year = text.digits(4);
  const bool dashes = text.take("-");
  date.month = text.digits(2);
  if (dashes && !text.take("-")) {
    return std::nullopt;
  }
  date.day = text.digits(2);
  return date;
}

/// min; "", "Z", "+01:00", "+0100", "+01"
std::optional<int> take_zone(Scanner& text, bool& has_zone) {
  has_zone = true;
  if (text.take("Zz")) {
    return 0;
  }
  const bool west = text.take("-");
  if (!west && !text.take("+")) {
    has_zone = false;
    return 0;
  }
  const int hours = text.digits(2);
  const bool colon = text.take(":");
  const int minutes = text.at_end() && !colon ? 0 : text.digits(2);
  if (hours < 0 || minutes < 0) {
    return std::nullopt;
  }
  return (west ? -1 : 1) * (60 * hours + minutes);
}

}  // namespace

const char* to_string(TimeUnit unit) noexcept {
  return kUnits[static_cast<std::size_t>(unit)].names.front().data();
}

std::optional<TimeUnit> time_unit(std::string_view word) {
  for (const UnitNames& known : kUnits) {
    if (std::ranges::find(known.names, word) != known.names.end()) {
      return known.unit;
    }
  }
  return std::nullopt;
}

std::optional<TimeUnit> time_unit_of_name(std::string_view name) {
  if (const auto unit = time_unit(bracketed(name))) {
    return unit;
  }
  const std::size_t bar = name.rfind('_');
  return bar == std::string_view::npos ? std::nullopt : time_unit(name.substr(bar + 1));
}

std::optional<nanoseconds> parse_time(std::string_view number, TimeUnit unit) {
  const bool negative = number.starts_with('-');
  number.remove_prefix(negative || number.starts_with('+') ? 1 : 0);
  const std::size_t point = std::min(number.find('.'), number.size());
  const std::string_view whole = number.substr(0, point);
  std::string_view rest = number.substr(std::min(point + 1, number.size()));
  const std::size_t decimals = kUnits[static_cast<std::size_t>(unit)].decimals;
  constexpr std::size_t kLongest = 19;  // 2^31 s in ns
  if (whole.empty() || !std::all_of(whole.begin(), whole.end(), is_digit) ||
      !std::all_of(rest.begin(), rest.end(), is_digit) || whole.size() + decimals > kLongest) {
    return std::nullopt;
  }
  const bool up = rest.size() > decimals && rest[decimals] >= '5';
  std::string digits(whole);
  digits += rest.substr(0, decimals);
  digits.resize(whole.size() + decimals, '0');
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc{} || value / 1'000'000'000 >= kLargestSecond) {
    return std::nullopt;
  }
  value += up ? 1 : 0;
  return nanoseconds(negative ? -value : value);
}

std::optional<DateAndTime> parse_date_and_time(std::string_view text) {
  Scanner scanner(text);
  const auto date = take_date(scanner, text);
  if (!date || date->year < 0 || date->month < 0 || date->day < 0 || !scanner.take("T t")) {
    return std::nullopt;
  }
  const int hour = scanner.digits(2);
  const bool colons = scanner.take(":");
  const int minute = scanner.digits(2);
  int second = 0;
  std::int64_t fraction = 0;
  if (colons ? scanner.take(":") : !scanner.at_end()) {
    second = scanner.digits(2);
    fraction = scanner.take(".,") ? scanner.fraction() : 0;
  }
  DateAndTime result;
  const auto offset = take_zone(scanner, result.has_zone);
  const std::chrono::year_month_day day{std::chrono::year(date->year),
                                        std::chrono::month(static_cast<unsigned>(date->month)),
                                        std::chrono::day(static_cast<unsigned>(date->day))};
  if (!day.ok() || hour < 0 || hour > 23 || minute < 0 || minute > 59 || second < 0 ||
      second > 60 || !offset || !scanner.at_end()) {
    return std::nullopt;
  }
  const std::int64_t days = std::chrono::sys_days(day).time_since_epoch().count();
  const std::int64_t seconds =
      days * 86400 + std::int64_t{3600} * hour + std::int64_t{60} * (minute - *offset) + second;
  if (seconds < 0 || seconds >= kLargestSecond) {
    return std::nullopt;
  }
  result.since_1970 = nanoseconds(seconds * 1'000'000'000 + fraction);
  return result;
}

}  // namespace pipescout
