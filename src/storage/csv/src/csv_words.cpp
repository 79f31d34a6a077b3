// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_words.hpp"

#include <algorithm>
#include <array>

namespace pipescout {
namespace {

constexpr std::string_view kNoBreakSpace = "\xC2\xA0";
constexpr std::string_view kDelimiters = ",;|\t";

struct LengthUnit {
  const char* name;
  const char* symbol;
  double metres;
};
constexpr std::array<LengthUnit, 5> kUnits{{{"metres", "m", 1.0},
                                            {"millimetres", "mm", 1e-3},
                                            {"centimetres", "cm", 1e-2},
                                            {"kilometres", "km", 1e3},
                                            {"feet", "ft", 0.3048}}};

/// Of rows of units below a header. "-" says that a column has none.
constexpr std::array<std::string_view, 61> kUnitWords{
    "-",       "%",    "s",       "sec",    "ms",    "us",       "\u00B5s",     "\u03BCs",
    "ns",      "min",  "h",       "Hz",     "hh:mm", "m",        "mm",          "cm",
    "km",      "in",   "inch",    "ft",     "feet",  "metres",   "millimetres", "m^2",
    "m\u00B2", "m/s",  "km/h",    "mm/s",   "m/s^2", "m/s2",     "m/s\u00B2",   "g",
    "rad",     "deg",  "\u00B0",  "rad/s",  "deg/s", "\u00B0/s", "degC",        "\u00B0C",
    "K",       "degF", "\u00B0F", "V",      "mV",    "A",        "mA",          "ohm",
    "Pa",      "hPa",  "kPa",     "bar",    "mbar",  "T",        "uT",          "\u00B5T",
    "N",       "kg",   "o'clock", "pulses", "counts"};

}  // namespace

std::string folded(std::string_view text) {
  std::string result;
  bool blank = false;
  while (!text.empty()) {
    const auto code = static_cast<unsigned char>(text.front());
    if (code <= 0x20U || code == 0x7FU || text.starts_with(kNoBreakSpace)) {
      blank = true;
      text.remove_prefix(code <= 0x7FU ? 1 : kNoBreakSpace.size());
      continue;
    }
    if (blank && !result.empty()) {
      result += ' ';
    }
    blank = false;
    result += text.front();
    text.remove_prefix(1);
  }
  return result;
}

std::string bracketed(std::string_view name) {
  const auto open = name.find_last_of("[(");
  const auto close = name.find_last_of("])");
  return open == std::string_view::npos || close == std::string_view::npos || close < open
             ? std::string()
             : std::string(name.substr(open + 1, close - open - 1));
}

std::optional<double> metres_per_list_unit(std::string_view unit) {
  for (const LengthUnit& known : kUnits) {
    if (unit == known.name || unit == known.symbol) {
      return known.metres;
    }
  }
  return std::nullopt;
}

std::string list_unit_names() {
  std::string names;
  for (const LengthUnit& unit : kUnits) {
    names += (names.empty() ? "" : ", ") + std::string(unit.name) + " (" + unit.symbol + ")";
  }
  return names;
}

bool is_unit_word(std::string_view cell) {
  const bool in_brackets = cell.size() > 2 && ((cell.front() == '[' && cell.back() == ']') ||
                                               (cell.front() == '(' && cell.back() == ')'));
  return std::ranges::find(kUnitWords, in_brackets ? cell.substr(1, cell.size() - 2) : cell) !=
         kUnitWords.end();
}

std::optional<char> list_delimiter(std::string_view word) {
  if (word == "tab") {
    return '\t';
  }
  if (word == "blank") {
    return ' ';
  }
  if (word.size() == 1 && kDelimiters.find(word) != std::string_view::npos) {
    return word.front();
  }
  return std::nullopt;
}

std::string delimiter_word(char delimiter) {
  return delimiter == '\t' ? "tab" : delimiter == ' ' ? "blank" : std::string(1, delimiter);
}

std::string delimiter_words() {
  return "',', ';', '|', tab or blank";
}

std::optional<char> decimal_mark(std::string_view word) {
  return word == "." || word == "," ? std::optional(word.front()) : std::nullopt;
}

std::string quoted_list(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) {
    text += (text.empty() ? "'" : ", '") + name + "'";
  }
  return text;
}

}  // namespace pipescout
