// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string_view>

namespace pipescout {

/// Index of the first byte that does not belong to a character of UTF-8 (RFC 3629: no overlong
/// forms, no surrogates, nothing above U+10FFFF); npos where all do.
[[nodiscard]] std::size_t first_byte_not_utf8(std::string_view text) noexcept;

}  // namespace pipescout
