// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace pipescout::command_line {

/// "; did you mean 'odometry_fusion'?"; empty when none of the known names is near enough.
[[nodiscard]] std::string suggestion(const std::string& misspelt,
                                     const std::vector<std::string>& known);

}  // namespace pipescout::command_line
