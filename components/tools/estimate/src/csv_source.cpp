// SPDX-License-Identifier: Apache-2.0
#include "csv_source.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "pipescout/csv/csv_file.hpp"
#include "pipescout/csv/csv_words.hpp"
#include "pipescout/files/yaml_location.hpp"

namespace pipescout::estimate {
namespace {

CsvTable read_table(const std::filesystem::path& file, const YAML::Node& source,
                    const std::string& mapping, bool has_header) {
  // A row that is too short has values that are missing, as the report says.
  CsvFormat format{.header = has_header, .comments = true, .ragged = true, .settings = mapping};
  for (const char* key : {"delimiter", "decimal_mark", "time_unit"}) {
    if (const YAML::Node word = source[key]) {
      try {
        format.set(key, word.IsScalar() ? word.Scalar() : "");
      } catch (const std::invalid_argument& error) {
        throw YamlError(mapping, word.Mark(), error.what());
      }
    }
  }
  return {read_csv_text(file.string()), file.string(), format};
}

}  // namespace

CsvSource::CsvSource(const std::filesystem::path& file, const YAML::Node& source,
                     std::string mapping)
    : mapping_(std::move(mapping)),
      table_(read_table(file, source, mapping_,
                        !source["header"] || source["header"].Scalar() != "false")),
      has_header_(!source["header"] || source["header"].Scalar() != "false") {
  for (std::size_t row = 0; row < table_.rows(); ++row) {
    if (!source["rows"] || table_.cell(row, 0) == source["rows"].Scalar()) {
      rows_.push_back(row);
    }
  }
  if (rows_.empty()) {
    throw std::runtime_error(file.string() + ": no rows");
  }
}

std::size_t CsvSource::column(const YAML::Node& name) const {
  if (!name.IsScalar()) {
    throw YamlError(mapping_, name.Mark(), "the name or number of a column is expected");
  }
  if (has_header_) {
    if (const auto found = table_.find_column(name.Scalar())) {
      return *found;
    }
  }
  const auto number = parse_csv_number(name.Scalar());
  if (number && *number >= 1 && *number <= static_cast<double>(table_.columns().size()) &&
      *number == std::floor(*number)) {
    return static_cast<std::size_t>(*number) - 1;
  }
  throw YamlError(mapping_, name.Mark(),
                  "no column '" + name.Scalar() + "'" +
                      (has_header_ ? "; the file has " + quoted_list(table_.columns()) : ""));
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

double CsvColumns::number(std::size_t row, std::size_t column) const {
  const CsvTable& table = source_.table();
  const auto value = column < table.cells(row)
                         ? table.numbers().number(column, table.line(row), table.cell(row, column))
                         : std::nullopt;
  return value.value_or(std::numeric_limits<double>::quiet_NaN());
}

double CsvColumns::time(std::size_t row, std::size_t column) const {
  const CsvTable& table = source_.table();
  const auto value = column < table.cells(row)
                         ? table.numbers().seconds(column, table.line(row), table.cell(row, column))
                         : std::nullopt;
  return value.value_or(std::numeric_limits<double>::quiet_NaN());
}

Eigen::Vector3d CsvColumns::vector(std::size_t row, const std::vector<std::size_t>& columns) const {
  return {number(row, columns[0]), number(row, columns[1]), number(row, columns[2])};
}

}  // namespace pipescout::estimate
