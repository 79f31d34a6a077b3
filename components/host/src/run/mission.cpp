// SPDX-License-Identifier: Apache-2.0
#include "run/mission.hpp"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <iostream>
#include <set>
#include <string>

#include "cli/external_commands.hpp"
#include "core/versions.hpp"
#include "pipescout/bags/bag_reader.hpp"
#include "pipescout/bags/topic_choice.hpp"
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

std::string versions_of(const Composition& composition, const ComponentRegistry& registry) {
  std::set<std::string> packages;
  for (const auto& entry : composition.components) {
    packages.insert(registry.find(entry.type).package);
  }
  return versions_yaml(packages, ComponentRegistry::default_prefixes());
}

bool holds_messages(const fs::path& mission_folder) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(mission_folder, error)) {
    if (entry.is_directory(error) && bags::is_bag(entry.path())) {
      try {
        if (bags::BagReader(entry.path()).metadata().messages > 0) {
          return true;
        }
      } catch (const bags::BagError&) {
        return true;
      }
    }
  }
  return false;
}

namespace {

/// Runs a program to its end. False when it failed or cannot be run, which it or stderr says.
bool run_program(const fs::path& program, const std::vector<std::string>& arguments) {
  std::vector<std::string> words{program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (auto& word : words) {
    pointers.push_back(word.data());
  }
  pointers.push_back(nullptr);
  std::cout.flush();
  pid_t child = 0;
  if (const int error =
          posix_spawn(&child, program.c_str(), nullptr, nullptr, pointers.data(), environ);
      error != 0) {
    std::cerr << "error: cannot run " << program.string() << ": " << std::strerror(error) << '\n';
    return false;
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) {
    std::cerr << "error: " << program.string() << " was ended by signal " << WTERMSIG(status)
              << '\n';
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace

bool summarise_mission(const fs::path& mission_folder) {
  if (!fs::exists(mission_folder / "bag")) {
    return finish_summary(mission_folder);
  }
  const auto command = find_external_command("summary", external_command_places());
  if (!command) {
    std::cerr << "warning: the command 'summary' is not installed: there are no tables of what was "
                 "recorded\n";
    return finish_summary(mission_folder);
  }
  sigset_t none;
  sigemptyset(&none);
  pthread_sigmask(SIG_SETMASK, &none, nullptr);
  const bool good = run_program(command->executable, {mission_folder.string()});
  std::cout << "\nmission folder: " << mission_folder.string() << std::endl;
  return good;
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
