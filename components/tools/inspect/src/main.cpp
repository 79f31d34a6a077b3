// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <chrono>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "inspect_welds.hpp"
#include "pipescout/command_line/command.hpp"
#include "pipescout/command_line/progress_printer.hpp"
#include "pipescout/leak_store/leak_exports.hpp"
#include "pipescout/leak_survey/leak_survey.hpp"
#include "pipescout/thermal_parameters/survey_parameters.hpp"

namespace pipescout::inspect {
namespace {

using command_line::Action;
using command_line::kExitError;
using command_line::kExitOk;

struct Arguments {
  std::string pictures;
  std::string out;
  std::string poses;
  std::string preset;
};

/// "1 picture", "2 pictures".
std::string of(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

/// "[##########..........] 12 of 24 pictures"
std::string bar(std::size_t done, std::size_t total) {
  constexpr std::size_t kWidth = 20;
  const std::size_t filled = total == 0 ? kWidth : kWidth * done / total;
  return "[" + std::string(filled, '#') + std::string(kWidth - filled, '.') + "] " +
         std::to_string(done) + " of " + std::to_string(total) + " pictures";
}

int inspect_leaks(const Arguments& arguments) {
  const bool terminal = isatty(STDERR_FILENO) == 1;
  command_line::ProgressPrinter progress(std::cerr, terminal);
  std::vector<std::string> problems;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  LeakSurveyOptions options;
  options.read_parameters = read_survey_parameters;
  options.pictures = arguments.pictures;
  options.out = arguments.out;
  if (!arguments.poses.empty()) {
    options.poses = arguments.poses;
  }
  options.preset = thermal::detector_preset(arguments.preset);
  options.made = "Made by pipescout " PIPESCOUT_VERSION " at " +
                 iso_time(std::chrono::duration<double>(now).count());
  options.progress = [&progress](std::size_t done, std::size_t total) {
    progress.show(bar(done, total), static_cast<double>(done) / static_cast<double>(total),
                  std::chrono::steady_clock::now());
  };
  // Told when the bar is over: they would tear it.
  options.complain = [&problems](const std::string& problem) { problems.push_back(problem); };
  const LeakSurveyResult result = survey_leaks(options);
  progress.finish();
  for (const std::string& problem : problems) {
    std::cerr << "warning: " << problem << '\n';
  }
  std::cout << of(result.pictures, "image") << ", " << result.with_pipes << " with pipes, "
            << of(result.leak_detections, "leak") << " in single images\n"
            << of(result.raised, "finding") << " raised, " << result.candidates
            << " more with insufficient evidence\n"
            << result.degrees << (result.degrees.empty() ? "" : "\n")
            << (options.out / "report.html").string() << '\n';
  for (const std::string& advice : result.advice) {
    std::cerr << "note: " << advice << '\n';
  }
  if (result.failed > 0) {
    std::cerr << "error: " << of(result.failed, "image") << " could not be used\n";
  }
  return result.failed > 0 ? kExitError : kExitOk;
}

void add_commands(CLI::App& app, Action& action) {
  app.require_subcommand(1);
  auto arguments = std::make_shared<Arguments>();
  auto* leaks = app.add_subcommand(
      "leaks", "Detect leaks in a folder of thermal images; writes findings and a report");
  leaks
      ->add_option("pictures", arguments->pictures,
                   "Folder of images; thermal.yaml, survey.yaml and poses.csv in it describe them. "
                   "Or a mission folder with images recorded by leak_inspector")
      ->required()
      ->check(CLI::ExistingDirectory);
  leaks
      ->add_option("--out", arguments->out,
                   "Folder of leaks.sqlite (with the findings of all days), report.html, "
                   "leaks.geojson, leaks.kml and leaks.csv")
      ->required();
  leaks
      ->add_option("--poses", arguments->poses,
                   "CSV file with the pose of the robot for each image; instead of poses.csv")
      ->check(CLI::ExistingFile);
  std::vector<std::string> names;
  for (const thermal::DetectorPreset preset : thermal::kDetectorPresets) {
    names.emplace_back(to_string(preset));
  }
  leaks
      ->add_option("--preset", arguments->preset,
                   "Pipes to look for; instead of that of survey.yaml, or " +
                       std::string(to_string(thermal::kDefaultPreset)))
      ->check(CLI::IsMember(names));
  leaks->callback([=, &action] { action = [=] { return inspect_leaks(*arguments); }; });
  add_welds_command(app, action);
}

}  // namespace
}  // namespace pipescout::inspect

int main(int argc, char** argv) {
  return pipescout::command_line::command_main(PIPESCOUT_SUMMARY, "pipescout inspect",
                                               pipescout::inspect::add_commands, argc, argv);
}
