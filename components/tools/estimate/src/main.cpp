// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>

#include "configuration.hpp"
#include "output.hpp"
#include "pipescout/bags/bag_error.hpp"
#include "pipescout/bags/bag_reader.hpp"
#include "pipescout/command_line/command.hpp"
#include "pipescout/command_line/progress_printer.hpp"
#include "pipescout/command_line/results.hpp"
#include "pipescout/files/whole_file.hpp"
#include "recording.hpp"
#include "replay.hpp"

namespace pipescout::estimate {
namespace {

namespace fs = std::filesystem;
using command_line::Action;
using command_line::CommandError;

struct Options {
  std::string recording;
  std::string config;
  std::string out;
  bool apply_mounting = false;
};

int run(const Options& options) {
  const fs::path path = options.recording;
  if (!fs::exists(path)) {
    throw CommandError(path.string() + ": no such file or folder");
  }
  command_line::require_new_folder(options.out);
  Configuration given;
  if (!options.config.empty()) {
    given = read_configuration(options.config, {});
  }
  command_line::ProgressPrinter printer(std::cerr, isatty(STDERR_FILENO) != 0);
  const Progress progress = [&](const std::string& what, double share) {
    printer.show(what, share, steady_now());
  };
  Recording recording;
  try {
    recording = given.sources.empty() ? read_bag(path, given.wheels, given.further, progress)
                                      : read_csv_folder(path, options.config);
  } catch (const bags::BagError& error) {
    throw CommandError(std::string(error.what()) +
                       " (a folder of CSV files needs --config with 'sources')");
  }
  Guess guessed = guess(recording, given.further);
  Configuration configuration = guessed.configuration;
  if (!options.config.empty()) {
    configuration = read_configuration(options.config, guessed.configuration);
  }
  Trajectory trajectory;
  try {
    trajectory = estimate_trajectory(recording, configuration, options.apply_mounting, progress);
  } catch (const std::invalid_argument& error) {
    printer.finish();
    std::string text = "# No trajectory\n\n";
    for (const auto& sentences : {guessed.said, recording.faults(), recording.remarks}) {
      for (const std::string& each : sentences) {
        text += "- " + each + "\n";
      }
    }
    text += std::string("- ") + error.what() + "\n";
    std::cout << text;
    fs::create_directories(options.out);
    replace_file(fs::path(options.out) / "configuration.yaml", to_yaml(configuration));
    replace_file(fs::path(options.out) / "report.md", text);
    throw CommandError(error.what());
  }
  printer.finish();

  const fs::path out = options.out;
  fs::create_directories(out);
  replace_file(out / "configuration.yaml", to_yaml(configuration));
  const std::string text = report(recording, configuration, trajectory, guessed.said);
  replace_file(out / "report.md", text);
  std::cout << text;
  if (trajectory.points.empty()) {
    throw CommandError("the estimator did not start, so there is no trajectory; " +
                       (out / "report.md").string() + " says why");
  }
  replace_file(out / "trajectory.csv", trajectory_csv(recording, trajectory));
  replace_file(out / "trajectory.tum", trajectory_tum(recording, trajectory));
  replace_file(out / "trajectory.svg", trajectory_svg(trajectory));
  if (trajectory.datum) {
    replace_file(out / "trajectory.geojson", trajectory_geojson(trajectory));
  }
  return command_line::kExitOk;
}

void add_commands(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  app.add_option("recording", options->recording,
                 "A bag (folder, .db3, .mcap, .bag) with ordinary ROS topics; or a folder of CSV "
                 "files, with 'sources' in --config")
      ->required();
  app.add_option("--config", options->config,
                 "What is used as what; without it a guess is made and written to "
                 "OUT/configuration.yaml");
  app.add_option("--out", options->out, "New folder for trajectory, plot and report")->required();
  app.add_flag("--apply-mounting", options->apply_mounting,
               "Use the mounting of the IMU that the motion shows, if the evidence is strong");
  app.callback([=, &action] { action = [options] { return run(*options); }; });
}

}  // namespace
}  // namespace pipescout::estimate

int main(int argc, char** argv) {
  return pipescout::command_line::command_main(PIPESCOUT_SUMMARY, "pipescout estimate",
                                               pipescout::estimate::add_commands, argc, argv);
}
