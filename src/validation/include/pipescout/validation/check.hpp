// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <locale>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

/// Parameters that are wrong are refused with std::invalid_argument: "field: value is outside
/// range". NaN and infinities are outside every range.
namespace pipescout::validation {

/// The name of a field, by views: put together only where it is refused, so that a check that holds
/// allocates nothing.
struct Field {
  // Implicit: most fields are given as text.
  Field(const char* text) : name(text) {}
  Field(std::string_view text) : name(text) {}
  Field(const std::string& text) : name(text) {}
  Field(std::string_view of, std::string_view text) : prefix(of), name(text) {}

  std::string_view prefix;
  std::string_view name;
};

/// Throws with the parts, as a stream writes them, as its message.
template <typename... Parts>
[[noreturn]] void refuse(const Parts&... parts) {
  std::ostringstream message;
  message.imbue(std::locale::classic());
  (message << ... << parts);
  throw std::invalid_argument(message.str());
}

/// Throws unless `value` is finite and `in_range`. `range` is for the message: "(0, 1]".
void require(const Field& field, double value, bool in_range, std::string_view range);

/// Throws unless low <= value <= high.
void check_within(const Field& field, double value, double low, double high);

/// Throws unless low < value <= high.
void check_above(const Field& field, double value, double low, double high);

/// Throws unless low < value < high.
void check_between(const Field& field, double value, double low, double high);

}  // namespace pipescout::validation
