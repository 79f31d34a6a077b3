// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/way_points.hpp"

/// Servo loop from the camera's pose over the rack to the velocity of the vehicle: Lippiello and
/// Cacace, section IV.
///
/// Frames: `rack` (RackModel), `base_link` of the vehicle (x forward, y left, z up), the camera's
/// optical frame (x to the right of the image, y down, z forward), and the level frame: at the
/// origin of base_link with its yaw, but z straight up. Times are seconds of one clock, that of the
/// stamps of the poses.
namespace pipescout::rack_vision {

/// T_base_camera of a camera that looks straight down with the upper edge of the image forward:
/// image right is the vehicle's right, the optical axis is down.
[[nodiscard]] geometry::SE3 downward_camera(
    const Eigen::Vector3d& position_in_base = Eigen::Vector3d::Zero());

enum class RotationControl : std::uint8_t {
  kYawOnly,  ///< of an under-actuated vehicle: error and command are in the level frame; the
             ///< angular part of the command is (0, 0, yaw rate)
  kFull,     ///< of a vehicle that can rotate in place about every axis: error and command are in
             ///< base_link; the way-points require a level attitude
};

struct VisualServoParameters {
  geometry::SE3 T_base_camera = downward_camera();
  RotationControl rotation = RotationControl::kYawOnly;
  double position_gain = 1.5;  ///< 1/s, (0, 20]
  double rotation_gain = 1.5;  ///< 1/s, (0, 20]
  /// s, [0, 5]: time constant of the vehicle's velocity response (63 %); the target's velocity is
  /// commanded this much ahead, by its acceleration.
  double response_time = 0.2;
  double largest_speed = 0.5;          ///< m/s, (0, 20]: of the norm; the paper's cruise velocity
  double largest_rotation_rate = 0.2;  ///< rad/s, (0, 6]: of the norm; as in the paper
  double largest_acceleration = 1.0;   ///< m/s^2, (0, 50]: of the commanded velocity
  double largest_rotation_acceleration = 1.0;  ///< rad/s^2, (0, 50]
  double stale_after = 0.5;                    ///< s, (0, 10]: a pose of this age is not used
  double future_tolerance = 0.05;  ///< s, [0, 1]: how far a stamp may be ahead of the clock
  double smallest_quality = 0.2;   ///< [0, 1]: a pose of lower quality is not used
  /// s, [0, 3600]: time without a pose before climbing; unlimited before the first pose
  double hold_time = 3;
  double climb_speed = 0.3;  ///< m/s, [0, largest_speed]; 0: holds without limit
  double climb_height = 2;   ///< m, [0, 1000]: commanded height of the climb, then holds

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// An external pose of the camera; all values are validated.
struct CameraPose {
  double time = 0;                                     ///< s: when the image was taken
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< of the camera, rack frame, m
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< camera to rack
  double quality = 1;  ///< [0, 1]: of the tracker; 0 when lost
};

/// The first that applies, in this order.
enum class PoseVerdict : std::uint8_t {
  kTaken = 0,
  kNotANumber = 1,
  kNoRotation = 2,  ///< the norm of the quaternion is off 1 by more than 1e-3
  kFromTheFuture = 3,
  kStale = 4,       ///< older than `stale_after`
  kOutOfOrder = 5,  ///< not later than the last accepted one
  kLowQuality = 6,
};
inline constexpr std::size_t kPoseVerdicts = 7;

enum class ServoState : std::uint8_t {
  kIdle = 0,      ///< no target: commands zero
  kServoing = 1,  ///< follows the target
  kHolding = 2,   ///< no usable pose: commands zero
  kClimbing = 3,  ///< the same for longer than `hold_time`: straight up
};

/// Content of geometry_msgs/TwistStamped: velocity of base_link's origin and rotation rate, in the
/// level frame (kYawOnly) or base_link (kFull).
struct ServoCommand {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< m/s
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< rad/s
  ServoState state = ServoState::kIdle;
  /// From the vehicle to the target when its last pose was measured; 0 unless `kServoing`.
  double position_error = 0;  ///< m
  double rotation_error = 0;  ///< rad: of the yaw only with kYawOnly
};

/// log(H_e), equation (31), H_e = T_rack_base^-1 T_rack_target: [translation; rotation], the twist
/// that moves one frame to the other in one second.
[[nodiscard]] geometry::Vector6d pose_error(const geometry::SE3& T_rack_base,
                                            const geometry::SE3& T_rack_target) noexcept;

/// The pose without roll and pitch: z straight up, x with unchanged horizontal direction. Nothing
/// when the x axis is vertical.
[[nodiscard]] std::optional<geometry::SE3> level(const geometry::SE3& T_rack_base);

/// Allocates nothing after construction. Not for use by several threads at once.
class VisualServo {
 public:
  /// Throws as VisualServoParameters::validate.
  explicit VisualServo(const VisualServoParameters& parameters);

  /// Of the poses from now on, in place of the parameter: a camera that moves on the vehicle.
  void set_T_base_camera(const geometry::SE3& T_base_camera) noexcept {
    parameters_.T_base_camera = T_base_camera;
  }

  /// Accepts or rejects a pose, with the reason, and counts it. `now`: s; with NaN every pose is
  /// kNotANumber.
  PoseVerdict observe(const CameraPose& pose, double now);

  /// The command for now. `target`: that of the path at `pose_time`, or nothing: zero velocity.
  /// Feedback of the gains times log(H_e), plus the velocity that the target will have a
  /// `response_time` from now; saturated in norm, its direction kept; its change since the last
  /// step limited by the largest accelerations. Steps longer than 0.2 s count as that. When `now`
  /// goes back by more than a second (a simulation restarts), everything except the counts is
  /// reset; a smaller step back or NaN returns the last command again.
  ServoCommand step(double now, const std::optional<PathPoint>& target);

  /// Resets pose and command, as after construction, but not the counts.
  void reset() noexcept;

  /// The last accepted pose, if not stale at `now`.
  [[nodiscard]] std::optional<geometry::SE3> T_rack_base(double now) const noexcept;
  [[nodiscard]] std::optional<double> pose_time() const noexcept;
  /// Number of poses with each verdict since construction.
  [[nodiscard]] const std::array<std::size_t, kPoseVerdicts>& counts() const noexcept {
    return counts_;
  }
  [[nodiscard]] const VisualServoParameters& parameters() const noexcept { return parameters_; }

 private:
  struct Known {
    double time = 0;
    geometry::SE3 T_rack_base;
  };

  [[nodiscard]] ServoCommand follow(const Known& known, const PathPoint& target, double now) const;
  [[nodiscard]] ServoCommand do_without_pose(double now, double interval);

  VisualServoParameters parameters_;
  std::array<std::size_t, kPoseVerdicts> counts_{};
  std::optional<Known> known_;
  std::optional<double> last_step_;
  std::optional<double> without_pose_since_;
  double climbed_ = 0;
  ServoCommand command_;
};

/// For messages: "taken", "not a number", ... and "idle", "servoing", ...
[[nodiscard]] const char* to_string(PoseVerdict verdict) noexcept;
[[nodiscard]] const char* to_string(ServoState state) noexcept;

}  // namespace pipescout::rack_vision
