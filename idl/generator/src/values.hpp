// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "model.hpp"

namespace pipescout::generator {

/// Reads a number or truth value as .msg files write it: decimal, 0x, 0o and 0b; true, false, 1, 0.
/// `leading_zero_is_octal`: as IDL has it. Throws DefinitionError when it does not fit the type.
[[nodiscard]] Value parse_number(Kind kind, std::string_view text, bool leading_zero_is_octal,
                                 const Location& location, std::string_view name);

/// Reads a text in .msg form: quoted with ' or ", where a backslash keeps the next character, or
/// bare. Throws DefinitionError when the quotes do not match.
[[nodiscard]] std::string parse_text(std::string_view text, const Location& location,
                                     std::string_view name);

/// Any of both.
[[nodiscard]] Value parse_value(Kind kind, std::string_view text, const Location& location,
                                std::string_view name);

/// The elements of "[1, 2]" or "(1, 2)" as they stand there; commas in quotes do not separate.
[[nodiscard]] std::vector<std::string> split_list(std::string_view text, const Location& location,
                                                  std::string_view name);

/// Reads the default value of a field in .msg form.
[[nodiscard]] std::vector<Value> parse_default(const Type& type, std::string_view text,
                                               const Location& location, std::string_view name);

/// Throws DefinitionError unless the default has as many and as long elements as the type takes.
void check_default(const Field& field);

[[nodiscard]] std::string_view trim(std::string_view text);

/// Number as a literal that reads back as the same; the shortest one.
[[nodiscard]] std::string number_text(const Value& value);

}  // namespace pipescout::generator
