// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/image_view.hpp"
#include "pipescout/rack_vision/pose_solver.hpp"
#include "pipescout/rack_vision/rack_model.hpp"

/// The tracker of Lippiello and Cacace (section III and Figure 4) on real images: predict, render
/// the visible edges, search each normal, match the texture, solve, update.
namespace pipescout::rack_vision {

struct RackTrackerParameters {
  int samples_per_edge = 20;  ///< 2..100, as in the paper
  int points_per_frame = 60;  ///< texture points matched in one image, 0..200
  int map_capacity = 2000;    ///< texture points kept, 0..20000

  /// Process noise of the constant-velocity model: white accelerations, one sigma.
  double acceleration_sigma = 1.0;          ///< m/s^2, > 0: a quadrotor tilted by 6 degrees
  double angular_acceleration_sigma = 1.0;  ///< rad/s^2, > 0

  double edge_sigma = 0.25;  ///< px, > 0: noise of one edge sample
  /// px, >= 0: error common to all samples of one edge, in addition to that of their profiles.
  double edge_bias_sigma = 0.30;
  double point_sigma = 0.15;  ///< px, > 0: noise of one matched texture point

  bool estimate_offsets = true;  ///< equations (23) to (26)
  double offset_sigma = 0.010;   ///< m, > 0: initial standard deviation of the pipe offsets

  /// Estimate the focal length and the centre of the camera on line, as the paper's section III
  /// allows. Useful for inaccurate calibrations: the images contain little information about them
  /// (tilted views, edges at different depths), and convergence takes a minute.
  bool estimate_intrinsics = false;
  double focal_sigma = 5;   ///< px, > 0: standard deviation of the calibrated focal length
  double centre_sigma = 5;  ///< px, > 0: and of each coordinate of the centre

  /// s from the exposure of one row to that of the next below, 0..1e-3: of a rolling shutter, from
  /// the sensor's data sheet (line time) or its readout time over the rows; 0: global shutter.
  /// Features are corrected by the estimated velocity to the middle row, whose pose is the result:
  /// see RowMotion.
  double row_time = 0;

  double longest_gap = 0.5;      ///< s, > 0: a longer gap of the stamps ends the track
  double lost_below = 0.35;      ///< quality below which the track is declared lost, 0..1
  double start_range_m = 0.10;   ///< m, > 0: largest error of a pose given to `set_pose` ...
  double start_range_rad = 0.1;  ///< rad, > 0: ... that the start searches around it

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

enum class TrackStatus : std::uint8_t {
  kNotStarted,  ///< no pose was given yet
  kTracking,    ///< the pose is that of this image
  kCoasting,    ///< this image was not usable (see `reason`): the pose is predicted, once or twice,
                ///< or from an image that repeats the previous one, nine times
  kLost,        ///< no pose: `set_pose` restarts the track
  kBadImage,    ///< image refused, nothing changed: size, no pixels, black, white, frozen
  kBadStamp,    ///< stamp refused, nothing changed: not finite, not after the last one
};

[[nodiscard]] std::string_view to_string(TrackStatus status) noexcept;

/// Motion of the camera since the last tracked image, from odometry or an estimator.
struct MotionPrediction {
  geometry::SE3 T_previous_current;  ///< camera frame now -> camera frame of the last image
  /// Of `T_previous_current`, right perturbation: [translation; rotation] in the camera frame now.
  geometry::Matrix6d covariance = geometry::Matrix6d::Identity();
};

/// What is believed of a pipe that may not be as the model has it: Pipe::shape_deviation.
struct PipeShapeEstimate {
  std::size_t pipe = 0;  ///< index in the model
  /// One shape explains its contours in several views; before, `shape` is the model's, and the pose
  /// rests on the pipe only as far as the stated deviations leave it certain.
  bool found = false;
  PipeShape shape;
  PipeShape deviation;  ///< one sigma
};

struct RackTrackerResult {
  TrackStatus status = TrackStatus::kNotStarted;
  /// Text in static storage; empty without a problem. Of a tracked pose from RackLocalization: that
  /// what is in view does not determine it.
  std::string_view reason;
  /// 0 (lost) to 1: see track_quality.hpp.
  double quality = 0;

  geometry::SE3 T_rack_camera;  ///< meaningful for kTracking and kCoasting
  /// As geometry_msgs/PoseWithCovariance: position of the camera along the rack's axes, then
  /// rotation about the rack's fixed axes, R' = exp(theta) R; m and rad. Includes the uncertainty
  /// of the intrinsics, when they are estimated.
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();

  /// One entry per pipe, valid until the next call of the tracker; see PipeOffsets. Of those in
  /// `shapes`, the offset of the shape.
  std::span<const double> offsets;
  std::span<const double> offset_variances;       ///< m^2
  std::span<const std::uint8_t> offset_observed;  ///< 1: observed in this image; `shapes`: found

  /// One entry per pipe with a shape deviation, valid until the next call, in every status.
  std::span<const PipeShapeEstimate> shapes;

  /// If they are estimated: their current estimate, in every status.
  std::optional<IntrinsicsBelief> intrinsics{};

  double inlier_share = 0;  ///< of edge samples and points used
  int edges = 0;            ///< visible sections of contours
  int edge_samples = 0;     ///< searched
  int edge_samples_found = 0;
  int points = 0;  ///< texture points searched
  int points_matched = 0;
  int map_points = 0;  ///< in the map
  int iterations = 0;  ///< of the solver
};

/// Counts of refused inputs and losses since construction.
struct RackTrackerCounts {
  std::uint64_t images = 0;
  std::uint64_t wrong_size = 0;
  std::uint64_t repeated = 0;  ///< identical to the image before: predicted
  std::uint64_t frozen = 0;    ///< the same from the tenth in a row on: refused
  std::uint64_t without_contrast = 0;
  std::uint64_t bad_stamps = 0;
  /// NaN, an invalid covariance, or inconsistent with the image: not used.
  std::uint64_t bad_predictions = 0;
  std::uint64_t refused_starts = 0;  ///< initial poses that were not confirmed by an image
  std::uint64_t losses = 0;          ///< of tracks
};

class RackTracker {
 public:
  /// Throws std::invalid_argument as RackModel::validate, CameraParameters::validate and
  /// RackTrackerParameters::validate.
  RackTracker(const RackModel& model, const geometry::Camera& camera,
              const RackTrackerParameters& parameters = {});
  ~RackTracker();
  RackTracker(RackTracker&&) noexcept;
  RackTracker& operator=(RackTracker&&) noexcept;

  /// Starts or restarts near this pose; the next image must confirm it. The texture map is kept.
  /// `covariance` as RackTrackerResult::covariance. Returns false, and changes nothing, when the
  /// pose or the covariance is not finite or the covariance not positive definite.
  bool set_pose(const geometry::SE3& T_rack_camera, const geometry::Matrix6d& covariance);

  /// One image, taken at `stamp` (s, any epoch; with a row time that of its middle row, or always
  /// the same time before or after it). Never throws for any image or stamp.
  [[nodiscard]] RackTrackerResult track(const ImageView& image, double stamp,
                                        const std::optional<MotionPrediction>& motion = {});

  /// Resets pose, offsets, intrinsics and map.
  void reset();

  [[nodiscard]] const RackTrackerCounts& counts() const noexcept;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::rack_vision
