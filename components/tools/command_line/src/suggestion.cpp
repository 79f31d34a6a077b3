// SPDX-License-Identifier: Apache-2.0
#include "pipescout/command_line/suggestion.hpp"

#include "pipescout/runtime/hint.hpp"
#include "pipescout/runtime/names.hpp"

namespace pipescout::command_line {

std::string suggestion(const std::string& misspelt, const std::vector<std::string>& known) {
  const auto nearest = nearest_name(misspelt, known);
  return nearest ? did_you_mean(misspelt, *nearest) : "";
}

}  // namespace pipescout::command_line
