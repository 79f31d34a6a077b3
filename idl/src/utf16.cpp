// SPDX-License-Identifier: Apache-2.0
#include "utf16.hpp"

#include <array>
#include <cstdint>

namespace pipescout::idl {
namespace {

constexpr char32_t kReplacement = 0xFFFD;

bool is_high_surrogate(char32_t c) {
  return c >= 0xD800 && c < 0xDC00;
}

bool is_low_surrogate(char32_t c) {
  return c >= 0xDC00 && c < 0xE000;
}

void append_utf8(std::string& out, char32_t c) {
  const auto byte = [&out](char32_t bits) { out += static_cast<char>(bits); };
  const auto continuation = [&](unsigned shift) { byte(0x80U | ((c >> shift) & 0x3FU)); };
  if (c < 0x80) {
    byte(c);
  } else if (c < 0x800) {
    byte(0xC0U | (c >> 6U));
    continuation(0);
  } else if (c < 0x10000) {
    byte(0xE0U | (c >> 12U));
    continuation(6);
    continuation(0);
  } else {
    byte(0xF0U | (c >> 18U));
    continuation(12);
    continuation(6);
    continuation(0);
  }
}

/// Takes one character from the front of `text`.
std::optional<char32_t> take_utf8(std::string_view& text) {
  const auto first = static_cast<unsigned char>(text.front());
  const std::size_t length = first < 0x80   ? 1
                             : first < 0xC2 ? 0
                             : first < 0xE0 ? 2
                             : first < 0xF0 ? 3
                             : first < 0xF5 ? 4
                                            : 0;
  if (length == 0 || text.size() < length) {
    return std::nullopt;
  }
  constexpr std::array<unsigned, 5> kBits{0, 0x7F, 0x1F, 0x0F, 0x07};
  constexpr std::array<char32_t, 5> kSmallest{0, 0, 0x80, 0x800, 0x10000};
  char32_t c = first & kBits[length];
  for (std::size_t i = 1; i < length; ++i) {
    const auto next = static_cast<unsigned char>(text[i]);
    if ((next & 0xC0U) != 0x80U) {
      return std::nullopt;
    }
    c = c << 6U | (next & 0x3FU);
  }
  if (c < kSmallest[length] || c > 0x10FFFF || is_high_surrogate(c) || is_low_surrogate(c)) {
    return std::nullopt;
  }
  text.remove_prefix(length);
  return c;
}

}  // namespace

std::string to_utf8(std::u16string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    char32_t c = text[i];
    if (is_high_surrogate(c) && i + 1 < text.size() && is_low_surrogate(text[i + 1])) {
      c = 0x10000 + ((c - 0xD800) << 10U) + (text[++i] - 0xDC00U);
    } else if (is_high_surrogate(c) || is_low_surrogate(c)) {
      c = kReplacement;
    }
    append_utf8(out, c);
  }
  return out;
}

std::optional<std::u16string> to_utf16(std::string_view text) {
  std::u16string out;
  while (!text.empty()) {
    const auto c = take_utf8(text);
    if (!c) {
      return std::nullopt;
    }
    if (*c < 0x10000) {
      out += static_cast<char16_t>(*c);
    } else {
      out += static_cast<char16_t>(0xD800 + ((*c - 0x10000) >> 10U));
      out += static_cast<char16_t>(0xDC00 + ((*c - 0x10000) & 0x3FFU));
    }
  }
  return out;
}

}  // namespace pipescout::idl
