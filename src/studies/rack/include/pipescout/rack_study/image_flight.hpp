// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_study/image_scene.hpp"
#include "pipescout/rack_study/mesh_renderer.hpp"
#include "pipescout/rack_vision/rack_localization.hpp"
#include "pipescout/simulation/rack_image.hpp"

/// A flight over a rendered rack, localised by images alone or with odometry, beside the truth.
namespace pipescout::rack_study {

/// What happens to the camera for a while.
enum class Outage : std::uint8_t {
  kCovered,  ///< the lens is covered: images are dark, with noise
  kFrozen,   ///< the driver hands out the last image again and again
  kMissing,  ///< no images come
};

struct ForcedLoss {
  Outage kind = Outage::kCovered;
  double begin = 0;     ///< s from the start of the flight
  double duration = 1;  ///< s
};

struct ImageFlightSettings {
  /// Its seed is drawn from that of the flight; its people walk as `people_beside` says.
  simulation::RackScene scene{};
  /// If set, the second renderer makes the images, with model, bodies, people and seed of `scene`;
  /// lens, sensor, clutter and changes of the light are not used then.
  std::optional<MeshScene> mesh{};
  /// The rack as the localisation has it; that of the scene if not set.
  std::optional<rack_vision::RackModel> rack_file{};
  std::vector<rack_vision::WayPoint> way_points{};
  CameraFlightSettings flight{};
  simulation::ImageSensor sensor{};
  geometry::Camera camera{};
  rack_vision::RackLocalizationParameters localization{};
  /// Standard deviations of the pose that the localisation is started with, per axis; it is told
  /// them.
  double start_position_deviation = 0.01;   ///< m
  double start_rotation_deviation = 0.005;  ///< rad
  /// Whether each image comes with the motion since the last one, as an estimator measures it: off
  /// by 5 mm and 0.1 degrees per axis and root of a second, and it says so.
  bool with_odometry = false;
  std::optional<ForcedLoss> loss{};
  /// s from the start of the flight: the clutter of the scene comes then, all of it between two
  /// images. 0: it is there from the start.
  double clutter_begin = 0;
};

/// One image that was due.
struct FrameScore {
  double time = 0;  ///< s
  rack_vision::TrackStatus status = rack_vision::TrackStatus::kNotStarted;
  bool outage = false;    ///< the image was covered, frozen or missing
  bool has_pose = false;  ///< tracked; what follows is 0 without
  /// As `pose_error`: place and rotation, rack axes, m and rad.
  geometry::Vector6d error = geometry::Vector6d::Zero();
  double along_deviation = 0;  ///< m, stated, of the place along the pipes
  double position_nees = 0;    ///< error^T covariance^-1 error of the place: 3 on average
  double pose_nees = 0;        ///< of place and rotation: 6 on average
  double quality = 0;
  double along = 0;  ///< m: where the camera is along the pipes, the truth

  [[nodiscard]] double position_error() const { return error.head<3>().norm(); }  ///< m
  [[nodiscard]] double rotation_error() const { return error.tail<3>().norm(); }  ///< rad
};

struct ImageFlightRun {
  std::vector<FrameScore> frames;
  rack_vision::RackTrackerCounts tracker{};
  rack_vision::RackLocalizationCounts localization{};
  /// Share of the contours in view that the clutter hides or imitates, once it is there, as
  /// `simulation::cluttered_contour_share` measures it in one view a second.
  double cluttered_share = 0;
};

/// Score of one frame. A covariance that is none gives infinite NEES.
[[nodiscard]] FrameScore score_frame(const rack_vision::RackTrackerResult& result,
                                     const geometry::SE3& T_camera_rack);

/// Light and exposure change as `simulation::ChangingRackLight` has it. The same settings and seed
/// give the same bits. Throws as the `validate` of what the settings hold.
[[nodiscard]] ImageFlightRun run_image_flight(const ImageFlightSettings& settings,
                                              std::uint64_t seed);

}  // namespace pipescout::rack_study
