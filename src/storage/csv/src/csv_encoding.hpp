// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace pipescout {

struct CsvText {
  std::string converted;  ///< UTF-8, if `text` had to be converted
  std::string_view text;  ///< UTF-8 without byte order mark; part of the bytes or of `converted`
  std::string note;       ///< which encoding was guessed; empty: none
};

/// UTF-8, UTF-16 with a byte order mark, and Windows-1252, which is what a spreadsheet of western
/// Europe writes otherwise. Throws CsvError for other bytes: of neither, of both, and zero bytes.
/// Not copyable into another place: `text` may be part of `converted`.
void decode_csv(std::string_view bytes, const std::string& path, CsvText& result);

}  // namespace pipescout
