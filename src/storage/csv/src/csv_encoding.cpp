// SPDX-License-Identifier: Apache-2.0
#include "csv_encoding.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>

#include "pipescout/csv/csv_reader.hpp"
#include "pipescout/csv/utf8.hpp"

namespace pipescout {
namespace {

/// 0x80 to 0x9F of Windows-1252; 0: no character. The others are those of Latin-1.
constexpr std::array<std::uint16_t, 32> kWindows1252{
    0x20AC, 0,      0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021, 0x02C6, 0x2030, 0x0160,
    0x2039, 0x0152, 0,      0x017D, 0,      0,      0x2018, 0x2019, 0x201C, 0x201D, 0x2022,
    0x2013, 0x2014, 0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0,      0x017E, 0x0178};

std::size_t line_of(std::string_view text, std::size_t at) {
  return 1 + static_cast<std::size_t>(std::count(text.begin(), text.begin() + at, '\n'));
}

void append_utf8(std::string& text, std::uint32_t character) {
  const auto put = [&text](std::uint32_t byte) { text += static_cast<char>(byte); };
  if (character < 0x80U) {
    put(character);
  } else if (character < 0x800U) {
    put(0xC0U | character >> 6U);
    put(0x80U | (character & 0x3FU));
  } else if (character < 0x10000U) {
    put(0xE0U | character >> 12U);
    put(0x80U | (character >> 6U & 0x3FU));
    put(0x80U | (character & 0x3FU));
  } else {
    put(0xF0U | character >> 18U);
    put(0x80U | (character >> 12U & 0x3FU));
    put(0x80U | (character >> 6U & 0x3FU));
    put(0x80U | (character & 0x3FU));
  }
}

std::string from_utf16(std::string_view bytes, bool big_end_first, const std::string& path) {
  const auto unit = [&](std::size_t at) {
    const auto first = static_cast<unsigned char>(bytes[at]);
    const auto second = static_cast<unsigned char>(bytes[at + 1]);
    return big_end_first ? std::uint32_t{first} << 8U | second
                         : std::uint32_t{second} << 8U | first;
  };
  std::string text;
  text.reserve(bytes.size());
  const auto refuse = [&](const std::string& what) {
    throw CsvError(path, line_of(text, text.size()), what);
  };
  for (std::size_t at = 0; at < bytes.size(); at += 2) {
    if (at + 2 > bytes.size()) {
      refuse("is UTF-16 and ends in the middle of a character");
    }
    std::uint32_t character = unit(at);
    if (character >= 0xD800U && character < 0xE000U) {
      const std::uint32_t low = at + 4 <= bytes.size() ? unit(at + 2) : 0;
      if (character >= 0xDC00U || low < 0xDC00U || low >= 0xE000U) {
        refuse("is UTF-16 and has half a character");
      }
      character = 0x10000U + ((character & 0x3FFU) << 10U) + (low & 0x3FFU);
      at += 2;
    }
    append_utf8(text, character);
  }
  return text;
}

std::string hexadecimal(char character) {
  std::array<char, 2> digits{'0', '0'};
  const auto byte = static_cast<unsigned char>(character);
  std::to_chars(digits.data() + (byte < 16 ? 1 : 0), digits.data() + digits.size(), byte, 16);
  return {digits.begin(), digits.end()};
}

std::string from_windows_1252(std::string_view bytes, const std::string& path) {
  std::string text;
  text.reserve(bytes.size() + bytes.size() / 16);
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    const auto byte = static_cast<unsigned char>(bytes[at]);
    const std::uint32_t character =
        byte >= 0x80U && byte < 0xA0U ? kWindows1252[byte - 0x80U] : std::uint32_t{byte};
    if (character == 0 && byte != 0) {
      throw CsvError(path, line_of(bytes, at),
                     "is neither UTF-8 nor Windows-1252: byte 0x" + hexadecimal(bytes[at]) +
                         "; save it as UTF-8, for example with iconv -f ENCODING -t UTF-8");
    }
    append_utf8(text, character);
  }
  return text;
}

bool has_character_of_several_bytes(std::string_view text) {
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (static_cast<unsigned char>(text[at]) >= 0x80U) {
      const std::size_t bad = first_byte_not_utf8(text.substr(at, 4));
      if (bad != 0) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace

void decode_csv(std::string_view bytes, const std::string& path, CsvText& result) {
  constexpr std::string_view kUtf8Mark = "\xEF\xBB\xBF";
  constexpr std::string_view kLittleMark = "\xFF\xFE";
  constexpr std::string_view kBigMark = "\xFE\xFF";
  if (bytes.starts_with(kLittleMark) || bytes.starts_with(kBigMark)) {
    result.converted = from_utf16(bytes.substr(2), bytes.starts_with(kBigMark), path);
    result.text = result.converted;
  } else {
    result.text = bytes.substr(bytes.starts_with(kUtf8Mark) ? kUtf8Mark.size() : 0);
  }
  if (const auto zero = result.text.find('\0'); zero != std::string_view::npos) {
    throw CsvError(path, line_of(result.text, zero),
                   "is not text: it contains a zero byte; UTF-16 needs its byte order mark");
  }
  const std::size_t at = first_byte_not_utf8(result.text);
  if (at == std::string_view::npos) {
    return;
  }
  if (has_character_of_several_bytes(result.text)) {
    throw CsvError(path, line_of(result.text, at),
                   "is not UTF-8: byte 0x" + hexadecimal(result.text[at]) +
                       ", and other lines are; save it as UTF-8");
  }
  result.note = path + ":" + std::to_string(line_of(result.text, at)) + ": byte 0x" +
                hexadecimal(result.text[at]) + " is not UTF-8; the file is read as Windows-1252";
  result.converted = from_windows_1252(result.text, path);
  result.text = result.converted;
}

}  // namespace pipescout
