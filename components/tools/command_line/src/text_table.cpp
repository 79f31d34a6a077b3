// SPDX-License-Identifier: Apache-2.0
#include "pipescout/command_line/text_table.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>

namespace pipescout::command_line {
namespace {

constexpr int kMostDecimals = 9;

bool is_number(const TextTable::Cell& cell) {
  return std::holds_alternative<double>(cell) || std::holds_alternative<std::int64_t>(cell);
}

/// Outside of this, digits in front of or behind the point are too many to read.
bool is_plain(double value) {
  return std::isfinite(value) &&
         (value == 0.0 || (std::abs(value) >= 1e-6 && std::abs(value) < 1e12));
}

std::string shortest(double value) {
  std::array<char, 64> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), end.ptr};
}

std::string with_decimals(double value, int decimals) {
  std::array<char, 64> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                 std::chars_format::fixed, decimals);
  return {buffer.data(), end.ptr};
}

/// Decimals that it takes to read back the same value.
int decimals_of(double value) {
  std::array<char, 512> buffer{};
  const auto end =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed);
  const std::string_view text(buffer.data(), static_cast<std::size_t>(end.ptr - buffer.data()));
  const auto point = text.find('.');
  return point == std::string_view::npos ? 0 : static_cast<int>(text.size() - point - 1);
}

std::string text_of(const TextTable::Cell& cell, int decimals) {
  struct Visitor {
    int decimals;
    std::string operator()(std::monostate) const { return "-"; }
    std::string operator()(bool value) const { return value ? "yes" : "no"; }
    std::string operator()(std::int64_t value) const {
      return decimals > 0 ? with_decimals(static_cast<double>(value), decimals)
                          : std::to_string(value);
    }
    std::string operator()(double value) const {
      return is_plain(value) ? with_decimals(value, decimals) : shortest(value);
    }
    std::string operator()(const std::string& value) const { return value; }
  };
  return std::visit(Visitor{decimals}, cell);
}

/// Characters of UTF-8 text.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xc0U) != 0x80U;
  }));
}

}  // namespace

TextTable::TextTable(std::vector<std::string> columns) : columns_(std::move(columns)) {}

void TextTable::add_row(std::vector<Cell> cells) {
  if (cells.size() != columns_.size()) {
    throw std::invalid_argument("a row of " + std::to_string(cells.size()) +
                                " cells in a table of " + std::to_string(columns_.size()) +
                                " columns");
  }
  rows_.push_back(std::move(cells));
}

void TextTable::print(std::ostream& out, const std::string& indent) const {
  struct Column {
    int decimals = 0;
    std::size_t width = 0;
    bool right = true;
  };
  std::vector<Column> layout(columns_.size());
  std::vector<std::vector<std::string>> texts(rows_.size());
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    auto& column = layout[c];
    for (const auto& row : rows_) {
      if (const auto* value = std::get_if<double>(&row[c]); value != nullptr && is_plain(*value)) {
        column.decimals = std::max(column.decimals, std::min(decimals_of(*value), kMostDecimals));
      }
      column.right =
          column.right && (is_number(row[c]) || std::holds_alternative<std::monostate>(row[c]));
    }
    column.width = width(columns_[c]);
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      texts[r].push_back(text_of(rows_[r][c], column.decimals));
      column.width = std::max(column.width, width(texts[r].back()));
    }
  }
  const auto print_line = [&](const std::vector<std::string>& cells) {
    std::string line = indent;
    for (std::size_t c = 0; c < cells.size(); ++c) {
      const std::string padding(layout[c].width - width(cells[c]), ' ');
      line += c == 0 ? "" : "  ";
      line += layout[c].right ? padding + cells[c] : cells[c] + padding;
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out << line << '\n';
  };
  print_line(columns_);
  std::vector<std::string> rules;
  for (const auto& column : layout) {
    rules.emplace_back(column.width, '-');
  }
  print_line(rules);
  for (const auto& row : texts) {
    print_line(row);
  }
}

}  // namespace pipescout::command_line
