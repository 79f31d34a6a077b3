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

/// Localisation over a rack of any main direction (see main_direction): initialisation, tracking,
/// loss, recovery. Offsets of pipes are estimated where the main direction is y.
namespace pipescout::rack_vision {

struct RackLocalizationParameters {
  RackTrackerParameters tracker;
  FirstPoseParameters first_pose;
  /// Whether to initialise from the image alone when no pose is known.
  bool find_first_pose = true;
  double retry_period = 0.2;  ///< s between two attempts to find a pose, >= 0
  /// Unmeasured motion during a loss, in addition to the constant velocity, one sigma per second, >
  /// 0; that of the rotation stops growing after half a second.
  double drift_speed = 0.15;         ///< m/s
  double drift_angular_speed = 0.1;  ///< rad/s
  /// As drift_speed, before any pose was tracked: for a vehicle that hovers at its initial
  /// position.
  double hover_drift_speed = 0.15;  ///< m/s

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Sources of poses since the start.
struct RackLocalizationCounts {
  std::uint64_t given = 0;            ///< attempts from a pose that was given
  std::uint64_t suggested = 0;        ///< suggestions with new information
  std::uint64_t from_last_pose = 0;   ///< attempts from the propagated last pose
  std::uint64_t from_image = 0;       ///< attempts from the image alone
  std::uint64_t image_ambiguous = 0;  ///< the image alone fits several poses
  std::uint64_t image_unclear = 0;    ///< the image has too few contours
  std::uint64_t recoveries = 0;       ///< tracking again after a loss
};

/// Tracks the pose and, when there is none, initialises in this order: from a given pose; after a
/// loss from the last pose, propagated by the known motion; from the image alone, with the priors
/// of position and heading. An initial pose is reported as tracked only after the tracker has
/// confirmed it in the image.
class RackLocalization {
 public:
  /// Throws std::invalid_argument as RackTracker and the parameters' `validate`, for supports in a
  /// rack whose main direction is oblique (InvalidRack), and, with initialisation from the image
  /// alone, as FirstPoseFinder::check for a rack with too few pipes along its main direction.
  RackLocalization(const RackModel& model, const geometry::Camera& camera,
                   const RackLocalizationParameters& parameters = {});
  ~RackLocalization();
  RackLocalization(RackLocalization&&) noexcept;
  RackLocalization& operator=(RackLocalization&&) noexcept;

  /// The next image starts from this pose, whatever was tracked before; as RackTracker::set_pose.
  bool set_pose(const geometry::SE3& T_rack_camera, const geometry::Matrix6d& covariance);

  /// A pose from another source, complete or in part: unknown parts have a large variance. A pose
  /// that is certain enough for initialisation is used as in set_pose. From any other, while no
  /// pose is tracked, position, tilt and heading are each used if they are more certain than the
  /// current prior: for example the tilt from an IMU for a camera that hovers at a known position.
  /// Covariance as in set_pose; false when it is invalid, or the pose is not finite.
  bool suggest_pose(const geometry::SE3& T_rack_camera, const geometry::Matrix6d& covariance);

  /// Prior for initialisation from the image alone. Throws std::invalid_argument as
  /// FirstPoseHint::validate.
  void set_hint(const FirstPoseHint& hint);

  /// One image, as RackTracker::track, but `motion` is since the last image passed to this
  /// function, regardless of its result. While there is no pose yet, `reason` says what the last
  /// search in an image alone came to: "ambiguous: ..." when several poses explain it.
  /// Initialisation from an image takes 0.2 to 0.5 s of one
  /// core.
  [[nodiscard]] RackTrackerResult track(const ImageView& image, double stamp,
                                        const std::optional<MotionPrediction>& motion = {});

  [[nodiscard]] const RackTracker& tracker() const noexcept;
  [[nodiscard]] const RackLocalizationCounts& counts() const noexcept;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::rack_vision
