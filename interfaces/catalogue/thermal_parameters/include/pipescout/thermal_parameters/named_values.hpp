// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

#include "pipescout/runtime/parameters.hpp"

/// Enumerators as the values of parameters. `names`: pairs of an enumerator and its name.
namespace pipescout {

/// Throws std::logic_error for an enumerator that has no name.
template <class Names, class Value>
[[nodiscard]] std::string name_of(const Names& names, Value value) {
  for (const auto& [known, name] : names) {
    if (known == value) {
      return name;
    }
  }
  throw std::logic_error("a value without a name");
}

/// Throws std::invalid_argument naming the parameter, its value and the valid names.
template <class Names>
[[nodiscard]] auto value_of(const Names& names, const Parameter<std::string>& parameter) {
  const std::string text = parameter.get();
  std::string known;
  for (const auto& [value, name] : names) {
    if (text == name) {
      return value;
    }
    known += (known.empty() ? "'" : ", '") + std::string(name) + "'";
  }
  throw std::invalid_argument("parameter '" + parameter.name() + "': '" + text +
                              "' is not one of " + known);
}

/// Adds the name of the parameter to exceptions of `make`.
template <class Make>
auto naming(const Parameter<std::vector<double>>& parameter, Make make) {
  try {
    return make();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("parameter '" + parameter.name() + "': " + error.what());
  }
}

}  // namespace pipescout
