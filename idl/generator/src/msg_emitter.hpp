// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "model.hpp"

namespace pipescout::generator {

/// The definition in .msg form with its comments; lines end with a line break. A structure without
/// fields has none.
[[nodiscard]] std::string msg_text(const Structure& structure);

/// A .msg, .srv or .action file: the structures that such a file holds, separated by "---".
[[nodiscard]] std::string msg_text(const Interface& interface);

/// A value as .msg files write it; texts in quotes.
[[nodiscard]] std::string msg_value(const Value& value);

/// The default value of a field that has one.
[[nodiscard]] std::string msg_default(const Field& field);

}  // namespace pipescout::generator
