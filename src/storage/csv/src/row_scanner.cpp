// SPDX-License-Identifier: Apache-2.0
#include "row_scanner.hpp"

#include <algorithm>

#include "cell_text.hpp"
#include "pipescout/csv/csv_reader.hpp"

namespace pipescout {

RowScanner::RowScanner(std::string_view text, char delimiter, std::size_t first_line)
    : text_(text),
      delimiter_(delimiter),
      line_end_(text.find('\n') == std::string_view::npos ? '\r' : '\n'),
      line_(first_line) {}

bool RowScanner::next() {
  if (position_ >= text_.size()) {
    return false;
  }
  cells_.clear();
  count_ = 0;
  used_ = 0;
  row_line_ = line_;
  has_line_end_ = false;
  is_empty_ = true;
  unclosed_ = false;
  if (delimiter_ == ' ') {
    take_blank_separated();
    return true;
  }
  while (true) {
    const std::size_t first = position_ + leading_blanks(text_.substr(position_), delimiter_);
    if (first < text_.size() && text_[first] == '"') {
      take_quoted(first);
    } else {
      const std::size_t end = end_of_cell(first);
      add(without_blanks(text_.substr(first, end - first)));
      position_ = end;
    }
    if (position_ >= text_.size()) {
      return true;
    }
    if (text_[position_++] == line_end_) {
      ++line_;
      has_line_end_ = true;
      return true;
    }
  }
}

std::size_t RowScanner::end_of_cell(std::size_t from) const {
  while (from < text_.size() && text_[from] != delimiter_ && text_[from] != line_end_) {
    ++from;
  }
  return from;
}

void RowScanner::add(std::string_view cell) {
  ++count_;
  is_empty_ = is_empty_ && cell.empty();
  // A line of millions of delimiters takes no memory.
  if (cells_.size() < kMaxCsvColumns) {
    cells_.push_back(cell);
  }
}

void RowScanner::take_quoted(std::size_t quote) {
  std::size_t from = quote + 1;
  std::size_t close = text_.find('"', from);
  std::string content;
  while (close != std::string_view::npos && close + 1 < text_.size() && text_[close + 1] == '"') {
    content += text_.substr(from, close + 1 - from);
    from = close + 2;
    close = text_.find('"', from);
  }
  unclosed_ = close == std::string_view::npos;
  close = std::min(close, text_.size());
  const std::string_view last = text_.substr(from, close - from);
  line_ += static_cast<std::size_t>(std::count(text_.begin() + static_cast<std::ptrdiff_t>(quote),
                                               text_.begin() + static_cast<std::ptrdiff_t>(close),
                                               line_end_));
  const std::size_t behind = std::min(close + 1, text_.size());
  position_ = end_of_cell(behind);
  const std::string_view rest = without_blanks(text_.substr(behind, position_ - behind));
  if (content.empty() && rest.empty()) {
    add(last);
    return;
  }
  content += last;
  content += rest;
  if (used_ == unquoted_.size()) {
    unquoted_.emplace_back();
  }
  unquoted_[used_] = std::move(content);
  add(unquoted_[used_++]);
}

void RowScanner::take_blank_separated() {
  const std::size_t end = std::min(text_.find(line_end_, position_), text_.size());
  std::string_view rest = text_.substr(position_, end - position_);
  for (rest = without_blanks(rest); !rest.empty(); rest = without_blanks(rest)) {
    const std::size_t size = std::min(rest.find_first_of(" \t"), rest.size());
    add(rest.substr(0, size));
    rest.remove_prefix(size);
  }
  if (count_ == 0) {
    add({});
  }
  has_line_end_ = end < text_.size();
  line_ += has_line_end_ ? 1 : 0;
  position_ = std::min(end + 1, text_.size());
}

}  // namespace pipescout
