// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "model.hpp"

/// How the formats and C++ write a type.
namespace pipescout::generator {

/// "bool", "byte", "char", "int8", ..., "float32", "float64", "string", "wstring"; "" for messages.
[[nodiscard]] std::string_view msg_name(Kind kind) noexcept;
/// "boolean", "octet", "char", "int8", ..., "float", "double", "string", "wstring"; "" for
/// messages.
[[nodiscard]] std::string_view idl_name(Kind kind) noexcept;
/// "bool", "std::uint8_t", ..., "std::string", "std::u16string"; "" for messages.
[[nodiscard]] std::string_view cpp_name(Kind kind) noexcept;

/// The kind that .msg files call so.
[[nodiscard]] std::optional<Kind> kind_of_msg_name(std::string_view name) noexcept;

/// The type with its array or sequence, as in "string<=5[<=3]"; messages of `package` without it.
[[nodiscard]] std::string msg_type(const Type& type, std::string_view package);
/// "std::array<double, 9>", "std_msgs::msg::Header".
[[nodiscard]] std::string cpp_type(const Type& type);
/// One element: "double" of std::vector<double>.
[[nodiscard]] std::string cpp_element_type(const Type& type);

}  // namespace pipescout::generator
