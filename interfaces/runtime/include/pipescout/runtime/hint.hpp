// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace pipescout {

/// What to say behind an unknown name when `nearest` was probably meant: "; did you mean 'gain'?".
/// Names that look the same on a screen (a letter of another alphabet, a space that is not seen, l
/// for I) would make that no help, so the character that differs is told as well.
[[nodiscard]] std::string did_you_mean(std::string_view given, std::string_view nearest);

}  // namespace pipescout
