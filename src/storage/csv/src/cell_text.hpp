// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace pipescout {

/// Blanks, tabs (which may be the delimiter), carriage returns and blanks that do not break
/// (U+00A0) at the beginning; bytes.
[[nodiscard]] std::size_t leading_blanks(std::string_view text, char delimiter = '\0') noexcept;
/// Without them at both ends.
[[nodiscard]] std::string_view without_blanks(std::string_view text) noexcept;

/// What a cell tells about the decimal mark.
enum class NumberShape {
  kText,        ///< no number, whatever the mark
  kWhole,       ///< no mark in it, or nothing: fits both
  kPoint,       ///< a number if '.' is the decimal mark, and none otherwise: "1.5", "1,234.5"
  kComma,       ///< the reverse
  kMaybePoint,  ///< "1.234": 1.234, or 1234 with '.' between thousands
  kMaybeComma,  ///< "1,234": the reverse
};
[[nodiscard]] NumberShape number_shape(std::string_view cell) noexcept;

/// The cell with a decimal point and without marks between thousands. Nothing for what is no number
/// with this decimal mark.
[[nodiscard]] std::optional<std::string> with_decimal_point(std::string_view cell, char mark);

}  // namespace pipescout
