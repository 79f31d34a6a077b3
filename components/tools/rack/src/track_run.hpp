// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "image_source.hpp"
#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/rack_localization.hpp"
#include "pipescout/rack_vision/rack_model.hpp"

namespace pipescout::rack {

struct Start {
  geometry::SE3 T_rack_camera;
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();  ///< as RackTrackerResult::covariance
};

struct TrackOptions {
  rack_vision::RackLocalizationParameters localization{};
  rack_vision::FirstPoseHint hint{};
  std::optional<Start> start{};
  std::filesystem::path overlays{};  ///< folder of the pictures, made with the first
  std::size_t overlay_count = 0;     ///< of pictures, spread over the images
};

/// What became of one image.
struct TrackedImage {
  std::string name;
  Stamp stamp{};
  rack_vision::TrackStatus status = rack_vision::TrackStatus::kNotStarted;
  std::string reason;
  double quality = 0;
  int edge_samples = 0;
  int edge_samples_found = 0;
  int points = 0;
  int points_matched = 0;
  geometry::SE3 T_rack_camera{};  ///< of a tracked one
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
};

struct PipeOffset {
  std::string pipe;
  double offset = 0;     ///< m
  double deviation = 0;  ///< m
  bool movable = false;
};

/// Of a pipe that the rack file allows to be otherwise.
struct PipeShapeFound {
  std::string pipe;
  bool found = false;
  rack_vision::PipeShape shape{};
  rack_vision::PipeShape deviation{};
};

struct TrackRun {
  std::vector<TrackedImage> images;
  std::size_t tracked = 0;
  Eigen::Vector3d along = Eigen::Vector3d::UnitY();  ///< main direction of the pipes, rack frame
  std::vector<PipeOffset> offsets;     ///< after the last tracked image; empty without one
  std::vector<PipeShapeFound> shapes;  ///< the same
  rack_vision::RackLocalizationCounts starts;
  std::vector<std::string> said;  ///< by the source
  std::vector<LeftOut> left_out;
  std::size_t overlays = 0;  ///< pictures written
};

using Progress = std::function<void(std::size_t done, std::size_t all, std::size_t tracked)>;

/// Tracks the rack through all images. Throws std::invalid_argument for parameters and models as
/// RackLocalization, std::runtime_error when the first image has another size than the camera, or
/// no image can be read, and for pictures that cannot be written.
[[nodiscard]] TrackRun track_images(ImageSource& source, const rack_vision::RackModel& model,
                                    const geometry::Camera& camera, const TrackOptions& options,
                                    const Progress& progress);

}  // namespace pipescout::rack
