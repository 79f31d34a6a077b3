// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/manipulation/arm_model.hpp"

/// Visual servo of an arm that keeps a pipe in view of its camera: Ibarguren and others (2013),
/// section 6 and their further work. Reasons for the control law:
/// docs/decisions/pipe-plane-visual-servo.md.
///
/// Times are seconds of one clock, that of the stamps. Frames as in arm_model.hpp; `base` is also
/// the vehicle's body, `map` is at rest with z up.
namespace pipescout::manipulation {

enum class Centring : std::uint8_t {
  kAlways,  ///< the pipe is kept in the middle of the image
  kAtEdge,  ///< as in the paper: moves only when the pipe comes near the border of the image, until
            ///< it is in the middle again
};

struct ArmControllerParameters {
  double period = 0.01;  ///< s, [0.001, 0.1]: control period
  Centring centring = Centring::kAlways;
  /// Compensates the motion of the vehicle with its odometry; when false, odometry is not needed.
  bool feed_forward = true;

  /// Posture with the camera towards the pipes, and posture for driving: rad, one per joint. The
  /// path between both is straight in joint space.
  std::vector<double> ready = {1.5708, -0.9, 1.3, 0.0, 1.0258, 0.0};
  std::vector<double> stow = {0.0, -1.4, 2.4, 0.0, 0.8, 0.0};
  double move_speed = 0.6;  ///< rad/s, (0, 10]: speed of a joint between both and in the search

  double rotation_gain = 8;     ///< 1/s, (0, 50]: of the image error
  double position_gain = 2;     ///< 1/s, (0, 50]: of the position of the camera
  double correction_rate = 1;   ///< rad/s, m/s, (0, 10]: largest rate of the camera for an error
  double image_time = 0.15;     ///< s, [0, 5]: averaging time of image measurements
  double response_time = 0.03;  ///< s, [period, 0.5]: response time of the joints
  double largest_acceleration = 12;    ///< rad/s^2, (0, 200]: of each joint
  double damping = 0.05;               ///< [0, 1]: of least squares, where the arm is singular
  double least_manipulability = 0.02;  ///< (0, 1]: below it least squares are damped
  double rotation_weight = 3;          ///< m/rad, (0, 100]: of errors of rotation against position

  double nearest = 6;       ///< m, (0, 1000]: to the pipe; the camera moves back when nearer
  double farthest = 14;     ///< m, [nearest, 1000]: the camera reaches out when farther
  double usual_range = 10;  ///< m, [nearest, farthest]: if the track has no range
  double reach = 0.12;      ///< m, [0, 2]: largest motion along the view direction
  double turn = 0.2;        ///< rad, [0, 1.5]: largest rotation towards an end of the pipe

  /// (0, 0.49]: distance from the border as a share of the image, kAtEdge
  double edge_share = 0.2;
  /// (0, 0.5 - edge_share]: distance from the middle of the image at which kAtEdge stops.
  double centred_share = 0.05;

  double joints_stale_after = 0.1;    ///< s, (0, 10]
  double track_stale_after = 0.3;     ///< s, (0, 10]
  double odometry_stale_after = 0.1;  ///< s, (0, 10]
  double future_tolerance = 0.05;     ///< s, [0, 1]: how far a stamp may be ahead of the clock

  double hold_time = 1;            ///< s, [0, 3600]: time at rest after a loss, before the search
  double search_time = 12;         ///< s, [0, 3600]: duration of the search, before stowing
  double search_period = 4;        ///< s, [0.5, 60]: of a sweep up and down
  double search_amplitude = 0.25;  ///< rad, (0, 1.5]: of the last sweep; the first ones are smaller

  double least_clearance = 0.03;          ///< m, [0, 1]: between links, and above the ground
  double ground = -0.35;                  ///< m, [-10, 10]: z in the base frame
  double largest_following_error = 0.25;  ///< rad, (0, 3]: of a joint, relative to the command

  /// Throws std::invalid_argument naming the field, the value and the range. `joints`: of the arm.
  void validate(std::size_t joints) const;
};

/// Content of joint_states. Joints may be in any order; those of other devices are ignored. The
/// arm's may come in several messages with times of their own: they are merged at the latest time
/// up to which all are known, each interpolated linearly between its last two readings. Continuous
/// joints may count turns or not.
struct JointReadings {
  double time = 0;  ///< s
  std::span<const std::string> names{};
  std::span<const double> positions{};  ///< rad, of each name
};

enum class TrackState : std::uint8_t {
  kNone,      ///< no pipe yet
  kLocked,    ///< detected in this image
  kCoasting,  ///< predicted: not used as a measurement
  kLost,
};

/// The pipe as it is tracked in one image: [x y l alpha] of its axis.
struct PipeSection {
  double time = 0;  ///< s: when the image was taken
  TrackState state = TrackState::kNone;
  int width = 0;      ///< pixels, of the image
  int height = 0;     ///< pixels
  double u = 0;       ///< pixels, of the middle
  double v = 0;       ///< pixels
  double length = 0;  ///< pixels, > 0
  double angle = 0;   ///< rad, from u towards v, modulo pi
  /// m, [0.1, 1e4], from the camera to the middle of the section; NaN: unknown.
  double range = std::numeric_limits<double>::quiet_NaN();
};

/// Content of nav_msgs/Odometry.
struct VehicleMotion {
  double time = 0;                                                 ///< s
  Eigen::Quaterniond R_map_base = Eigen::Quaterniond::Identity();  ///< base to map
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();              ///< m/s, of base's origin, base
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();          ///< rad/s, base
};

/// The first that applies, in this order.
enum class InputVerdict : std::uint8_t {
  kTaken = 0,
  kNotANumber = 1,  ///< a used value is not finite, or out of range
  kNoRotation = 2,  ///< the norm of the quaternion is off 1 by more than 1e-3
  kPartial = 3,     ///< accepted, and other joints of the arm are not known at this time yet
  kFromTheFuture = 4,
  kStale = 5,           ///< or from before the first joint readings, or odometry that is used
  kOutOfOrder = 6,      ///< not later than the last accepted one
  kOtherImageSize = 7,  ///< not that of the camera's intrinsics, or these are unknown
  kOfOthers = 8,        ///< no joint of the arm is in it
};
inline constexpr std::size_t kInputVerdicts = 9;

enum class ArmState : std::uint8_t {
  kIdle = 0,       ///< initial state: no commands
  kTracking = 1,   ///< keeps the pipe in view
  kHolding = 2,    ///< decelerates and stays at rest
  kSearching = 3,  ///< moves to `ready` and sweeps up and down
  kStowing = 4,    ///< moves to `stow`
  kStowed = 5,     ///< there
  kFault = 6,      ///< at rest until `reset`
};

enum class ArmReason : std::uint8_t {
  kNone = 0,
  kNoJointReadings = 1,  ///< none yet
  kStaleJointReadings = 2,
  kNoIntrinsics = 3,   ///< `set_camera` was not called
  kStaleOdometry = 4,  ///< or none yet
  kNoPipe = 5,         ///< none detected yet
  kStaleTrack = 6,
  kPipeLost = 7,
  kSearchedInVain = 8,
  kToldToStow = 9,
  kFollowingError = 10,  ///< a joint deviates too far from its command
  kOutsideLimits = 11,   ///< the arm is beyond a joint limit
  kTooClose = 12,        ///< the arm is closer than allowed to itself or the ground
};

/// Requests to the controller.
enum class ArmRequest : std::uint8_t { kTrack, kStow };

/// The limit of a joint that saturated its command.
enum class JointCut : std::uint8_t { kNone, kPosition, kVelocity, kAcceleration };

/// For one cycle. The joints are to be at `position` with `velocity` one period from now.
struct ArmCommand {
  ArmState state = ArmState::kIdle;
  ArmReason reason = ArmReason::kNone;
  /// The command is valid: not before the first joint readings.
  bool commanded = false;
  JointVector position{};  ///< rad
  JointVector velocity{};  ///< rad/s

  // Predicted errors of the pipe in the image; NaN unless tracking (errors: a pipe that is not
  // upright).
  double error_u = std::numeric_limits<double>::quiet_NaN();  ///< pixels; 0 without an end in view
  double error_v = std::numeric_limits<double>::quiet_NaN();  ///< pixels
  double error_angle = std::numeric_limits<double>::quiet_NaN();  ///< rad, from level
  double range = std::numeric_limits<double>::quiet_NaN();        ///< m
  bool feed_forward = false;  ///< the motion of the vehicle was compensated
  double manipulability = 0;  ///< of the posture commanded
  std::array<JointCut, kMostJoints> cuts{};
  bool clearance_cut = false;  ///< slowed to avoid a collision with itself or the ground
};

/// Commands of an arm that keeps the pipe in the middle of the image, level, and in range.
///
/// An image of a straight pipe determines the plane through the pipe and the camera and, if an end
/// is in view, the position along the pipe. The controller averages the normal of that plane, which
/// is constant in the map, over the images, and aligns the camera's y axis with it. The control
/// law: resolved rates by damped least squares (Nakamura and Hanafusa, Inverse Kinematic Solutions
/// With Singularity Robustness, 1986), from the plane through the camera and the pipe.
///
/// Commands respect the position and velocity limits of the URDF and `largest_acceleration` in each
/// step, and the arm can always stop within them and at `least_clearance`. Holding decelerates as
/// hard as these limits allow, from the cycle on in which an input is stale. Allocates nothing
/// after construction. Not for use by several threads at once.
class ArmController {
 public:
  /// Throws as ArmControllerParameters::validate, and std::invalid_argument when `ready` or `stow`
  /// is outside the joint limits or too close, or the way between them is, or the camera is in a
  /// singular posture when ready.
  ArmController(ArmModel model, const ArmControllerParameters& parameters);
  ArmController(ArmController&&) noexcept;
  ArmController& operator=(ArmController&&) noexcept;
  ~ArmController();

  /// Intrinsics of the images to come. A change of the image size resets the track.
  void set_camera(const geometry::Camera& camera);

  /// Each accepts or rejects an input, with the reason, and counts it. `now`: s; not finite:
  /// kNotANumber.
  InputVerdict observe(const JointReadings& readings, double now);
  InputVerdict observe(const PipeSection& section, double now);
  InputVerdict observe(const VehicleMotion& motion, double now);

  /// The joints of the last readings that were taken, and their time, s; nothing before the first.
  [[nodiscard]] std::optional<std::pair<double, JointVector>> joints() const;
  /// Names of joints of the arm that were in no message yet.
  [[nodiscard]] std::vector<std::string> unseen_joints() const;

  /// The command of this cycle. The previous command is assumed to be reached one period after it.
  /// A step less than half a period after the last one, or with `now` before it or not finite,
  /// returns the last command again. When `now` goes back by more than a second (a simulation
  /// restarts), everything except the camera and the counts is reset. After stowing without a pipe,
  /// the arm stays stowed until kStow and kTrack are requested in turn, or `reset`.
  ArmCommand step(double now, ArmRequest request);

  /// Resets everything except camera and counts, including faults.
  void reset() noexcept;

  [[nodiscard]] const ArmModel& model() const noexcept;
  [[nodiscard]] const ArmControllerParameters& parameters() const noexcept;
  /// Number of inputs of each kind with each verdict since construction.
  using Counts = std::array<std::size_t, kInputVerdicts>;
  [[nodiscard]] const Counts& joint_counts() const noexcept;
  [[nodiscard]] const Counts& section_counts() const noexcept;
  [[nodiscard]] const Counts& motion_counts() const noexcept;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// For messages: "taken", "not a number", ...; "idle", "tracking", ...; "no joint states yet", ...
[[nodiscard]] const char* to_string(InputVerdict verdict) noexcept;
[[nodiscard]] const char* to_string(ArmState state) noexcept;
[[nodiscard]] const char* to_string(ArmReason reason) noexcept;

}  // namespace pipescout::manipulation
