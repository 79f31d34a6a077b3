// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace pipescout {

/// The content of a file; nothing when it cannot be read.
[[nodiscard]] std::optional<std::string> map_text_of(const std::filesystem::path& path);
/// A JSON document. Throws MapFileError naming the file.
[[nodiscard]] nlohmann::json map_json_of(const std::filesystem::path& path);
/// The shortest text that reads back as the same number, whatever the locale.
[[nodiscard]] std::string map_number(double value);

}  // namespace pipescout
