// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "image_bag.hpp"
#include "image_folder.hpp"
#include "pipescout/bags/bag_error.hpp"
#include "pipescout/bags/topic_choice.hpp"
#include "pipescout/camera_file/camera_file.hpp"
#include "pipescout/command_line/command.hpp"
#include "pipescout/command_line/formatted.hpp"
#include "pipescout/command_line/progress_printer.hpp"
#include "pipescout/command_line/results.hpp"
#include "pipescout/files/whole_file.hpp"
#include "pipescout/geometry/camera_calibration.hpp"
#include "pipescout/rack_file/rack_file.hpp"
#include "pipescout/rack_vision/visual_servo.hpp"
#include "track_report.hpp"
#include "track_run.hpp"

namespace pipescout::rack {
namespace {

namespace fs = std::filesystem;
using command_line::Action;
using command_line::CommandError;
using command_line::formatted;

constexpr double kDegree = std::numbers::pi / 180;

struct Arguments {
  std::string images;
  std::string rack;
  std::string camera;
  std::string out;
  std::string topic;
  std::string times;
  double rate = 0;  // 0: not given
  std::vector<double> start;
  std::vector<double> start_rotation;
  std::vector<double> start_deviation{0.05, 3};  // m, degrees: as rack_localizer has them
  std::vector<double> near;
  std::vector<double> heading;
  double offset_deviation = rack_vision::RackTrackerParameters{}.offset_sigma;
  double row_time = 0;  // s; 0: global shutter
  std::size_t overlays = 30;
};

geometry::Camera camera_for(const Arguments& arguments, bool bag, std::vector<std::string>& said) {
  geometry::CameraParameters camera;
  std::string source = arguments.camera;
  if (!arguments.camera.empty()) {
    camera = read_camera(arguments.camera, said);
  } else {
    const auto found = bag ? camera_of_bag(arguments.images, arguments.topic) : std::nullopt;
    if (!found) {
      throw CommandError(arguments.images + (bag ? ": no calibration (sensor_msgs/CameraInfo) next "
                                                   "to the images in the bag; give --camera"
                                                 : ": images from a folder need --camera"));
    }
    camera = found->camera;
    source = "topic " + found->topic;
  }
  said.push_back(formatted("%s: %d x %d pixels, focal length %.1f px, %s.", source.c_str(),
                           camera.width, camera.height, camera.focal_length,
                           geometry::ros_distortion(camera).model.c_str()));
  return geometry::Camera(camera);
}

std::unique_ptr<ImageSource> open(const Arguments& arguments, bool bag) {
  if (bag) {
    if (arguments.rate > 0 || !arguments.times.empty()) {
      throw CommandError("--rate and --times are for folders of images; a bag has times");
    }
    return open_bag(arguments.images, arguments.topic);
  }
  if (!arguments.topic.empty()) {
    throw CommandError("--topic is for bags; " + arguments.images + " is a folder of images");
  }
  FolderTimes times;
  if (arguments.rate > 0) {
    times.rate = arguments.rate;
  }
  if (!arguments.times.empty()) {
    times.table = arguments.times;
  }
  return open_folder(arguments.images, times);
}

Eigen::Vector3d three(const std::vector<double>& values) {
  return {values.at(0), values.at(1), values.at(2)};
}

Start start_of(const Arguments& arguments) {
  const geometry::SE3 ahead(geometry::SO3::about_z(std::numbers::pi / 2), Eigen::Vector3d::Zero());
  const geometry::SO3 rotation =
      arguments.start_rotation.empty()
          ? (ahead * rack_vision::downward_camera()).rotation()
          : geometry::SO3::from_roll_pitch_yaw(kDegree * three(arguments.start_rotation));
  const double position = arguments.start_deviation.at(0);
  const double angle = kDegree * arguments.start_deviation.at(1);
  Start start{.T_rack_camera = geometry::SE3(rotation, three(arguments.start))};
  start.covariance.diagonal() << Eigen::Vector3d::Constant(position * position),
      Eigen::Vector3d::Constant(angle * angle);
  return start;
}

TrackOptions options_for(const Arguments& arguments, std::vector<std::string>& said) {
  TrackOptions options;
  options.localization.tracker.offset_sigma = arguments.offset_deviation;
  options.localization.tracker.row_time = arguments.row_time;
  if (!arguments.start.empty()) {
    options.start = start_of(arguments);
    said.emplace_back("The first pose: as given by --start.");
  } else {
    said.emplace_back("The first pose: from the images alone" +
                      std::string(arguments.near.empty() && arguments.heading.empty()
                                      ? "; --start, --near and --heading would help."
                                      : ", near what --near and --heading say."));
  }
  if (!arguments.near.empty()) {
    const double deviation = arguments.near.at(3);
    options.hint.x = {arguments.near.at(0), deviation};
    options.hint.y = {arguments.near.at(1), deviation};
    options.hint.z = {arguments.near.at(2), deviation};
  }
  if (!arguments.heading.empty()) {
    options.hint.heading = {kDegree * arguments.heading.at(0), kDegree * arguments.heading.at(1)};
  }
  options.overlay_count = arguments.overlays;
  options.overlays = fs::path(arguments.out) / "overlays";
  return options;
}

int track(const Arguments& arguments) {
  const fs::path out = arguments.out;
  if (!fs::exists(arguments.images)) {
    throw CommandError(arguments.images + ": no such file or folder");
  }
  command_line::require_new_folder(out);
  std::vector<std::string> said;
  const rack_vision::RackModel model = read_rack(arguments.rack);
  said.push_back(formatted("%s: %zu pipes, %zu supports.", arguments.rack.c_str(),
                           model.pipes.size(), model.supports.size()));
  const bool bag = bags::is_bag(arguments.images);
  const geometry::Camera camera = camera_for(arguments, bag, said);
  const TrackOptions options = options_for(arguments, said);
  const std::unique_ptr<ImageSource> source = open(arguments, bag);

  command_line::ProgressPrinter printer(std::cerr, isatty(STDERR_FILENO) == 1);
  const TrackRun run = track_images(
      *source, model, camera, options, [&](std::size_t done, std::size_t all, std::size_t tracked) {
        const double share = all > 0 ? static_cast<double>(done) / static_cast<double>(all) : 1;
        printer.show(formatted("%zu of %zu images, tracked in %zu", done, all, tracked), share,
                     std::chrono::steady_clock::now());
      });
  printer.finish();

  fs::create_directories(out);
  const std::string text = report(run, said);
  replace_file(out / "poses.csv", poses_csv(run));
  replace_file(out / "poses.tum", poses_tum(run));
  replace_file(out / "images.csv", images_csv(run));
  replace_file(out / "report.md", text);
  std::cout << text;
  if (run.tracked == 0) {
    throw CommandError("error: the rack was not tracked in any image; " +
                       (out / "report.md").string() + " says why");
  }
  return command_line::kExitOk;
}

void add_commands(CLI::App& app, Action& action) {
  app.require_subcommand(1);
  auto arguments = std::make_shared<Arguments>();
  Arguments& a = *arguments;
  auto* command = app.add_subcommand(
      "track",
      "Pose of the camera in each image of a pipe rack; writes poses, pictures and a report");
  command
      ->add_option(
          "images", a.images,
          "Folder of images, or a bag (folder, .db3, .mcap, .bag) with sensor_msgs/Image or "
          "CompressedImage")
      ->required();
  command->add_option("--rack", a.rack, "Rack file: the geometry of the pipes")
      ->required()
      ->check(CLI::ExistingFile);
  command
      ->add_option("--camera", a.camera,
                   "Calibration as ROS' camera_calibration writes it (YAML); for a bag with "
                   "sensor_msgs/CameraInfo not needed")
      ->check(CLI::ExistingFile);
  command
      ->add_option("--out", a.out,
                   "New folder for poses.csv, poses.tum, images.csv, overlays/, report.md")
      ->required();
  command->add_option("--topic", a.topic, "Of the images, where a bag has several");
  auto* rate = command->add_option("--rate", a.rate, "Images per second of a folder without times")
                   ->check(CLI::Range(1e-3, 1e5));
  command
      ->add_option("--times", a.times, "CSV file with the columns image and stamp (s) for a folder")
      ->check(CLI::ExistingFile)
      ->excludes(rate);
  auto* start =
      command
          ->add_option("--start", a.start, "X Y Z of the camera in the first image, rack frame, m")
          ->expected(3);
  command
      ->add_option(
          "--start-rotation", a.start_rotation,
          "Roll, pitch, yaw of the camera's optical frame there, degrees; without it straight "
          "down, the upper border of the image ahead along the flow")
      ->expected(3)
      ->needs(start);
  command
      ->add_option("--start-deviation", a.start_deviation,
                   "Standard deviations of position and rotation, m and degrees")
      ->expected(2)
      ->needs(start)
      ->check(CLI::Range(1e-6, 1e6))
      ->capture_default_str();
  command
      ->add_option("--near", a.near,
                   "X Y Z of the camera and their standard deviation, m, roughly, for a start from "
                   "the images alone")
      ->expected(4);
  command
      ->add_option(
          "--heading", a.heading,
          "Angle from rack x to the image's x axis about rack z and its standard deviation, "
          "degrees: 0 30 for an image whose upper border is ahead along the flow")
      ->expected(2);
  command
      ->add_option("--offset-deviation", a.offset_deviation,
                   "Standard deviation of the pipes' lateral positions against the rack file, m")
      ->check(CLI::Range(1e-6, 1e3))
      ->capture_default_str();
  command
      ->add_option("--row-time", a.row_time,
                   "From the exposure of one row to that of the next, s (rolling shutter)")
      ->check(CLI::Range(0.0, 1e-3))
      ->capture_default_str();
  command->add_option("--overlays", a.overlays, "Pictures with the model drawn over the image")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  command->callback([=, &action] { action = [=] { return track(*arguments); }; });
}

}  // namespace
}  // namespace pipescout::rack

int main(int argc, char** argv) {
  return pipescout::command_line::command_main(PIPESCOUT_SUMMARY, "pipescout rack",
                                               pipescout::rack::add_commands, argc, argv);
}
