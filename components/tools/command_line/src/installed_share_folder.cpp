// SPDX-License-Identifier: Apache-2.0
#include "pipescout/command_line/installed_share_folder.hpp"

#include <filesystem>
#include <system_error>

#include "pipescout/runtime/component_registry.hpp"

namespace pipescout::command_line {

std::optional<std::string> installed_share_folder(const std::string& package) {
  if (package.find('/') != std::string::npos || package == "." || package == "..") {
    return std::nullopt;
  }
  for (const auto& prefix : ComponentRegistry::default_prefixes()) {
    std::error_code error;
    auto folder = prefix / "share" / package;
    if (std::filesystem::is_directory(folder, error)) {
      return folder.string();
    }
  }
  return std::nullopt;
}

}  // namespace pipescout::command_line
