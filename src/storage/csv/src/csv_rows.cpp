// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_rows.hpp"

#include <cmath>
#include <utility>

#include "pipescout/csv/csv_table.hpp"

namespace pipescout {

CsvRows read_csv_rows(std::string_view text, char delimiter) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) {
    text.remove_prefix(kByteOrderMark.size());
  }
  CsvRows result;
  std::size_t line = 1;
  CsvRow row{.line = 1, .cells = {""}};
  bool quoted = false;
  const auto end_row = [&] {
    if (row.cells.size() > 1 || !row.cells.front().empty()) {
      result.rows.push_back(std::move(row));
    }
    row = {.line = line, .cells = {""}};
  };
  for (std::size_t k = 0; k < text.size(); ++k) {
    const char c = text[k];
    line += c == '\n' ? 1U : 0U;
    if (quoted) {
      if (c == '"' && k + 1 < text.size() && text[k + 1] == '"') {
        row.cells.back() += '"';
        ++k;
      } else if (c == '"') {
        quoted = false;
      } else {
        row.cells.back() += c;
      }
    } else if (c == '"' && row.cells.back().empty()) {
      quoted = true;
    } else if (c == delimiter) {
      row.cells.emplace_back();
    } else if (c == '\n') {
      end_row();
    } else if (c != '\r') {
      row.cells.back() += c;
    }
  }
  end_row();
  result.closed = !quoted;
  return result;
}

std::string csv_cell(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) {
    return std::string(text);
  }
  std::string cell = "\"";
  for (const char c : text) {
    cell.append(c == '"' ? 2 : 1, c);
  }
  return cell + '"';
}

std::string format_optional_csv_number(double value) {
  return std::isnan(value) ? std::string() : format_csv_number(value);
}

}  // namespace pipescout
