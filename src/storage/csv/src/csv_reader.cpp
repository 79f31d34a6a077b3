// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_reader.hpp"

#include <algorithm>
#include <utility>

#include "cell_text.hpp"
#include "csv_encoding.hpp"
#include "delimiter.hpp"
#include "pipescout/csv/csv_words.hpp"
#include "row_scanner.hpp"

namespace pipescout {
namespace {

/// The units of the row that comes next, if it has units, nothing or a dash in each cell, one at
/// least, and if those without brackets are of columns with numbers: "A" and "m" may be names too.
/// Empty otherwise. Behind that row then.
std::vector<std::string> take_units(RowScanner& scanner, std::size_t columns) {
  std::vector<std::string> units;
  if (!scanner.next() || scanner.count() != columns) {
    return {};
  }
  bool has_unit = false;
  for (const std::string_view cell : scanner.cells()) {
    units.push_back(folded(cell));
    if (!units.back().empty() && !is_unit_word(units.back())) {
      return {};
    }
    has_unit = has_unit || (!units.back().empty() && units.back() != "-");
  }
  RowScanner below = scanner;
  if (!has_unit || !below.next()) {
    return {};
  }
  for (std::size_t column = 0; column < columns; ++column) {
    const std::string& unit = units[column];
    const std::string_view cell =
        column < below.cells().size() ? below.cells()[column] : std::string_view();
    if (!unit.empty() && unit != "-" && bracketed(unit).empty() &&
        (cell.empty() || number_shape(cell) == NumberShape::kText)) {
      return {};
    }
  }
  return units;
}

std::string cell_count_text(std::size_t cells, std::size_t columns) {
  return std::to_string(cells) + " cells in a table of " + std::to_string(columns) + " columns";
}

}  // namespace

CsvError::CsvError(const std::string& path, std::size_t line, const std::string& message)
    : std::runtime_error(path + (line == 0 ? "" : ":" + std::to_string(line)) + ": " + message),
      line_(line),
      message_(message) {}

struct CsvReader::Bytes : CsvText {
  std::string path;
};

CsvReader::CsvReader(std::string_view bytes, std::string_view path, const CsvFormat& format)
    : bytes_(std::make_unique<Bytes>()), comments_(format.comments) {
  bytes_->path = path;
  decode_csv(bytes, bytes_->path, *bytes_);
  if (!bytes_->note.empty()) {
    notes_.push_back(bytes_->note);
  }
  text_ = bytes_->text;
  if (text_.find_first_not_of(" \t\r\n") == std::string_view::npos) {
    throw CsvError(bytes_->path, 0,
                   format.header ? "is empty; a header line is needed" : "is empty");
  }
  CsvFormat known = format;
  take_separator_line(known);
  const char delimiter = known.delimiter.value_or('\0') != '\0'
                             ? *known.delimiter
                             : recognised_delimiter(text_, first_line_, bytes_->path, known);
  RowScanner scanner(text_, delimiter, first_line_);
  read_header(scanner, known, delimiter);
  look_through(scanner, known);
  numbers_ = collected_;
  if (const std::string note = numbers_->note(); !note.empty()) {
    notes_.push_back(note);
  }
  scanner_ = std::make_unique<RowScanner>(text_, delimiter, first_line_);
}

CsvReader::~CsvReader() = default;

/// "sep=;", as Excel understands it.
void CsvReader::take_separator_line(CsvFormat& format) {
  const std::size_t end = std::min(text_.find_first_of("\r\n"), text_.size());
  std::string_view line = text_.substr(0, end);
  if (line.size() > 1 && line.front() == '"' && line.back() == '"') {
    line = line.substr(1, line.size() - 2);
  }
  std::string start(line.substr(0, 4));
  std::ranges::transform(start, start.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  if (start != "sep=" || line.size() != start.size() + 1) {
    return;
  }
  const char separator = line.back();
  const auto known = list_delimiter(std::string_view(&separator, 1));
  if (!known) {
    throw CsvError(bytes_->path, first_line_,
                   "sep=: the delimiter must be " + delimiter_words() + ", not '" +
                       std::string(1, separator) + "'");
  }
  if (format.delimiter && format.delimiter != known) {
    throw CsvError(bytes_->path, first_line_,
                   "the file says sep=" + delimiter_word(*known) + ", and 'delimiter'" +
                       (format.settings.empty() ? "" : " in " + format.settings) + " says '" +
                       delimiter_word(*format.delimiter) + "'");
  }
  format.delimiter = known;
  text_.remove_prefix(end);
  const std::size_t line_end = text_.starts_with("\r\n") ? 2 : 1;
  text_.remove_prefix(std::min(line_end, text_.size()));
  ++first_line_;
  if (text_.find_first_not_of(" \t\r\n") == std::string_view::npos) {
    throw CsvError(bytes_->path, 0, "is empty; a header line is needed");
  }
}

void CsvReader::read_header(RowScanner& scanner, const CsvFormat& format, char delimiter) {
  const auto is_passed_over = [&] {
    return scanner.is_empty() || (comments_ && scanner.cells().front().starts_with('#'));
  };
  bool found = scanner.next();
  while (found && is_passed_over()) {
    found = scanner.next();
  }
  if (!found) {
    throw CsvError(bytes_->path, 0, "has no rows");
  }
  if (scanner.unclosed()) {
    throw CsvError(bytes_->path, scanner.line(), "a quotation mark of this row is not closed");
  }
  if (scanner.count() > kMaxCsvColumns) {
    throw CsvError(bytes_->path, scanner.line(),
                   std::to_string(scanner.count()) + " columns; there may be " +
                       std::to_string(kMaxCsvColumns));
  }
  std::vector<std::string> columns;
  for (const std::string_view cell : scanner.cells()) {
    columns.push_back(format.header ? folded(cell) : std::to_string(columns.size() + 1));
  }
  const std::size_t header_line = scanner.line();
  std::vector<std::string> units;
  if (!format.header) {
    scanner = RowScanner(text_, delimiter, first_line_);
    if (format.ragged) {
      while (columns.size() < kMaxCsvColumns) {
        columns.push_back(std::to_string(columns.size() + 1));
      }
    }
  } else {
    text_.remove_prefix(scanner.position());
    first_line_ = scanner.next_line();
    scanner = RowScanner(text_, delimiter, first_line_);
    units = take_units(scanner, columns.size());
    if (!units.empty()) {
      notes_.push_back(bytes_->path + ":" + std::to_string(scanner.line()) +
                       ": is taken for a row of units");
      text_.remove_prefix(scanner.position());
      first_line_ = scanner.next_line();
    }
    scanner = RowScanner(text_, delimiter, first_line_);
  }
  collected_ = std::make_shared<CsvNumbers>(
      CsvNumbers::Header{bytes_->path, header_line, std::move(columns), std::move(units)}, format,
      delimiter);
}

void CsvReader::look_through(RowScanner& scanner, const CsvFormat& format) {
  const std::size_t columns = collected_->columns().size();
  std::size_t end = 0;             // of the last row that is not empty
  std::size_t empty_rows = 0;      // since then
  std::size_t misshapen_line = 0;  // the first of them with another number of cells
  std::size_t misshapen_cells = 0;
  while (scanner.next()) {
    const auto& cells = scanner.cells();
    if (comments_ && cells.front().starts_with('#')) {
      continue;
    }
    const bool is_misshapen = !format.ragged && scanner.count() != columns;
    if (format.cut_end && !scanner.has_line_end() && (is_misshapen || scanner.unclosed())) {
      notes_.push_back(bytes_->path + ":" + std::to_string(scanner.line()) +
                       ": the last line is truncated: ignored");
      break;
    }
    if (scanner.unclosed()) {
      throw CsvError(bytes_->path, scanner.line(), "a quotation mark of this row is not closed");
    }
    if (scanner.is_empty()) {
      const bool is_row = scanner.count() > 1 || columns == 1;
      empty_rows += is_row ? 1 : 0;
      if (is_row && is_misshapen && misshapen_line == 0) {
        misshapen_line = scanner.line();
        misshapen_cells = scanner.count();
      }
      continue;
    }
    if (misshapen_line == 0 && is_misshapen) {
      misshapen_line = scanner.line();
      misshapen_cells = scanner.count();
    }
    if (misshapen_line != 0) {
      throw CsvError(bytes_->path, misshapen_line, cell_count_text(misshapen_cells, columns));
    }
    rows_ += 1 + empty_rows;
    empty_rows = 0;
    end = scanner.position();
    for (std::size_t column = 0; column < cells.size(); ++column) {
      collected_->see(column, scanner.line(), cells[column]);
    }
  }
  if (rows_ == 0) {
    throw CsvError(bytes_->path, 0, format.header ? "has a header but no rows" : "has no rows");
  }
  text_ = text_.substr(0, end);
}

bool CsvReader::next() {
  while (scanner_->next()) {
    const bool is_blank_line =
        scanner_->count() == 1 && scanner_->cells().front().empty() && columns().size() > 1;
    if (!is_blank_line && !(comments_ && scanner_->cells().front().starts_with('#'))) {
      return true;
    }
  }
  return false;
}

std::size_t CsvReader::line() const noexcept {
  return scanner_->line();
}

const std::vector<std::string_view>& CsvReader::cells() const noexcept {
  return scanner_->cells();
}

std::optional<double> CsvReader::number(std::size_t column) const {
  return numbers_->number(column, line(), cells()[column]);
}

std::optional<std::chrono::nanoseconds> CsvReader::time(std::size_t column) const {
  return numbers_->time(column, line(), cells()[column]);
}

void CsvReader::refuse(std::size_t column, const std::string& expected) const {
  throw CsvError(path(), line(),
                 "column '" + columns()[column] + "': '" + std::string(cells()[column]) +
                     "' is not " + expected);
}

}  // namespace pipescout
