// SPDX-License-Identifier: Apache-2.0
#include "pipescout/command_line/results.hpp"

#include <algorithm>
#include <system_error>

#include "pipescout/command_line/command.hpp"
#include "pipescout/command_line/formatted.hpp"

namespace pipescout::command_line {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& path, const std::string& why) {
  throw CommandError(path.string() + ": " + why +
                     "; results are never overwritten: name another place for them");
}

}  // namespace

void require_new_file(const fs::path& file) {
  std::error_code ignored;
  const fs::file_status found = fs::status(file, ignored);
  if (!file.empty() && (fs::is_regular_file(found) || fs::is_directory(found))) {
    refuse(file, fs::is_directory(found) ? "is a folder" : "exists already");
  }
}

void require_new_folder(const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(folder, error)) {
    return;
  }
  if (!fs::is_directory(folder, error)) {
    refuse(folder, "exists already and is no folder");
  }
  const fs::directory_iterator first(folder, error);
  if (error) {
    throw CommandError(folder.string() + ": " + error.message());
  }
  if (first != fs::directory_iterator()) {
    refuse(folder, "is not empty (" + first->path().filename().string() + ")");
  }
}

fs::path numbered_picture(const fs::path& folder, std::size_t number, std::string name) {
  std::ranges::replace_if(
      name, [](char c) { return c == '/' || c == ' '; }, '_');
  return folder / (formatted("%06zu_", number) + name + ".png");
}

}  // namespace pipescout::command_line
