// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

namespace pipescout::command_line {

/// share/PACKAGE of the first prefix that has it: those of AMENT_PREFIX_PATH and CMAKE_PREFIX_PATH,
/// then the one that this executable is installed in and, for colcon's isolated layout, its
/// neighbours.
[[nodiscard]] std::optional<std::string> installed_share_folder(const std::string& package);

}  // namespace pipescout::command_line
