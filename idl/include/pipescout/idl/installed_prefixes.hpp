// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

namespace pipescout {

/// Install prefixes in the order of search: the prefixes of `AMENT_PREFIX_PATH`, of
/// `CMAKE_PREFIX_PATH`, that of the running executable (which is in bin/ or lib/PACKAGE/), and in
/// colcon's isolated layout those of the other packages. Each existing folder once, in canonical
/// form.
[[nodiscard]] std::vector<std::filesystem::path> installed_prefixes();

/// The folders that exist, each once, in the order of the first mention and in canonical form.
[[nodiscard]] std::vector<std::filesystem::path> without_repetitions(
    const std::vector<std::filesystem::path>& folders);

}  // namespace pipescout
