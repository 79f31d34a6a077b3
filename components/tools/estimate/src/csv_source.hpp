// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "pipescout/csv/csv_table.hpp"

namespace pipescout::estimate {

/// One CSV file of a mapping: rows of cells, columns by name or by number from 1.
class CsvSource {
 public:
  /// `source`: with the keys `delimiter`, `decimal_mark`, `time_unit`, `header` and `rows` of the
  /// file `mapping`. Throws YamlError for these, std::runtime_error for a file that cannot be read
  /// or has no rows.
  CsvSource(const std::filesystem::path& file, const YAML::Node& source, std::string mapping);

  [[nodiscard]] const CsvTable& table() const noexcept { return table_; }
  /// Those of the table that the mapping wants.
  [[nodiscard]] const std::vector<std::size_t>& rows() const noexcept { return rows_; }
  /// Place of a column. Throws YamlError when there is none.
  [[nodiscard]] std::size_t column(const YAML::Node& name) const;

 private:
  std::string mapping_;
  CsvTable table_;
  bool has_header_;
  std::vector<std::size_t> rows_;
};

/// The columns of one source, by what they hold.
class CsvColumns {
 public:
  /// `source` outlives this.
  CsvColumns(const CsvSource& source, const YAML::Node& node, std::string mapping)
      : source_(source), node_(node), mapping_(std::move(mapping)) {}

  [[nodiscard]] bool has(const char* key) const { return node_[key].IsDefined(); }
  /// `count` of them, any number for 0. Throws YamlError.
  [[nodiscard]] std::vector<std::size_t> all(const char* key, std::size_t count) const;
  [[nodiscard]] std::size_t one(const char* key) const { return all(key, 1)[0]; }

  /// NaN for what is no number, so that the row is counted as such. Throws CsvError where the
  /// decimal mark is in doubt.
  [[nodiscard]] double number(std::size_t row, std::size_t column) const;
  /// Of three columns.
  [[nodiscard]] Eigen::Vector3d vector(std::size_t row,
                                       const std::vector<std::size_t>& columns) const;
  /// s; NaN for what is no time. Throws CsvError where the unit is in doubt.
  [[nodiscard]] double time(std::size_t row, std::size_t column) const;

 private:
  const CsvSource& source_;
  YAML::Node node_;
  std::string mapping_;
};

}  // namespace pipescout::estimate
