// SPDX-License-Identifier: Apache-2.0
#include "assignment.hpp"

#include <limits>

namespace pipescout::navigation {

double least_assignment(const std::vector<double>& costs, std::size_t size) {
  // Shortest augmenting paths; row and column 0 are a place to start from.
  std::vector<double> row_price(size + 1, 0);
  std::vector<double> column_price(size + 1, 0);
  std::vector<std::size_t> row_of(size + 1, 0);
  for (std::size_t row = 1; row <= size; ++row) {
    row_of[0] = row;
    std::vector<double> least(size + 1, std::numeric_limits<double>::infinity());
    std::vector<std::size_t> came_from(size + 1, 0);
    std::vector<bool> used(size + 1, false);
    std::size_t column = 0;
    while (row_of[column] != 0) {
      used[column] = true;
      const std::size_t at = row_of[column];
      double step = std::numeric_limits<double>::infinity();
      std::size_t next = 0;
      for (std::size_t j = 1; j <= size; ++j) {
        if (used[j]) {
          continue;
        }
        const double reduced = costs[(at - 1) * size + j - 1] - row_price[at] - column_price[j];
        if (reduced < least[j]) {
          least[j] = reduced;
          came_from[j] = column;
        }
        if (least[j] < step) {
          step = least[j];
          next = j;
        }
      }
      for (std::size_t j = 0; j <= size; ++j) {
        if (used[j]) {
          row_price[row_of[j]] += step;
          column_price[j] -= step;
        } else {
          least[j] -= step;
        }
      }
      column = next;
    }
    while (column != 0) {
      row_of[column] = row_of[came_from[column]];
      column = came_from[column];
    }
  }
  double sum = 0;
  for (std::size_t j = 1; j <= size; ++j) {
    sum += costs[(row_of[j] - 1) * size + j - 1];
  }
  return sum;
}

}  // namespace pipescout::navigation
