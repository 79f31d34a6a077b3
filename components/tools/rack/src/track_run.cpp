// SPDX-License-Identifier: Apache-2.0
#include "track_run.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "overlay.hpp"
#include "pipescout/command_line/results.hpp"

namespace pipescout::rack {
namespace {

using rack_vision::RackTrackerResult;
using rack_vision::TrackStatus;

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

void check_size(const SourceImage& image, const geometry::CameraParameters& camera) {
  if (image.view.width != camera.width || image.view.height != camera.height) {
    throw std::runtime_error(
        image.name + ": the image has " + size_text(image.view.width, image.view.height) +
        " pixels; the camera's calibration is for " + size_text(camera.width, camera.height) +
        " (image_width, image_height)");
  }
}

TrackedImage record(const SourceImage& image, const RackTrackerResult& result) {
  TrackedImage tracked{.name = image.name,
                       .stamp = image.stamp,
                       .status = result.status,
                       .reason = std::string(result.reason),
                       .edge_samples = result.edge_samples,
                       .edge_samples_found = result.edge_samples_found,
                       .points = result.points,
                       .points_matched = result.points_matched};
  if (result.status == TrackStatus::kTracking) {
    tracked.quality = result.quality;
    tracked.T_rack_camera = result.T_rack_camera;
    tracked.covariance = result.covariance;
  }
  return tracked;
}

std::vector<PipeOffset> offsets_of(const rack_vision::RackModel& model,
                                   const RackTrackerResult& result) {
  std::vector<PipeOffset> offsets;
  for (std::size_t i = 0; i < model.pipes.size() && i < result.offsets.size(); ++i) {
    offsets.push_back({.pipe = model.pipes[i].name,
                       .offset = result.offsets[i],
                       .deviation = std::sqrt(std::max(0.0, result.offset_variances[i])),
                       .movable = model.pipes[i].movable});
  }
  return offsets;
}

std::vector<PipeShapeFound> shapes_of(const rack_vision::RackModel& model,
                                      const RackTrackerResult& result) {
  std::vector<PipeShapeFound> shapes;
  for (const rack_vision::PipeShapeEstimate& each : result.shapes) {
    shapes.push_back({.pipe = model.pipes[each.pipe].name,
                      .found = each.found,
                      .shape = each.shape,
                      .deviation = each.deviation});
  }
  return shapes;
}

}  // namespace

TrackRun track_images(ImageSource& source, const rack_vision::RackModel& model,
                      const geometry::Camera& camera, const TrackOptions& options,
                      const Progress& progress) {
  rack_vision::RackLocalization localization(model, camera, options.localization);
  localization.set_hint(options.hint);
  if (options.start &&
      !localization.set_pose(options.start->T_rack_camera, options.start->covariance)) {
    throw std::invalid_argument("the initial pose is not usable");
  }
  Overlay overlay(model, camera);
  TrackRun run;
  run.along = rack_vision::main_direction(model);
  const std::size_t all = source.count();
  const std::size_t step =
      options.overlay_count == 0 ? 0 : std::max<std::size_t>(1, all / options.overlay_count);
  while (const auto image = source.next()) {
    if (run.images.empty()) {
      check_size(*image, camera.parameters());
    }
    // Relative to the first: seconds since 1970 leave a double few digits.
    const Stamp first = run.images.empty() ? image->stamp : run.images.front().stamp;
    const double time = std::chrono::duration<double>(image->stamp - first).count();
    const RackTrackerResult result = localization.track(image->view, time);
    const bool tracked = result.status == TrackStatus::kTracking;
    if (tracked) {
      ++run.tracked;
      run.offsets = offsets_of(model, result);
      run.shapes = shapes_of(model, result);
    }
    // The first tracked one shows whether the rack was taken for what it is.
    const bool shown =
        step != 0 && (run.images.size() % step == 0 || (tracked && run.tracked == 1));
    if (shown && image->view.valid()) {
      std::filesystem::create_directories(options.overlays);
      overlay.write(
          command_line::numbered_picture(options.overlays, run.images.size(), image->name),
          image->view, result);
      ++run.overlays;
    }
    run.images.push_back(record(*image, result));
    progress(run.images.size() + source.left_out().size(), all, run.tracked);
  }
  run.starts = localization.counts();
  run.said = source.said();
  run.left_out = source.left_out();
  if (run.images.empty()) {
    throw std::runtime_error("no image can be read" +
                             (run.left_out.empty() ? std::string()
                                                   : ": " + run.left_out.front().name + ": " +
                                                         run.left_out.front().reason));
  }
  return run;
}

}  // namespace pipescout::rack
