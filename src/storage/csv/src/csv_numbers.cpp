// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_numbers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "cell_text.hpp"
#include "pipescout/csv/csv_cell.hpp"
#include "pipescout/csv/csv_reader.hpp"
#include "pipescout/csv/csv_words.hpp"

namespace pipescout {
namespace {

using std::chrono::nanoseconds;

/// Digits of the time since 1970 between 2001-09-09 and 2286-11-20, in s, ms, us, ns.
constexpr std::array<std::pair<TimeUnit, std::size_t>, 4> kDigitsSince1970{
    {{TimeUnit::kSeconds, 10},
     {TimeUnit::kMilliseconds, 13},
     {TimeUnit::kMicroseconds, 16},
     {TimeUnit::kNanoseconds, 19}}};

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// The first line of a kind.
void keep_first(std::size_t& first, std::size_t line) {
  first = first == 0 ? line : first;
}

/// In front of the decimal mark of a number that may have an exponent. A mark that may stand
/// between thousands is taken for the decimal one: times since 1970 have none.
std::size_t whole_digits(std::string_view cell) {
  if (cell.find_first_of("eE") != std::string_view::npos) {
    const auto plain =
        with_decimal_point(cell, cell.find(',') == std::string_view::npos ? '.' : ',');
    const auto value = plain ? parse_csv_number(*plain) : std::nullopt;
    return value && std::abs(*value) >= 1 && std::isfinite(*value)
               ? static_cast<std::size_t>(std::log10(std::abs(*value))) + 1
               : 1;
  }
  std::size_t digits = 0;
  for (const char c : cell) {
    if (c == '.' || c == ',') {
      break;
    }
    digits += is_digit(c) ? 1 : 0;
  }
  return std::max<std::size_t>(digits, 1);
}

/// "2026-11-29T07:36:05Z", and what means to be such a time.
bool looks_like_date(std::string_view cell) {
  return std::ranges::count(cell, ':') > 0 || std::ranges::count(cell, '/') > 1 ||
         std::ranges::count(cell, '.') > 1 || cell.find('T') != std::string_view::npos;
}

}  // namespace

CsvNumbers::CsvNumbers(Header header, CsvFormat format, char delimiter)
    : header_(std::move(header)),
      format_(std::move(format)),
      delimiter_(delimiter),
      seen_(header_.columns.size()) {}

std::optional<std::size_t> CsvNumbers::find_column(std::string_view name) const {
  const std::string wanted = folded(name);
  const auto found = std::ranges::find(columns(), wanted);
  if (found == columns().end() || wanted.empty()) {
    return std::nullopt;
  }
  if (std::find(found + 1, columns().end(), wanted) != columns().end()) {
    throw CsvError(path(), header_line(), "two columns are named '" + wanted + "'");
  }
  return static_cast<std::size_t>(found - columns().begin());
}

void CsvNumbers::see(std::size_t column, std::size_t line, std::string_view cell) {
  if (column >= seen_.size()) {
    return;  // of a ragged row
  }
  cell = without_blanks(cell);
  Column& seen = seen_[column];
  const NumberShape shape = number_shape(cell);
  seen.has_cells = seen.has_cells || !cell.empty();
  for (Marks* const marks : {&seen.marks, &all_}) {
    if (shape == NumberShape::kPoint) {
      keep_first(marks->point, line);
    } else if (shape == NumberShape::kComma) {
      keep_first(marks->comma, line);
    } else if (shape == NumberShape::kMaybePoint) {
      keep_first(marks->maybe_point, line);
    } else if (shape == NumberShape::kMaybeComma) {
      keep_first(marks->maybe_comma, line);
    }
  }
  if (shape == NumberShape::kText) {
    seen.has_text = true;
    if (looks_like_date(cell)) {
      const auto time = parse_date_and_time(cell);
      seen.has_zoneless_time = seen.has_zoneless_time || (time && !time->has_zone);
    }
    return;
  }
  if (cell.find_first_of("0123456789") == std::string_view::npos) {
    return;  // nan, inf, nothing
  }
  const std::size_t digits = whole_digits(cell);
  if (digits > seen.most_digits) {
    seen.most_digits = digits;
    seen.most_digits_line = line;
  }
  seen.fewest_digits = seen.fewest_digits == 0 ? digits : std::min(seen.fewest_digits, digits);
}

std::string CsvNumbers::unit(std::size_t column) const {
  if (column < header_.units.size() && !header_.units[column].empty()) {
    const std::string inner = bracketed(header_.units[column]);
    return inner.empty() ? header_.units[column] : inner;
  }
  return bracketed(header_.columns[column]);
}

bool CsvNumbers::is_empty(std::size_t column) const {
  return !seen_[column].has_cells;
}

/// '.', ',', or '\0' in doubt.
char CsvNumbers::mark_of(std::size_t column) const {
  if (format_.decimal_mark) {
    return *format_.decimal_mark;
  }
  const auto of = [](const Marks& marks) -> char {
    return marks.point > 0 && marks.comma == 0   ? '.'
           : marks.comma > 0 && marks.point == 0 ? ','
                                                 : '\0';
  };
  if (const char mark = of(all_); mark != '\0') {
    return mark;
  }
  const Marks own = column < seen_.size() ? seen_[column].marks : Marks{};
  // Where commas separate columns they separate decimals only in quotes.
  return delimiter_ == ',' && own.comma == 0 ? '.' : of(own);
}

void CsvNumbers::refuse(std::size_t column, std::size_t line, const std::string& what) const {
  throw CsvError(header_.path, line, "column '" + header_.columns[column] + "': " + what);
}

std::optional<double> CsvNumbers::number(std::size_t column, std::size_t line,
                                         std::string_view cell) const {
  cell = without_blanks(cell);
  const bool plus = cell.size() > 1 && cell.front() == '+' && (is_digit(cell[1]) || cell[1] == '.');
  cell.remove_prefix(plus ? 1 : 0);
  // Most cells by far.
  if (cell.find_first_of(".,") == std::string_view::npos) {
    return parse_csv_number(cell);
  }
  const NumberShape shape = number_shape(cell);
  if (shape == NumberShape::kText) {
    return std::nullopt;
  }
  const char mark = mark_of(column);
  const auto advice = [this] {
    return format_.advice("decimal_mark",
                          "write numbers with a decimal point and without marks between thousands");
  };
  const bool is_maybe = shape == NumberShape::kMaybePoint || shape == NumberShape::kMaybeComma;
  if (!format_.decimal_mark && column < seen_.size()) {
    const Marks& own = seen_[column].marks;
    if (own.point > 0 && own.comma > 0) {
      refuse(column, line,
             "'" + std::string(cell) + "': line " + std::to_string(own.point) +
                 " has a decimal point and line " + std::to_string(own.comma) +
                 " a decimal comma; " + advice());
    }
    // Between thousands only in a column that proves it.
    const bool is_between_thousands =
        shape == (mark == '.' ? NumberShape::kMaybeComma : NumberShape::kMaybePoint);
    const bool has_proof = (mark == '.' ? own.point : own.comma) > 0;
    if (is_maybe && (mark == '\0' || (is_between_thousands && !has_proof))) {
      std::string decimal(cell);
      std::ranges::replace(decimal, ',', '.');
      std::string whole(cell);
      std::erase_if(whole, [](char c) { return c == '.' || c == ','; });
      refuse(column, line,
             "'" + std::string(cell) + "' may be " + decimal + " or " + whole + "; " + advice());
    }
  }
  if (mark == '.' && shape == NumberShape::kPoint && cell.find(',') == std::string_view::npos) {
    return parse_csv_number(cell);
  }
  const auto plain = with_decimal_point(cell, mark);
  return plain ? parse_csv_number(*plain) : std::nullopt;
}

CsvNumbers::FoundUnit CsvNumbers::time_unit_of(std::size_t column) const {
  if (format_.time_unit) {
    return {*format_.time_unit, UnitSource::kSetting};
  }
  if (column < header_.units.size() && !header_.units[column].empty()) {
    if (const auto unit = time_unit(this->unit(column))) {
      return {*unit, UnitSource::kFile};
    }
  }
  const Column& seen = seen_[column];
  const auto named = time_unit_of_name(header_.columns[column]);
  for (const auto& [unit, digits] : kDigitsSince1970) {
    if (unit != TimeUnit::kSeconds && seen.fewest_digits == digits && seen.most_digits == digits &&
        (!named || *named == unit)) {
      return {unit, named ? UnitSource::kFile : UnitSource::kSize};
    }
  }
  const TimeUnit unit = named.value_or(TimeUnit::kSeconds);
  const std::size_t decimals = kDigitsSince1970[static_cast<std::size_t>(unit)].second;
  if (seen.most_digits > decimals) {
    refuse(column, seen.most_digits_line,
           std::string("a time of ") + std::to_string(seen.most_digits) +
               " digits is beyond what a time in " + to_string(unit) + " can be; " +
               format_.advice("time_unit", "name the column's unit in brackets, as in 't [ns]'"));
  }
  return {unit, named ? UnitSource::kFile : UnitSource::kNone};
}

std::optional<nanoseconds> CsvNumbers::time(std::size_t column, std::size_t line,
                                            std::string_view cell) const {
  cell = without_blanks(cell);
  if (looks_like_date(cell)) {
    const auto time = parse_date_and_time(cell);
    return time ? std::optional(time->since_1970) : std::nullopt;
  }
  const auto value = number(column, line, cell);
  if (!value || !std::isfinite(*value)) {
    return std::nullopt;
  }
  const TimeUnit unit = time_unit_of(column).unit;
  const auto plain = with_decimal_point(cell, mark_of(column));
  if (const auto exact = plain ? parse_time(*plain, unit) : std::nullopt) {
    return exact;
  }
  // With an exponent, or beyond what a stamp holds.
  constexpr double kLimit = 2147483648.0;  // s
  const double seconds = *value / std::pow(1000.0, static_cast<int>(unit));
  return std::abs(seconds) < kLimit ? std::optional(nanoseconds(std::llround(seconds * 1e9)))
                                    : std::nullopt;
}

std::optional<double> CsvNumbers::seconds(std::size_t column, std::size_t line,
                                          std::string_view cell) const {
  if (!looks_like_date(cell) && time_unit_of(column).unit == TimeUnit::kSeconds) {
    return number(column, line, cell);
  }
  const auto since = time(column, line, cell);
  return since ? std::optional(static_cast<double>(since->count()) / 1e9) : std::nullopt;
}

std::string CsvNumbers::note() const {
  if (format_.decimal_mark || all_.comma == 0 || all_.point > 0) {
    return "";
  }
  return header_.path + ": numbers have a decimal comma";
}

std::string CsvNumbers::time_note(std::size_t column) const {
  const FoundUnit found = time_unit_of(column);
  const std::string start = header_.path + ": column '" + header_.columns[column] + "': ";
  if (seen_[column].has_zoneless_time) {
    return start + "times without a zone are taken for UTC";
  }
  return found.unit == TimeUnit::kSeconds || found.source == UnitSource::kSetting
             ? ""
             : start + "times are in " + to_string(found.unit) +
                   (found.source == UnitSource::kSize ? ", by their size" : "");
}

}  // namespace pipescout
