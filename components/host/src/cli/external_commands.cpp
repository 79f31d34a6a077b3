// SPDX-License-Identifier: Apache-2.0
#include "cli/external_commands.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <system_error>
#include <utility>

#include "cli/command.hpp"
#include "pipescout/runtime/component_registry.hpp"

namespace pipescout::host {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPrefix = "pipescout-";

bool can_be_a_name(std::string_view name) {
  constexpr std::string_view kOthers = "-_";
  return !name.empty() && name.front() != '-' &&
         std::all_of(name.begin(), name.end(), [&](unsigned char c) {
           return std::isalnum(c) != 0 || kOthers.find(static_cast<char>(c)) != kOthers.npos;
         });
}

bool is_executable(const fs::path& file) {
  std::error_code error;
  return fs::is_regular_file(file, error) && access(file.c_str(), X_OK) == 0;
}

std::vector<fs::path> entries(const fs::path& folder) {
  std::vector<fs::path> paths;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    paths.push_back(entry->path());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

/// The folders of a prefix that hold executables: bin/, then lib/PACKAGE/.
std::vector<fs::path> folders_of(const fs::path& prefix) {
  std::vector<fs::path> folders{prefix / "bin"};
  for (auto& folder : entries(prefix / "lib")) {
    std::error_code error;
    if (fs::is_directory(folder, error)) {
      folders.push_back(std::move(folder));
    }
  }
  return folders;
}

ExternalCommand described(std::string name, fs::path executable, const fs::path& prefix) {
  std::ifstream stream(prefix / "share/pipescout/commands" / name);
  std::string summary;
  std::string second;
  std::getline(stream, summary);
  std::getline(stream, second);
  return {std::move(name), std::move(executable), std::move(summary), second == "completion"};
}

constexpr std::array kProjectCommands{
#include "project_commands.inc"
};

}  // namespace

ExternalCommandPlaces external_command_places() {
  ExternalCommandPlaces places{.prefixes = ComponentRegistry::default_prefixes(), .folders = {}};
  const char* path = std::getenv("PATH");
  std::istringstream stream(path != nullptr ? path : "");
  for (std::string folder; std::getline(stream, folder, ':');) {
    // An empty entry is the working folder to a shell; a command that depends on it is a trap.
    if (!folder.empty()) {
      places.folders.emplace_back(folder);
    }
  }
  return places;
}

std::optional<ExternalCommand> find_external_command(std::string_view name,
                                                     const ExternalCommandPlaces& places) {
  if (!can_be_a_name(name)) {
    return std::nullopt;
  }
  const std::string file = std::string(kPrefix) + std::string(name);
  for (const auto& prefix : places.prefixes) {
    for (const auto& folder : folders_of(prefix)) {
      if (is_executable(folder / file)) {
        return described(std::string(name), folder / file, prefix);
      }
    }
  }
  for (const auto& folder : places.folders) {
    if (is_executable(folder / file)) {
      return described(std::string(name), folder / file, folder.parent_path());
    }
  }
  return std::nullopt;
}

std::vector<ExternalCommand> list_external_commands(const ExternalCommandPlaces& places) {
  std::map<std::string, ExternalCommand> commands;
  const auto add_those_in = [&commands](const fs::path& folder, const fs::path& prefix) {
    for (const auto& file : entries(folder)) {
      const auto file_name = file.filename().string();
      if (!file_name.starts_with(kPrefix) || !is_executable(file)) {
        continue;
      }
      const auto name = file_name.substr(kPrefix.size());
      if (can_be_a_name(name)) {
        commands.try_emplace(name, described(name, file, prefix));
      }
    }
  };
  for (const auto& prefix : places.prefixes) {
    for (const auto& folder : folders_of(prefix)) {
      add_those_in(folder, prefix);
    }
  }
  for (const auto& folder : places.folders) {
    add_those_in(folder, folder.parent_path());
  }
  std::vector<ExternalCommand> list;
  for (auto& [name, command] : commands) {
    list.push_back(std::move(command));
  }
  return list;
}

std::span<const ProjectCommand> project_commands() {
  return kProjectCommands;
}

void become(const ExternalCommand& command, const std::vector<std::string>& arguments) {
  std::vector<std::string> words{command.executable.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (auto& word : words) {
    pointers.push_back(word.data());
  }
  pointers.push_back(nullptr);
  ::execv(command.executable.c_str(), pointers.data());
  throw CommandError("error: cannot run " + command.executable.string() + ": " +
                     std::strerror(errno));
}

}  // namespace pipescout::host
