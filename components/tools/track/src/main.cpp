// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "image_source.hpp"
#include "pipe_tracks.hpp"
#include "pipescout/bags/topic_choice.hpp"
#include "pipescout/command_line/command.hpp"
#include "pipescout/command_line/progress_printer.hpp"
#include "pipescout/files/whole_file.hpp"
#include "pipescout/leak_survey/picture_recording.hpp"
#include "pipescout/leak_survey/survey_settings.hpp"
#include "pipescout/thermal_files/yaml_entries.hpp"
#include "pipescout/thermal_parameters/survey_parameters.hpp"

namespace pipescout::track {
namespace {

namespace fs = std::filesystem;
using command_line::Action;
using command_line::kExitError;
using command_line::kExitOk;

struct Arguments {
  std::string source;
  std::string out;
  std::string topic;
  std::string thermal;
  std::string preset;
  std::uint64_t seed = 1;
};

/// What survey.yaml in the folder says; hot pipes where it says nothing.
SurveySettings survey_of(const Arguments& arguments, const fs::path& folder) {
  auto preset = thermal::detector_preset(arguments.preset);
  const fs::path file = folder / kSurveyFile;
  const bool exists = fs::exists(file);
  if (!preset && !exists) {
    preset = thermal::DetectorPreset::kHotPipes;
  }
  return parse_survey_settings(exists ? text_of(file) : "", file.string(), read_survey_parameters,
                               preset);
}

ThermalSettings thermal_of(const Arguments& arguments, const fs::path& folder) {
  if (!arguments.thermal.empty()) {
    return read_thermal_settings(arguments.thermal);
  }
  const fs::path file = folder / kThermalFile;
  return fs::exists(file) ? read_thermal_settings(file) : ThermalSettings{};
}

int track(const Arguments& arguments) {
  const fs::path source = arguments.source;
  const fs::path folder = fs::is_directory(source) ? source : source.parent_path();
  const SurveySettings survey = survey_of(arguments, folder);
  const ThermalSettings thermal = thermal_of(arguments, folder);
  command_line::ProgressPrinter printer(std::cerr, isatty(STDERR_FILENO) == 1);
  std::vector<std::string> problems;
  PipeTracks tracks(survey.detector, arguments.seed);
  const ImageSink sink{
      .take = [&](const SourceImage& image) { tracks.take(image); },
      .fail =
          [&](const std::string& name, const std::string& problem) {
            problems.push_back(problem.find(name) == std::string::npos ? name + ": " + problem
                                                                       : problem);
            tracks.fail(name, problem);
          },
      .progress =
          [&](std::size_t done, std::size_t total) {
            const double share =
                total == 0 ? 1 : static_cast<double>(done) / static_cast<double>(total);
            printer.show(std::to_string(done) + " of " + std::to_string(total) + " images", share,
                         std::chrono::steady_clock::now());
          }};
  if (bags::is_bag(source)) {
    read_bag(source, arguments.topic, thermal, sink);
  } else {
    read_folder(source, thermal, survey.frame_rate, sink);
  }
  printer.finish();
  for (const std::string& problem : problems) {
    std::cerr << "warning: " << problem << '\n';
  }
  const fs::path out = arguments.out;
  fs::create_directories(out);
  replace_file(out / "track.csv", tracks.csv());
  std::cout << tracks.summary() << (out / "track.csv").string() << '\n';
  if (const std::string advice = tracks.advice(); !advice.empty()) {
    std::cerr << "note: " << advice << '\n';
  }
  if (tracks.failed() > 0) {
    std::cerr << "error: " << tracks.failed() << " images could not be used\n";
  }
  return tracks.failed() > 0 ? kExitError : kExitOk;
}

void add_commands(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<Arguments>();
  app.add_option(
         "source", arguments->source,
         "Folder of thermal images, with thermal.yaml and survey.yaml as `pipescout inspect "
         "leaks` takes them; or a bag (folder, .db3, .mcap, .bag)")
      ->required()
      ->check(CLI::ExistingPath);
  app.add_option("--out", arguments->out, "Folder for track.csv")->required();
  app.add_option("--topic", arguments->topic, "Topic of the images, of a bag with several");
  app.add_option("--thermal", arguments->thermal,
                 "Conversion of counts and grey levels to temperatures; instead of thermal.yaml")
      ->check(CLI::ExistingFile);
  std::vector<std::string> names;
  for (const thermal::DetectorPreset preset : thermal::kDetectorPresets) {
    names.emplace_back(to_string(preset));
  }
  app.add_option("--preset", arguments->preset,
                 "Pipes to look for; instead of that of survey.yaml, or hot_pipes")
      ->check(CLI::IsMember(names));
  app.add_option("--seed", arguments->seed, "Of the particles");
  app.callback([=, &action] { action = [=] { return track(*arguments); }; });
}

}  // namespace
}  // namespace pipescout::track

int main(int argc, char** argv) {
  return pipescout::command_line::command_main(PIPESCOUT_SUMMARY, "pipescout track",
                                               pipescout::track::add_commands, argc, argv);
}
