// SPDX-License-Identifier: Apache-2.0
#include "cell_text.hpp"

namespace pipescout {
namespace {

constexpr std::string_view kNoBreakSpace = "\xC2\xA0";
constexpr std::size_t kGroup = 3;  // digits between the marks of thousands

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// Sign, digits with marks, exponent.
struct Parts {
  std::string_view mantissa;
  bool has_exponent = false;
  bool valid = false;
};

Parts parts_of(std::string_view cell) {
  cell.remove_prefix(cell.starts_with('-') || cell.starts_with('+') ? 1 : 0);
  const std::size_t end = cell.find_first_not_of("0123456789.,");
  Parts parts{.mantissa = cell.substr(0, end)};
  parts.valid = parts.mantissa.find_first_of("0123456789") != std::string_view::npos;
  if (end == std::string_view::npos) {
    return parts;
  }
  std::string_view rest = cell.substr(end);
  parts.has_exponent = rest.starts_with('e') || rest.starts_with('E');
  rest.remove_prefix(1);
  rest.remove_prefix(rest.starts_with('-') || rest.starts_with('+') ? 1 : 0);
  parts.valid = parts.valid && parts.has_exponent && !rest.empty() &&
                rest.find_first_not_of("0123456789") == std::string_view::npos;
  return parts;
}

/// "1.234.567" with '.': groups of three digits behind one to three.
bool is_grouped(std::string_view whole, char mark) {
  const std::size_t first = whole.find(mark);
  if (first == 0 || first > kGroup || whole.starts_with('0')) {
    return false;
  }
  for (whole.remove_prefix(first); !whole.empty(); whole.remove_prefix(kGroup + 1)) {
    if (whole.size() <= kGroup || whole.front() != mark) {
      return false;
    }
    for (std::size_t i = 1; i <= kGroup; ++i) {
      if (!is_digit(whole[i])) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace

std::size_t leading_blanks(std::string_view text, char delimiter) noexcept {
  std::size_t at = 0;
  while (at < text.size()) {
    const char c = text[at];
    if ((c == ' ' || c == '\t') && c != delimiter) {
      ++at;
    } else if (text.substr(at).starts_with(kNoBreakSpace)) {
      at += kNoBreakSpace.size();
    } else {
      break;
    }
  }
  return at;
}

std::string_view without_blanks(std::string_view text) noexcept {
  text.remove_prefix(leading_blanks(text));
  while (!text.empty()) {
    const char c = text.back();
    if (c == ' ' || c == '\t' || c == '\r') {
      text.remove_suffix(1);
    } else if (text.ends_with(kNoBreakSpace)) {
      text.remove_suffix(kNoBreakSpace.size());
    } else {
      break;
    }
  }
  return text;
}

NumberShape number_shape(std::string_view cell) noexcept {
  if (cell.empty() || cell == "nan" || cell == "NaN" || cell == "inf" || cell == "-inf") {
    return NumberShape::kWhole;
  }
  const auto [mantissa, has_exponent, valid] = parts_of(cell);
  if (!valid) {
    return NumberShape::kText;
  }
  const std::size_t last = mantissa.find_last_of(".,");
  if (last == std::string_view::npos) {
    return NumberShape::kWhole;
  }
  const char mark = mantissa[last];
  const char other = mark == '.' ? ',' : '.';
  const auto decimal = [](char c) { return c == '.' ? NumberShape::kPoint : NumberShape::kComma; };
  if (mark == ',' && last + 1 == mantissa.size()) {
    return NumberShape::kText;  // "1," is the end of a clause
  }
  const std::string_view whole = mantissa.substr(0, last);
  if (whole.find(mark) != std::string_view::npos) {
    // Twice the same: thousands, if anything.
    return is_grouped(mantissa, mark) && !has_exponent ? decimal(other) : NumberShape::kText;
  }
  if (whole.find(other) != std::string_view::npos) {
    return is_grouped(whole, other) ? decimal(mark) : NumberShape::kText;
  }
  if (is_grouped(mantissa, mark) && !has_exponent) {
    return mark == '.' ? NumberShape::kMaybePoint : NumberShape::kMaybeComma;
  }
  return decimal(mark);
}

std::optional<std::string> with_decimal_point(std::string_view cell, char mark) {
  const NumberShape shape = number_shape(cell);
  const bool has_point = mark == '.';
  if (shape == NumberShape::kText ||
      shape == (has_point ? NumberShape::kComma : NumberShape::kPoint)) {
    return std::nullopt;
  }
  std::string text;
  for (const char c : cell) {
    if (c == mark) {
      text += '.';
    } else if (c != '.' && c != ',') {
      text += c;
    }
  }
  return text;
}

}  // namespace pipescout
