// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "model.hpp"

namespace pipescout::generator {

/// A definition is wrong; what() is "file:line: name: message", or "file:line: message" where
/// nothing has a name yet.
class DefinitionError : public std::runtime_error {
 public:
  DefinitionError(const Location& location, std::string_view name, std::string_view message)
      : std::runtime_error(location.file + ":" + std::to_string(location.line) + ": " +
                           (name.empty() ? std::string() : std::string(name) + ": ") +
                           std::string(message)) {}
};

}  // namespace pipescout::generator
