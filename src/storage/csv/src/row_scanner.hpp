// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

namespace pipescout {

/// Takes a text apart into rows of cells by RFC 4180: quotes, doubled quotes, line ends within
/// quotes; CR LF, LF, or CR alone in a text without LF. A quote opens only at the beginning of a
/// cell; elsewhere, as in 24", it is an ordinary character. Blanks around cells are dropped, those
/// within quotes are not.
class RowScanner {
 public:
  /// `text` must outlive this. `delimiter`: ' ' stands for runs of blanks, without quotes.
  RowScanner(std::string_view text, char delimiter, std::size_t first_line);

  /// Advances to the next row. False after the last.
  [[nodiscard]] bool next();

  // Of the current row:
  /// Parts of the text or of this object, valid until the next row; at most `kMaxCsvColumns`.
  [[nodiscard]] const std::vector<std::string_view>& cells() const noexcept { return cells_; }
  /// Cells, including those beyond that limit.
  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  [[nodiscard]] std::size_t line() const noexcept { return row_line_; }
  /// A quote that is never closed begins in it.
  [[nodiscard]] bool unclosed() const noexcept { return unclosed_; }
  /// Whether all of its cells are empty.
  [[nodiscard]] bool is_empty() const noexcept { return is_empty_; }
  /// Whether a line end follows it.
  [[nodiscard]] bool has_line_end() const noexcept { return has_line_end_; }

  /// Behind the current row.
  [[nodiscard]] std::size_t position() const noexcept { return position_; }
  [[nodiscard]] std::size_t next_line() const noexcept { return line_; }

 private:
  void add(std::string_view cell);
  void take_quoted(std::size_t quote);
  void take_blank_separated();
  [[nodiscard]] std::size_t end_of_cell(std::size_t from) const;

  std::string_view text_;
  char delimiter_;
  char line_end_;
  std::size_t position_ = 0;
  std::size_t line_;
  std::size_t row_line_ = 0;
  std::size_t count_ = 0;
  bool is_empty_ = true;
  bool unclosed_ = false;
  bool has_line_end_ = false;
  std::vector<std::string_view> cells_;
  std::deque<std::string> unquoted_;  // cells that are not as they stand in the text
  std::size_t used_ = 0;              // of these
};

}  // namespace pipescout
