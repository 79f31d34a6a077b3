// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/csv/csv_table.hpp"

namespace pipescout::testing {

/// What a German Excel's "Save as" offers.
enum class ExcelExport {
  kCsv,          ///< "CSV (Trennzeichen-getrennt)": Windows-1252
  kCsvUtf8,      ///< "CSV UTF-8": with a byte order mark
  kUnicodeText,  ///< "Unicode Text": UTF-16, low byte first, with a byte order mark, tabs
};
inline constexpr std::array kExcelExports{ExcelExport::kCsv, ExcelExport::kCsvUtf8,
                                          ExcelExport::kUnicodeText};

/// A number as a German Excel shows it without a format: 15 digits, a comma, "1,5E-07".
inline std::string german_number(double value) {
  constexpr int kDigits = 15;
  std::array<char, 40> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                 std::chars_format::general, kDigits);
  std::string text(buffer.data(), end.ptr);
  for (char& c : text) {
    c = c == '.' ? ',' : c == 'e' ? 'E' : c;
  }
  return text;
}

/// The characters of a UTF-8 text up to U+FFFF, as the export's bytes. Characters that
/// Windows-1252 lacks become '?', as in Excel.
inline std::string encoded(std::string_view text, ExcelExport as) {
  if (as == ExcelExport::kCsvUtf8) {
    return "\xEF\xBB\xBF" + std::string(text);
  }
  std::string bytes = as == ExcelExport::kUnicodeText ? "\xFF\xFE" : "";
  for (std::size_t at = 0; at < text.size();) {
    const auto lead = static_cast<unsigned char>(text[at]);
    const std::size_t size = lead < 0x80U ? 1 : lead < 0xE0U ? 2 : 3;
    unsigned character = size == 1 ? lead : lead & (0xFFU >> (size + 1));
    for (std::size_t k = 1; k < size; ++k) {
      character = character << 6U | (static_cast<unsigned char>(text[at + k]) & 0x3FU);
    }
    at += size;
    if (as == ExcelExport::kUnicodeText) {
      bytes += static_cast<char>(character & 0xFFU);
      bytes += static_cast<char>(character >> 8U);
    } else {
      const bool is_latin = character < 0x80U || (character >= 0xA0U && character < 0x100U);
      bytes += is_latin ? static_cast<char>(character) : character == 0x20ACU ? '\x80' : '?';
    }
  }
  return bytes;
}

/// The table `csv`, comma-separated with decimal points, as a German Excel saves it that has read
/// it: numbers lose digits beyond 15 and zeros at their end.
inline std::string german_excel(std::string_view csv, ExcelExport as) {
  const CsvTable table(csv, "original");
  const char delimiter = as == ExcelExport::kUnicodeText ? '\t' : ';';
  std::string text;
  const auto add_row = [&](const auto& cells) {
    for (std::size_t k = 0; k < cells.size(); ++k) {
      const auto value = parse_csv_number(cells[k]);
      std::string cell = value && std::isfinite(*value) ? german_number(*value) : cells[k];
      if (cell.find_first_of(std::string("\"\r\n") + delimiter) != std::string::npos) {
        std::string quoted = "\"";
        for (const char c : cell) {
          quoted.append(c == '"' ? 2 : 1, c);
        }
        cell = quoted + '"';
      }
      text += (k > 0 ? std::string(1, delimiter) : "") + cell;
    }
    text += "\r\n";
  };
  add_row(table.columns());
  std::vector<std::string> cells(table.columns().size());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    for (std::size_t column = 0; column < cells.size(); ++column) {
      cells[column] = table.cell(row, column);
    }
    add_row(cells);
  }
  return encoded(text, as);
}

}  // namespace pipescout::testing
