// SPDX-License-Identifier: Apache-2.0
// The images of one place of a flight over a rack, which trials with several rack files share.
#pragma once

#include <cstdint>
#include <functional>
#include <random>
#include <span>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/rack_study/image_scene.hpp"
#include "pipescout/rack_study/image_score.hpp"
#include "pipescout/rack_vision/rack_localization.hpp"

namespace pipescout::rack_study {

/// What a localisation is started with: the error of its pose, rack axes, and what it is told.
struct FirstPose {
  geometry::Vector6d sigma = geometry::Vector6d::Zero();  ///< place m, rotation rad
  geometry::Vector6d error = geometry::Vector6d::Zero();
};

/// Normal errors of these deviations per axis, m and rad.
[[nodiscard]] FirstPose draw_first_pose(double position, double rotation, std::mt19937_64& engine);

class PlaceImages {
 public:
  using OnImage = std::function<void(const rack_vision::RackTrackerResult&, const FrameScore&)>;

  /// `duration` s, at the frame rate of CameraFlightSettings, at a place that the engine draws.
  PlaceImages(const rack_vision::RackModel& rack, World world, double duration,
              std::mt19937_64& engine);

  /// All images, with `file` as the rack that the localisation has. `on_image`, if set, gets each
  /// result.
  [[nodiscard]] std::vector<FrameScore> localize(
      const rack_vision::RackModel& file, const rack_vision::RackLocalizationParameters& parameters,
      const FirstPose& first, const OnImage& on_image = {}) const;

 private:
  geometry::Camera camera_;
  std::vector<CameraMotion> motions_;
  std::vector<std::vector<std::uint8_t>> images_;
};

/// How the images of one place ended.
struct PlaceOutcome {
  ImageFlightScore images{};
  bool converged = false;  ///< the last image has a pose that is not wrong
  bool lost = false;       ///< the last image has no pose
};

[[nodiscard]] PlaceOutcome outcome_of(std::span<const FrameScore> frames);

}  // namespace pipescout::rack_study
