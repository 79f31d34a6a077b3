// SPDX-License-Identifier: Apache-2.0
#include "run/mission.hpp"

#include <chrono>
#include <iostream>
#include <set>
#include <string>

#include "pipescout/command_line/mission_summary.hpp"
#include "pipescout/command_line/suggestion.hpp"

namespace pipescout::host {

namespace fs = std::filesystem;

void Mission::open(const RunOptions& options, const ComponentRegistry& registry) {
  auto inputs = options.inputs();
  inputs.mission_folder = [&](const std::string& mission) {
    if (options.out) {
      folder = fs::absolute(*options.out);
    } else {
      reserved.emplace(fs::current_path(), mission, std::chrono::system_clock::now());
      folder = reserved->path();
    }
    return folder.string();
  };
  composition = load_composition(options.composition, inputs);
  for (const auto& entry : composition.components) {
    try {
      static_cast<void>(registry.find(entry.type));
    } catch (const UnknownComponent& error) {
      throw StartError(entry.type_location + ": " + error.what());
    }
  }
}

void check_parameter_arguments(const Composition& composition,
                               const std::vector<std::vector<NamedParameter>>& parameters) {
  std::set<std::string> known;
  for (const auto& component : parameters) {
    for (const auto& parameter : component) {
      known.insert(parameter.name);
    }
  }
  for (const auto& entry : composition.components) {
    for (const auto& parameter : entry.parameters) {
      if (parameter.from_wildcard && parameter.source.starts_with("--param ") &&
          !known.contains(parameter.name)) {
        throw StartError(parameter.source + ": no component has a parameter '" + parameter.name +
                         "'" +
                         command_line::suggestion(parameter.name, {known.begin(), known.end()}));
      }
    }
  }
}

bool finish_summary(const fs::path& mission_folder) {
  try {
    const auto summary = command_line::read_summary(mission_folder);
    command_line::write_summary(mission_folder, summary);
    if (!summary.sections.empty()) {
      command_line::print_summary(std::cout, summary);
      std::cout << '\n';
    }
    std::cout << "mission folder: " << mission_folder.string() << std::endl;
    for (const auto& problem : summary.problems) {
      std::cerr << "error: " << problem << '\n';
    }
    return summary.problems.empty();
  } catch (const std::exception& error) {
    std::cerr << "error: " << error.what() << '\n';
    return false;
  }
}

}  // namespace pipescout::host
