// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "pipescout/idl/field_access.hpp"

/// Messages as text, letter for letter as `ros2 topic echo` writes them.
namespace pipescout::host {

struct MessageFormat {
  std::optional<std::size_t> truncate = 128;  ///< elements and characters shown; none: all
  bool no_arrays = false;                     ///< show of arrays only type and length
  bool no_strings = false;                    ///< show of strings only the length
  bool flow = false;                          ///< YAML in one line
};

/// YAML that ends with a line break.
[[nodiscard]] std::string to_yaml(MessageView message, const MessageFormat& format);

/// The values in the order of the fields, separated by commas.
[[nodiscard]] std::string to_csv(MessageView message, const MessageFormat& format);

/// One field, as `--field` shows it: a message as YAML, anything else as it is, with a line break.
[[nodiscard]] std::string to_text(const FieldView& field, const MessageFormat& format);

/// A text as a YAML scalar: plain where that reads back as the same text, else quoted. `indent`:
/// spaces before the second and further lines.
[[nodiscard]] std::string yaml_text(std::string_view text, bool flow, std::size_t indent);

}  // namespace pipescout::host
