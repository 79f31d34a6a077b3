// SPDX-License-Identifier: Apache-2.0
#include "map_text.hpp"

#include <array>
#include <charconv>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "pipescout/map_files/grid_file.hpp"

namespace pipescout {

std::optional<std::string> map_text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::error_code error;
  if (!file || std::filesystem::is_directory(path, error)) {
    return std::nullopt;
  }
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  return file.bad() ? std::nullopt : std::optional(std::move(text));
}

nlohmann::json map_json_of(const std::filesystem::path& path) {
  const std::optional<std::string> text = map_text_of(path);
  if (!text) {
    throw MapFileError(path.string() + ": cannot be read");
  }
  try {
    return nlohmann::json::parse(*text);
  } catch (const nlohmann::json::exception& error) {
    throw MapFileError(path.string() + ": " + error.what());
  }
}

std::string map_number(double value) {
  constexpr std::size_t kLongest = 32;
  std::array<char, kLongest> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), end};
}

}  // namespace pipescout
