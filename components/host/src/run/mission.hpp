// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <vector>

#include "core/composition.hpp"
#include "core/mission_folder.hpp"
#include "pipescout/runtime/component_registry.hpp"
#include "run/run.hpp"

/// What every way to run a composition begins and ends with.
namespace pipescout::host {

/// The run cannot start; what() says why.
class StartError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A composition whose components exist, and where its mission goes.
struct Mission {
  Composition composition;
  std::filesystem::path folder;
  std::optional<ReservedMissionFolder> reserved;

  /// Throws YamlError, CompositionError, StartError.
  void open(const RunOptions& options, const ComponentRegistry& registry);
};

/// `--param k:=v` is for all components; when none has it, it is misspelt. `parameters`: of each
/// component. Throws StartError.
void check_parameter_arguments(const Composition& composition,
                               const std::vector<std::vector<NamedParameter>>& parameters);

/// What versions.yaml of the mission says, see `versions_yaml`.
[[nodiscard]] std::string versions_of(const Composition& composition,
                                      const ComponentRegistry& registry);

/// A bag of the mission holds a message, or cannot be read.
[[nodiscard]] bool holds_messages(const std::filesystem::path& mission_folder);

/// Writes the summary of the sections that components wrote, and prints it. False when it is not
/// whole or not written; why is on stderr.
bool finish_summary(const std::filesystem::path& mission_folder);

/// The same with the tables of the mission's bags, which the command `summary` makes in a process
/// of its own; without bags or that command only that of the sections. For the end of the process:
/// signals that were blocked end it from now on.
bool summarise_mission(const std::filesystem::path& mission_folder);

}  // namespace pipescout::host
