// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace pipescout::idl {

/// What is no UTF-16 (half of a surrogate pair) becomes U+FFFD.
[[nodiscard]] std::string to_utf8(std::u16string_view text);

/// Nothing when `text` is no UTF-8.
[[nodiscard]] std::optional<std::u16string> to_utf16(std::string_view text);

}  // namespace pipescout::idl
