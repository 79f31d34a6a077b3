// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <charconv>
#include <string>

namespace pipescout {

/// A number in a message: "99.8", "0.0123", whatever the locale.
inline std::string text_for_people(double value) {
  constexpr int kDigits = 4;
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                 std::chars_format::general, kDigits);
  return {buffer.data(), end.ptr};
}

}  // namespace pipescout
