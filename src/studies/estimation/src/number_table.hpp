// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace pipescout::estimation_study::internal {

/// Rows of numbers, apart by commas or blanks. `header`: the first line is none of them. Throws
/// std::runtime_error naming `name` and the line for a cell that is no number, and for a row that
/// has not `columns` of them.
[[nodiscard]] std::vector<std::vector<double>> number_table(std::string_view text,
                                                            const std::string& name, bool header,
                                                            std::size_t columns);

}  // namespace pipescout::estimation_study::internal
