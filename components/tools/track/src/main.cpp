// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "image_source.hpp"
#include "pipescout/bags/topic_choice.hpp"
#include "pipescout/command_line/command.hpp"
#include "pipescout/command_line/progress_printer.hpp"
#include "pipescout/command_line/results.hpp"
#include "pipescout/files/whole_file.hpp"
#include "pipescout/leak_survey/picture_recording.hpp"
#include "pipescout/leak_survey/survey_settings.hpp"
#include "pipescout/thermal_files/yaml_entries.hpp"
#include "pipescout/thermal_parameters/survey_parameters.hpp"
#include "tracking_run.hpp"

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
  std::size_t overlays = 30;
};

SurveySettings survey_of(const Arguments& arguments, const fs::path& folder) {
  const fs::path file = folder / kSurveyFile;
  return parse_survey_settings(fs::exists(file) ? text_of(file) : "", file.string(),
                               read_survey_parameters, thermal::detector_preset(arguments.preset));
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
  const fs::path out = arguments.out;
  command_line::require_new_folder(out);
  const fs::path folder = fs::is_directory(source) ? source : source.parent_path();
  const SurveySettings survey = survey_of(arguments, folder);
  const ThermalSettings thermal = thermal_of(arguments, folder);
  command_line::ProgressPrinter printer(std::cerr, isatty(STDERR_FILENO) == 1);
  TrackingRun run(
      survey,
      {.seed = arguments.seed, .overlays = out / "overlays", .overlay_count = arguments.overlays});
  const ImageSink sink{
      .take = [&](const SourceImage& image) { run.take(image); },
      .fail = [&](const std::string& name, const std::string& problem,
                  const std::string& advice) { run.fail(name, problem, advice); },
      .progress =
          [&](std::size_t done, std::size_t total) {
            run.expect(total);
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
  for (const std::string& problem : run.problems()) {
    std::cerr << "warning: " << problem << '\n';
  }
  const PipeTracks& tracks = run.tracks();
  fs::create_directories(out);
  replace_file(out / "track.csv", tracks.csv());
  std::cout << tracks.summary() << (out / "track.csv").string() << '\n';
  if (run.overlays() > 0) {
    std::cout << (out / "overlays").string() << ": " << run.overlays()
              << (run.overlays() == 1 ? " picture" : " pictures") << " of the track\n";
  }
  for (const std::string& advice : run.advice()) {
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
  app.add_option("--out", arguments->out, "New folder for track.csv and overlays/")->required();
  app.add_option("--topic", arguments->topic, "Topic of the images, of a bag with several");
  app.add_option("--thermal", arguments->thermal,
                 "Conversion of counts and grey levels to temperatures; instead of thermal.yaml")
      ->check(CLI::ExistingFile);
  std::vector<std::string> names;
  for (const thermal::DetectorPreset preset : thermal::kDetectorPresets) {
    names.emplace_back(to_string(preset));
  }
  app.add_option("--preset", arguments->preset,
                 "Pipes to look for; instead of that of survey.yaml, or " +
                     std::string(to_string(thermal::kDefaultPreset)))
      ->check(CLI::IsMember(names));
  app.add_option("--seed", arguments->seed, "Of the particles");
  app.add_option("--overlays", arguments->overlays, "Pictures with the track drawn over the image")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  app.callback([=, &action] { action = [=] { return track(*arguments); }; });
}

}  // namespace
}  // namespace pipescout::track

int main(int argc, char** argv) {
  return pipescout::command_line::command_main(PIPESCOUT_SUMMARY, "pipescout track",
                                               pipescout::track::add_commands, argc, argv);
}
