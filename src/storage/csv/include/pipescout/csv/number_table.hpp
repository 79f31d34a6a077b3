// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace pipescout {

/// The rows of a data set of numbers only, separated by commas or else by blanks, read by
/// CsvReader. `header`: skips the first line. Throws CsvError for what CsvReader refuses, for a
/// cell that is not a number, and for a table that does not have `columns` columns. Pure;
/// thread-safe.
[[nodiscard]] std::vector<std::vector<double>> number_table(std::string_view text,
                                                            const std::string& name, bool header,
                                                            std::size_t columns);

}  // namespace pipescout
