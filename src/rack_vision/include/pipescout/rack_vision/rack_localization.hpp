// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/first_pose.hpp"
#include "pipescout/rack_vision/image_view.hpp"
#include "pipescout/rack_vision/rack_model.hpp"
#include "pipescout/rack_vision/rack_tracker.hpp"

/// The whole life of a localisation over a rack: first pose, tracking, loss, recovery.
namespace pipescout::rack_vision {

struct RackLocalizationParameters {
  RackTrackerParameters tracker;
  FirstPoseParameters first_pose;
  /// Whether poses are looked for in the image alone when none is known.
  bool find_first_pose = true;
  double retry_period = 0.2;  ///< s between two attempts to find a pose, >= 0
  /// Motion that is not measured while the track is lost, beside going on at the same speed, one
  /// sigma for each second, > 0; turns do not grow any more after half a second.
  double drift_speed = 0.15;         ///< m/s
  double drift_angular_speed = 0.1;  ///< rad/s
  /// As drift_speed, before any pose was tracked: of a vehicle that hovers where it was told to be.
  double hover_drift_speed = 0.15;  ///< m/s

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// How poses were come by since the start.
struct RackLocalizationCounts {
  std::uint64_t given = 0;            ///< attempts from a pose that was given
  std::uint64_t suggested = 0;        ///< suggestions that said something new
  std::uint64_t from_last_pose = 0;   ///< attempts from the last pose, moved on
  std::uint64_t from_image = 0;       ///< attempts from the image alone
  std::uint64_t image_ambiguous = 0;  ///< the image alone fits several poses
  std::uint64_t image_unclear = 0;    ///< the image alone shows too few contours
  std::uint64_t recoveries = 0;       ///< tracking again after a loss
};

/// Tracks, and when there is no pose finds one by itself, in this order: from a pose that was
/// given; after a loss from the last pose, moved on by what is known of the motion; from the image
/// alone, with what is known of place and heading. A pose that is found is only a start: nothing is
/// reported as tracked before the tracker has confirmed it in the image.
class RackLocalization {
 public:
  /// Throws std::invalid_argument as RackTracker and the parameters' `validate`, and, when poses
  /// shall be looked for in the image alone, as FirstPoseFinder::find does for a rack with too few
  /// pipes along y.
  RackLocalization(const RackModel& model, const geometry::Camera& camera,
                   const RackLocalizationParameters& parameters = {});
  ~RackLocalization();
  RackLocalization(RackLocalization&&) noexcept;
  RackLocalization& operator=(RackLocalization&&) noexcept;

  /// The next image starts from this pose, whatever was tracked before; as RackTracker::set_pose.
  bool set_pose(const geometry::SE3& T_rack_camera, const geometry::Matrix6d& covariance);

  /// What another source says of the pose, which may be part of one: what it does not know has a
  /// large variance. A pose that is known well enough to start from is taken as by set_pose. Of any
  /// other, while none is tracked, place, tilt and heading are taken where they are more certain
  /// than what is known: the level that an IMU gives, for a camera of which someone has said where
  /// it hovers. Covariance as of set_pose; false when it is none, or the pose is not finite.
  bool suggest_pose(const geometry::SE3& T_rack_camera, const geometry::Matrix6d& covariance);

  /// What is known of the place when the image alone has to say where the camera is. Throws
  /// std::invalid_argument as FirstPoseHint::validate.
  void set_hint(const FirstPoseHint& hint);

  /// One image, as RackTracker::track, but `motion` is since the last image that was given to this
  /// function, whatever became of that one. An image that is searched for a pose to start from
  /// takes 0.2 to 0.5 s of one core.
  [[nodiscard]] RackTrackerResult track(const ImageView& image, double stamp,
                                        const std::optional<MotionPrediction>& motion = {});

  [[nodiscard]] const RackTracker& tracker() const noexcept;
  [[nodiscard]] const RackLocalizationCounts& counts() const noexcept;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::rack_vision
