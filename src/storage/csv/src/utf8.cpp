// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/utf8.hpp"

#include <cstdint>

namespace pipescout {
namespace {

constexpr std::uint32_t kFirstSurrogate = 0xD800;
constexpr std::uint32_t kLastSurrogate = 0xDFFF;
constexpr std::uint32_t kLastCharacter = 0x10FFFF;

/// Bytes of the character that begins the text; 0 where none does.
std::size_t character_size(std::string_view text) noexcept {
  const auto byte = [text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80U) {
    return 1;
  }
  const std::size_t size = first >= 0xF0U ? 4 : first >= 0xE0U ? 3 : 2;
  if (first < 0xC2U || first > 0xF4U || text.size() < size) {
    return 0;
  }
  std::uint32_t character = first & (0xFFU >> (size + 1));
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xC0U) != 0x80U) {
      return 0;
    }
    character = character << 6U | (byte(i) & 0x3FU);
  }
  constexpr std::uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool is_surrogate = character >= kFirstSurrogate && character <= kLastSurrogate;
  return character < kLeast[size] || is_surrogate || character > kLastCharacter ? 0 : size;
}

}  // namespace

std::size_t first_byte_not_utf8(std::string_view text) noexcept {
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t size = character_size(text.substr(i));
    if (size == 0) {
      return i;
    }
    i += size;
  }
  return std::string_view::npos;
}

}  // namespace pipescout
