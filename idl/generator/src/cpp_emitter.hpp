// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "definitions.hpp"
#include "model.hpp"

namespace pipescout::generator {

/// The header of an interface, PACKAGE/FOLDER/snake_case.hpp.
[[nodiscard]] std::string cpp_header(const Interface& interface);

/// The type support of all interfaces of a package: CDR, field tables and the list of its types.
[[nodiscard]] std::string cpp_type_support(const std::string& package,
                                           const std::vector<const Interface*>& interfaces,
                                           const Definitions& definitions);

/// A literal of C++ for a value of that kind.
[[nodiscard]] std::string cpp_literal(Kind kind, const Value& value);
/// A text as a string literal.
[[nodiscard]] std::string cpp_string(std::string_view text);

}  // namespace pipescout::generator
