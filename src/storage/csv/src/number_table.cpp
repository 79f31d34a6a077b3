// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/number_table.hpp"

#include <algorithm>
#include <charconv>
#include <stdexcept>

namespace pipescout {

std::vector<std::vector<double>> number_table(std::string_view text, const std::string& name,
                                              bool header, std::size_t columns) {
  constexpr std::string_view kApart = ", \t\r";
  std::vector<std::vector<double>> rows;
  std::size_t line = 0;
  while (!text.empty()) {
    ++line;
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view rest = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if ((header && line == 1) || rest.find_first_not_of(kApart) == std::string_view::npos) {
      continue;
    }
    const auto refuse = [&](const std::string& what) {
      throw std::runtime_error(name + ":" + std::to_string(line) + ": " + what);
    };
    std::vector<double> row;
    for (std::size_t begin = rest.find_first_not_of(kApart); begin != std::string_view::npos;
         begin = rest.find_first_not_of(kApart)) {
      rest.remove_prefix(begin);
      const std::string_view cell = rest.substr(0, rest.find_first_of(kApart));
      // from_chars takes no plus sign.
      const std::string_view digits = cell.starts_with('+') ? cell.substr(1) : cell;
      double value = 0;
      const auto [last, error] =
          std::from_chars(digits.data(), digits.data() + digits.size(), value);
      if (error != std::errc() || last != digits.data() + digits.size()) {
        refuse(std::string("'").append(cell).append("' is not a number"));
      }
      row.push_back(value);
      rest.remove_prefix(cell.size());
    }
    if (row.size() != columns) {
      refuse(std::to_string(row.size()) + " numbers; expected " + std::to_string(columns));
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace pipescout
