// SPDX-License-Identifier: Apache-2.0
#include "delimiter.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "cell_text.hpp"
#include "pipescout/csv/csv_reader.hpp"
#include "pipescout/csv/csv_words.hpp"
#include "row_scanner.hpp"

namespace pipescout {
namespace {

constexpr std::array kCandidates{',', ';', '\t', '|'};

bool is_passed_over(const RowScanner& row, const CsvFormat& format) {
  return row.is_empty() || (format.comments && row.cells().front().starts_with('#'));
}

struct Reading {
  char delimiter = ',';
  std::size_t columns = 0;  // of the first row
  std::size_t cells = 0;    // of the rows below it
  std::size_t numbers = 0;  // among these
  bool is_a_table = true;   // all rows have as many cells

  /// Of two readings, whether this one has the larger share of numbers.
  [[nodiscard]] bool has_more_numbers(const Reading& other) const {
    return numbers * other.cells > other.numbers * cells;
  }
};

Reading read_with(char delimiter, std::string_view text, std::size_t first_line,
                  const CsvFormat& format) {
  Reading reading{.delimiter = delimiter};
  RowScanner row(text, delimiter, first_line);
  while (row.next()) {
    if (is_passed_over(row, format)) {
      continue;
    }
    if (reading.columns == 0) {
      reading.columns = row.count();
      if (format.header) {
        continue;
      }
    }
    reading.is_a_table = reading.is_a_table && row.count() == reading.columns;
    reading.cells += row.count();
    reading.numbers +=
        static_cast<std::size_t>(std::ranges::count_if(row.cells(), [](std::string_view cell) {
          return number_shape(cell) != NumberShape::kText;
        }));
  }
  return reading;
}

}  // namespace

char recognised_delimiter(std::string_view text, std::size_t first_line, const std::string& path,
                          const CsvFormat& format) {
  std::vector<char> candidates;
  for (const char delimiter : kCandidates) {
    RowScanner row(text, delimiter, first_line);
    bool found = row.next();
    while (found && is_passed_over(row, format)) {
      found = row.next();
    }
    if (found && row.count() > 1) {
      candidates.push_back(delimiter);
    }
  }
  if (candidates.size() == 1) {
    return candidates.front();
  }
  // In a header of one column that which is in no row, so that "1,5" stays one cell.
  const bool one_column = candidates.empty();
  if (one_column) {
    candidates.assign(kCandidates.begin(), kCandidates.end());
  }
  std::vector<Reading> readings;
  for (const char delimiter : candidates) {
    readings.push_back(read_with(delimiter, text, first_line, format));
  }
  if (std::ranges::any_of(readings, &Reading::is_a_table)) {
    std::erase_if(readings, [](const Reading& reading) { return !reading.is_a_table; });
  }
  if (one_column) {
    return readings.front().delimiter;
  }
  const auto best = std::ranges::max_element(
      readings, [](const Reading& a, const Reading& b) { return b.has_more_numbers(a); });
  for (const Reading& other : readings) {
    if (&other != &*best && !best->has_more_numbers(other)) {
      throw CsvError(path, first_line,
                     "the columns may be separated by '" + delimiter_word(best->delimiter) +
                         "' or by '" + delimiter_word(other.delimiter) + "'; " +
                         format.advice("delimiter", "say it in a first line such as sep=;"));
    }
  }
  return best->delimiter;
}

}  // namespace pipescout
