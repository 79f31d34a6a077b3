// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/simulation/thermal_patrol.hpp"
#include "pipescout/tracking/shape_tracker.hpp"

/// Patrols along collectors as the tracking gets them: rendered pictures, the sections of pipes
/// that the leak detector finds in them, the motion that the state estimator tells; and the truth.
/// After the database of Ibarguren and others (2013), section 7.2: 20 km/h over rough ground, some
/// 200 pictures for each 150 m, which is 7.5 a second.
namespace pipescout::tracking_study {

struct RecordingSettings {
  std::size_t frames = 200;  ///< [1, 100000]
  double frame_rate = 7.5;   ///< Hz, [1, 200]
  /// Pictures without anything, of a camera that calibrates itself behind its shutter: on average
  /// as often, s, [0.1, 1e6], and for as long, from nothing to twice of this, s, [0, 10].
  double gap_spacing = 4.0;
  double gap = 0.4;
  /// Of the camera's velocity as it is told: m/s, [0, 10], and rad/s, [0, 1], standard deviations
  /// of what stays the same and of what is new in each picture, each.
  double velocity_deviation = 0.05;
  double angular_deviation = 0.002;
  double depth_deviation = 0.05;  ///< share, [0, 1]: of the pipe's depth as it is told; constant

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct RecordedPicture {
  double time = 0;  ///< s
  bool gap = false;
  std::size_t first_region = 0;
  std::size_t regions = 0;
  /// Of the camera, mean since the last picture, as it is told: [m/s; rad/s], camera frame.
  geometry::Vector6d velocity = geometry::Vector6d::Zero();
  /// Of the tube between the middles of the outermost pixels; nothing: it is not in view.
  std::optional<tracking::PipeShape::State> truth{};
};

struct Recording {
  geometry::Camera camera{};
  double depth = 0;  ///< m, of the tube, as it is told
  std::vector<RecordedPicture> pictures{};
  std::vector<tracking::PipeRegion> regions{};  ///< of all pictures

  [[nodiscard]] tracking::ImageSize image() const {
    return {.width = camera.parameters().width, .height = camera.parameters().height};
  }
  [[nodiscard]] std::span<const tracking::PipeRegion> of(const RecordedPicture& picture) const {
    return std::span(regions).subspan(picture.first_region, picture.regions);
  }
};

/// Begins with the first picture that the tube reaches half across, so that it and not the upright
/// pipe at its end is the longest. `seed`: of gaps and of errors. Throws as the
/// `validate` of its arguments, and std::invalid_argument when the row is too short for so many
/// pictures.
[[nodiscard]] Recording record(const simulation::ThermalPatrolParameters& patrol,
                               const RecordingSettings& settings, std::uint64_t seed);

/// Patrols of a campaign (leak_study/campaign.hpp) with leaks and decoys, along rows that are long
/// enough for so many pictures: every sort of ground and camera in turn.
[[nodiscard]] std::vector<simulation::ThermalPatrolParameters> plan_patrols(
    std::size_t patrols, const RecordingSettings& settings, std::uint64_t seed);

}  // namespace pipescout::tracking_study
