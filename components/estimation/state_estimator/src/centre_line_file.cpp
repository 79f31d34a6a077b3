// SPDX-License-Identifier: Apache-2.0
#include "pipescout/state_estimator/centre_line_file.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <utility>
#include <vector>

#include "pipescout/csv/csv_file.hpp"
#include "pipescout/csv/csv_reader.hpp"

namespace pipescout {

estimation::PipeCentreLine parse_centre_line(std::string_view text, const std::string& path,
                                             double first_chainage) {
  CsvReader reader(text, path);
  std::array<std::size_t, 3> columns{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string name(1, "xyz"[axis]);
    const auto column = reader.find_column(name);
    if (!column) {
      throw CsvError(path, reader.header_line(),
                     "no column '" + name + "'; a centre line has x, y and z");
    }
    columns[axis] = *column;
  }
  std::vector<Eigen::Vector3d> points;
  while (reader.next()) {
    Eigen::Vector3d point;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto value = reader.number(columns[axis]);
      if (!value || !std::isfinite(*value)) {
        reader.refuse(columns[axis], "a finite number of metres");
      }
      point(static_cast<Eigen::Index>(axis)) = *value;
    }
    points.push_back(point);
  }
  try {
    return estimation::PipeCentreLine(std::move(points), first_chainage);
  } catch (const std::invalid_argument& error) {
    throw CsvError(path, 0, error.what());
  }
}

estimation::PipeCentreLine read_centre_line(const std::string& path, double first_chainage) {
  return parse_centre_line(read_csv_text(path), path, first_chainage);
}

}  // namespace pipescout
