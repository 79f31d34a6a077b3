// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace pipescout {

/// Size limit of a CSV file, bytes.
inline constexpr std::uintmax_t kMaxCsvFileSize = std::uintmax_t{64} * 1024 * 1024;

/// The bytes of a CSV file, for CsvReader. Throws CsvError naming the file when it does not exist,
/// is not a regular file, is larger than the limit, or cannot be read.
[[nodiscard]] std::string read_csv_text(const std::string& path);

}  // namespace pipescout
