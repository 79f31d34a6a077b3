// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "pipescout/csv/csv_format.hpp"

namespace pipescout {

/// The delimiter with which a text is a table: of those in its first row the one with which all
/// rows have as many cells as it, and of several such the one with the most numbers. Throws
/// CsvError when two do equally well.
[[nodiscard]] char recognised_delimiter(std::string_view text, std::size_t first_line,
                                        const std::string& path, const CsvFormat& format);

}  // namespace pipescout
