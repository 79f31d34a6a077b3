// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// Commands that are executables of their own, `pipescout-NAME`, as git has them. So a package
/// brings a command along, and a robot carries only those that it needs.
namespace pipescout::host {

struct ExternalCommand {
  std::string name;
  std::filesystem::path executable;
  std::string summary;  ///< one line, for the list of commands; empty when its package gives none
  /// It answers kComplete (pipescout/command_line/completion.hpp), as its package says.
  bool completes = false;
};

/// Where external commands are searched, the first one of a name wins.
struct ExternalCommandPlaces {
  /// bin/ and lib/PACKAGE/ of each; share/pipescout/commands/NAME there holds the summary, and
  /// "completion" as a second line where the command answers a shell.
  std::vector<std::filesystem::path> prefixes;
  std::vector<std::filesystem::path> folders;  ///< then these; each is taken for a prefix's bin/
};

/// The prefixes in which components are found too, then the folders of PATH.
[[nodiscard]] ExternalCommandPlaces external_command_places();

/// Nothing when there is none, or when `name` cannot be the name of one.
[[nodiscard]] std::optional<ExternalCommand> find_external_command(
    std::string_view name, const ExternalCommandPlaces& places);

/// All, by name.
[[nodiscard]] std::vector<ExternalCommand> list_external_commands(
    const ExternalCommandPlaces& places);

/// A command of the project, built here or not.
struct ProjectCommand {
  std::string_view name;
  std::string_view package;
};

/// Those whose packages stood beside the host's when it was built, by name: taken from the packages
/// themselves.
[[nodiscard]] std::span<const ProjectCommand> project_commands();

/// This process becomes the command. Throws CommandError when it cannot be started.
[[noreturn]] void become(const ExternalCommand& command, const std::vector<std::string>& arguments);

}  // namespace pipescout::host
