// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "bag_sections.hpp"
#include "mission_info.hpp"
#include "pipescout/bags/bag_error.hpp"
#include "pipescout/command_line/command.hpp"
#include "pipescout/command_line/mission_summary.hpp"
#include "pipescout/command_line/progress_printer.hpp"
#include "pipescout/command_line/results.hpp"
#include "pipescout/files/whole_file.hpp"

namespace pipescout::summary {
namespace {

namespace fs = std::filesystem;
using command_line::Action;
using command_line::Summary;

struct Options {
  std::string path;
  std::string json;
  std::string tables;
};

/// What the host wrote makes a folder that of a mission.
bool is_mission_folder(const fs::path& path) {
  return fs::exists(path / "mission.yaml") || fs::is_directory(path / "sections");
}

void add_bags(Summary& summary, const std::vector<fs::path>& bags, const Mission& mission) {
  command_line::ProgressPrinter progress(std::cerr, isatty(STDERR_FILENO) != 0);
  const std::string& name = bags.front().string();
  const BagSections found = summarise(
      bags, mission, [&](double share) { progress.show("reading " + name, share, steady_now()); });
  progress.finish();
  for (const auto& [section, content] : found.sections) {
    summary.add("bag." + section, content);
  }
  for (const auto& [section, content] : found.tables) {
    summary.add(section, content);
  }
  for (const std::string& problem : found.problems) {
    summary.problems.push_back(name + ": " + problem);
  }
  if (const auto lost = inputs_lost(found.sections); lost.value_or(0) > 0) {
    summary.problems.push_back(name + ": " + std::to_string(*lost) +
                               " inputs were lost: the mission is not complete");
  }
}

int run(const Options& options) {
  const fs::path path = options.path;
  if (!fs::exists(path)) {
    throw command_line::CommandError(path.string() + ": no such file or folder");
  }
  command_line::require_new_file(options.json);
  if (!options.tables.empty()) {
    command_line::require_new_folder(options.tables);
  }
  Summary summary;
  try {
    if (is_mission_folder(path)) {
      summary = command_line::read_summary(path);
      const fs::path folder = options.tables.empty() ? path : fs::path(options.tables);
      if (const auto bags = bags_of(path); !bags.empty()) {
        add_bags(summary, bags, {.info = read_mission_info(path), .folder = folder});
      }
      command_line::write_summary(path, summary);
    } else {
      summary.mission = fs::absolute(path).lexically_normal().filename().string();
      Mission mission;
      if (!options.tables.empty()) {
        mission.folder = options.tables;
      }
      add_bags(summary, {path}, mission);
    }
  } catch (const bags::BagError& error) {
    throw command_line::CommandError(error.what());
  }
  command_line::print_summary(std::cout, summary);
  if (!options.json.empty()) {
    replace_file(options.json, summary.to_json().dump(2) + "\n");
  }
  for (const std::string& problem : summary.problems) {
    std::cerr << "error: " << problem << '\n';
  }
  return summary.problems.empty() ? command_line::kExitOk : command_line::kExitError;
}

void add_commands(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  app.add_option(
         "path", options->path,
         "A bag (folder, .db3, .mcap, .bag), of stock ROS 2 too; or a mission folder, whose "
         "summary.json and data files are written anew")
      ->required();
  app.add_option("--json", options->json, "File for the tables and figures");
  app.add_option("--tables", options->tables,
                 "New folder for the data files (CSV, pictures), one folder for each subject; "
                 "default: the mission folder, and none for a bag");
  app.callback([=, &action] { action = [options] { return run(*options); }; });
}

}  // namespace
}  // namespace pipescout::summary

int main(int argc, char** argv) {
  return pipescout::command_line::command_main(PIPESCOUT_SUMMARY, "pipescout summary",
                                               pipescout::summary::add_commands, argc, argv);
}
