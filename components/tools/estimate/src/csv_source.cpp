// SPDX-License-Identifier: Apache-2.0
#include "csv_source.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "pipescout/csv/csv_file.hpp"
#include "pipescout/csv/csv_table.hpp"
#include "pipescout/files/yaml_location.hpp"

namespace pipescout::estimate {
namespace {

std::string trimmed(const std::string& cell) {
  const auto begin = cell.find_first_not_of(" \t\r");
  return begin == std::string::npos
             ? std::string()
             : cell.substr(begin, cell.find_last_not_of(" \t\r") - begin + 1);
}

std::vector<CsvRow> blank_separated(const std::string& text) {
  std::vector<CsvRow> rows;
  std::istringstream lines(text);
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    CsvRow row{.line = ++number, .cells = {}};
    std::istringstream cells(line);
    for (std::string cell; cells >> cell;) {
      row.cells.push_back(cell);
    }
    if (!row.cells.empty()) {
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

}  // namespace

CsvSource::CsvSource(const std::filesystem::path& file, const YAML::Node& source,
                     std::string mapping)
    : mapping_(std::move(mapping)) {
  const std::string delimiter = source["delimiter"] ? source["delimiter"].Scalar() : ",";
  const std::string text = read_csv_text(file.string());
  if (delimiter == "blank") {
    rows_ = blank_separated(text);
  } else if (delimiter.size() == 1) {
    rows_ = read_csv_rows(text, delimiter[0]).rows;
  } else {
    throw YamlError(mapping_, source["delimiter"].Mark(), "delimiter: one character, or 'blank'");
  }
  std::erase_if(rows_, [](const CsvRow& row) {
    return row.cells.empty() || trimmed(row.cells[0]).starts_with('#');
  });
  const bool header = !source["header"] || source["header"].Scalar() != "false";
  if (header && !rows_.empty()) {
    for (const std::string& cell : rows_.front().cells) {
      names_.push_back(trimmed(cell));
    }
    rows_.erase(rows_.begin());
  }
  if (source["rows"]) {
    const std::string mark = source["rows"].Scalar();
    std::erase_if(rows_, [&](const CsvRow& row) { return trimmed(row.cells[0]) != mark; });
  }
  if (rows_.empty()) {
    throw std::runtime_error(file.string() + ": no rows");
  }
}

std::size_t CsvSource::column(const YAML::Node& name) const {
  if (!name.IsScalar()) {
    throw YamlError(mapping_, name.Mark(), "the name or number of a column is expected");
  }
  const auto found = std::ranges::find(names_, name.Scalar());
  if (found != names_.end()) {
    return static_cast<std::size_t>(found - names_.begin());
  }
  const auto number = parse_csv_number(name.Scalar());
  if (number && *number >= 1 && *number <= 1024 && *number == std::floor(*number)) {
    return static_cast<std::size_t>(*number) - 1;
  }
  std::string known;
  for (const std::string& each : names_) {
    known += (known.empty() ? "; the file has " : ", ") + each;
  }
  throw YamlError(mapping_, name.Mark(), "no column '" + name.Scalar() + "'" + known);
}

std::vector<std::size_t> CsvColumns::all(const char* key, std::size_t count) const {
  const YAML::Node value = node_[key];
  if (!value.IsDefined()) {
    throw YamlError(mapping_, node_.Mark(), std::string("columns: '") + key + "' is missing");
  }
  std::vector<std::size_t> result;
  if (value.IsSequence()) {
    for (const YAML::Node& each : value) {
      result.push_back(source_.column(each));
    }
  } else {
    result.push_back(source_.column(value));
  }
  if (count > 0 && result.size() != count) {
    throw YamlError(mapping_, value.Mark(),
                    std::string(key) + ": " + std::to_string(count) + " columns are expected");
  }
  return result;
}

double CsvColumns::number(const CsvRow& row, std::size_t column) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  return column < row.cells.size() ? parse_csv_number(trimmed(row.cells[column])).value_or(kNan)
                                   : kNan;
}

Eigen::Vector3d CsvColumns::vector(const CsvRow& row, const std::vector<std::size_t>& columns) {
  return {number(row, columns[0]), number(row, columns[1]), number(row, columns[2])};
}

}  // namespace pipescout::estimate
