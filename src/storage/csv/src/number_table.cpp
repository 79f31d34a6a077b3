// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/number_table.hpp"

#include "pipescout/csv/csv_reader.hpp"

namespace pipescout {

std::vector<std::vector<double>> number_table(std::string_view text, const std::string& name,
                                              bool header, std::size_t columns) {
  const bool commas = text.find(',') != std::string_view::npos;
  CsvReader reader(text, name,
                   {.delimiter = commas ? ',' : ' ', .decimal_mark = '.', .header = header});
  if (reader.columns().size() != columns) {
    throw CsvError(
        name, reader.header_line(),
        std::to_string(reader.columns().size()) + " columns; expected " + std::to_string(columns));
  }
  std::vector<std::vector<double>> rows;
  rows.reserve(reader.rows());
  while (reader.next()) {
    auto& row = rows.emplace_back();
    for (std::size_t column = 0; column < columns; ++column) {
      const auto value = reader.number(column);
      if (!value) {
        reader.refuse(column, "a number");
      }
      row.push_back(*value);
    }
  }
  return rows;
}

}  // namespace pipescout
