// SPDX-License-Identifier: Apache-2.0
#include "pipescout/validation/number_text.hpp"

#include <array>
#include <charconv>
#include <cstddef>
#include <string_view>

namespace pipescout::validation {

std::string number_text(double value) {
  constexpr int kDigits = 9;
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::general, kDigits);
  return {text.data(), end.ptr};
}

std::string fixed_text(double value, int decimals) {
  // The largest double has 309 digits before the point.
  std::array<char, 352> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::fixed, decimals);
  const std::string_view written(text.data(), static_cast<std::size_t>(end.ptr - text.data()));
  const bool is_minus_zero =
      written.starts_with('-') && written.find_first_not_of("-0.") == std::string_view::npos;
  return std::string(is_minus_zero ? written.substr(1) : written);
}

}  // namespace pipescout::validation
