// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "pipescout/runtime/parameter_value.hpp"

namespace pipescout::host {

/// A text has a malformed substitution, or one whose value is not known.
class SubstitutionError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Where the values of substitutions come from.
struct SubstitutionSources {
  std::map<std::string, std::string, std::less<>> arguments;
  std::function<std::optional<std::string>(const std::string& name)> environment;
  /// Folder share/PACKAGE of an installed package.
  std::function<std::optional<std::string>(const std::string& package)> share;
  std::optional<std::string> mission_folder;
};

/// Replaces in a text
///     $(arg NAME [DEFAULT])   an argument of the composition
///     $(env NAME [DEFAULT])   an environment variable
///     $(share PACKAGE)        the folder share/PACKAGE of an installed package
///     $(mission_folder)       the absolute path of the mission folder
/// A default reaches to the closing parenthesis and may hold substitutions itself; what is
/// substituted is not looked at again. Throws SubstitutionError.
[[nodiscard]] std::string substitute(std::string_view text, const SubstitutionSources& sources);

/// True when the whole text is one argument or environment variable, so that its value stands for
/// itself and may be another type than text. (The others are paths.)
[[nodiscard]] bool has_type_of_its_value(std::string_view text);

/// The value of a text that stands for itself, as `parse_parameter_value`, but nothing of it gets
/// lost: where YAML would take a part of a plain text only ("a #1"), it stays the text that it is.
/// Throws std::invalid_argument as that.
[[nodiscard]] ParameterValue typed_text(const std::string& text);

/// The sources of this process; arguments and mission folder are left empty.
[[nodiscard]] SubstitutionSources process_sources();

}  // namespace pipescout::host
