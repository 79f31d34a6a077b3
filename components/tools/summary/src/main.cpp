// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>

#include "bag_sections.hpp"
#include "pipescout/bags/bag_error.hpp"
#include "pipescout/command_line/command.hpp"
#include "pipescout/command_line/mission_summary.hpp"
#include "pipescout/command_line/progress_printer.hpp"
#include "pipescout/files/whole_file.hpp"

namespace pipescout::summary {
namespace {

namespace fs = std::filesystem;
using command_line::Action;
using command_line::Summary;

struct Options {
  std::string path;
  std::string json;
};

/// What the host wrote makes a folder that of a mission.
bool is_mission_folder(const fs::path& path) {
  return fs::exists(path / "mission.yaml") || fs::is_directory(path / "sections");
}

void add_bag(Summary& summary, const fs::path& bag) {
  command_line::ProgressPrinter progress(std::cerr, isatty(STDERR_FILENO) != 0);
  const BagSections found = summarise(
      bag, [&](double share) { progress.show("reading " + bag.string(), share, steady_now()); });
  progress.finish();
  for (const auto& [name, section] : found.sections) {
    summary.add("bag." + name, section);
  }
  for (const std::string& problem : found.problems) {
    summary.problems.push_back(bag.string() + ": " + problem);
  }
}

int run(const Options& options) {
  const fs::path path = options.path;
  if (!fs::exists(path)) {
    throw command_line::CommandError(path.string() + ": no such file or folder");
  }
  Summary summary;
  try {
    if (is_mission_folder(path)) {
      summary = command_line::read_summary(path);
      if (const fs::path bag = path / "bag"; fs::exists(bag)) {
        add_bag(summary, bag);
      }
      command_line::write_summary(path, summary);
    } else {
      summary.mission = fs::absolute(path).lexically_normal().filename().string();
      add_bag(summary, path);
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
         "summary.json is written anew")
      ->required();
  app.add_option("--json", options->json, "File for the tables and figures");
  app.callback([=, &action] { action = [options] { return run(*options); }; });
}

}  // namespace
}  // namespace pipescout::summary

int main(int argc, char** argv) {
  return pipescout::command_line::command_main(PIPESCOUT_SUMMARY, "pipescout summary",
                                               pipescout::summary::add_commands, argc, argv);
}
