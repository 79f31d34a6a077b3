// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

/// What software a mission was run with: versions.yaml of its folder.
namespace pipescout::host {

/// Of pipescout itself, the compiler, Fast DDS, the system, and of these packages, as their
/// package.xml below one of the prefixes says it; "unknown" where there is none. YAML.
[[nodiscard]] std::string versions_yaml(const std::set<std::string>& packages,
                                        const std::vector<std::filesystem::path>& prefixes);

}  // namespace pipescout::host
