// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/manipulation/arm_model.hpp"

/// An arm that keeps a pipe in view of the camera at its end: Ibarguren and others (2013), section
/// 6 and their further work. Why it does so as it does: docs/decisions/pipe-plane-visual-servo.md.
///
/// Times are seconds of one clock, that of the stamps. Frames as in arm_model.hpp; `base` is the
/// vehicle's body too, `map` is at rest with z up.
namespace pipescout::manipulation {

enum class Centring : std::uint8_t {
  kAlways,  ///< the pipe is kept in the middle of the image
  kAtEdge,  ///< the paper's: moves only once the pipe nears the edge of the image, until it is in
            ///< the middle again
};

struct ArmControllerParameters {
  double period = 0.01;  ///< s, [0.001, 0.1]: from step to step
  Centring centring = Centring::kAlways;
  /// Makes up for the motion of the vehicle by its odometry. Without it none is needed.
  bool feed_forward = true;

  /// Posture from which the camera looks at where pipes are, and the one to be driven about in:
  /// rad, one per joint. The way between both is a straight line over the joints' angles.
  std::vector<double> ready = {1.5708, -0.9, 1.3, 0.0, 1.0258, 0.0};
  std::vector<double> stow = {0.0, -1.4, 2.4, 0.0, 0.8, 0.0};
  double move_speed = 0.6;  ///< rad/s, (0, 10]: of a joint, between both and when it searches

  double rotation_gain = 8;            ///< 1/s, (0, 50]: of the image error
  double position_gain = 2;            ///< 1/s, (0, 50]: of where the camera is held
  double correction_rate = 1;          ///< rad/s, m/s, (0, 10]: of the camera for an error, at most
  double image_time = 0.15;            ///< s, [0, 5]: over which what images show is averaged
  double response_time = 0.03;         ///< s, [period, 0.5]: until what is commanded is done
  double largest_acceleration = 12;    ///< rad/s^2, (0, 200]: of each joint
  double damping = 0.05;               ///< [0, 1]: of least squares, where the arm is singular
  double least_manipulability = 0.02;  ///< (0, 1]: below it least squares are damped
  double rotation_weight = 3;          ///< m/rad, (0, 100]: of errors of rotation against position

  double nearest = 6;       ///< m, (0, 1000]: to the pipe; the camera draws back when nearer
  double farthest = 14;     ///< m, [nearest, 1000]: the camera reaches out when farther
  double usual_range = 10;  ///< m, [nearest, farthest]: where the track does not say
  double reach = 0.12;      ///< m, [0, 2]: by which it draws back or reaches out at most
  double turn = 0.2;        ///< rad, [0, 1.5]: by which it turns after an end of the pipe at most

  double edge_share = 0.2;  ///< (0, 0.49]: of the image, from its edge, kAtEdge
  /// (0, 0.5 - edge_share]: off the middle of the image, where kAtEdge rests again.
  double centred_share = 0.05;

  double joints_stale_after = 0.1;    ///< s, (0, 10]
  double track_stale_after = 0.3;     ///< s, (0, 10]
  double odometry_stale_after = 0.1;  ///< s, (0, 10]
  double future_tolerance = 0.05;     ///< s, [0, 1]: a stamp may be ahead of the clock by so much

  double hold_time = 1;      ///< s, [0, 3600]: at rest when the pipe is lost, before it searches
  double search_time = 12;   ///< s, [0, 3600]: searches for so long before it stows
  double search_period = 4;  ///< s, [0.5, 60]: of a sweep up and down
  double search_amplitude = 0.25;  ///< rad, (0, 1.5]: of the last sweep; the first ones are smaller

  double least_clearance = 0.03;          ///< m, [0, 1]: between links, and above the ground
  double ground = -0.35;                  ///< m, [-10, 10]: of the base frame
  double largest_following_error = 0.25;  ///< rad, (0, 3]: of a joint, from what was commanded

  /// Throws std::invalid_argument naming the field, the value and the range. `joints`: of the arm.
  void validate(std::size_t joints) const;
};

/// What joint_states say. Others than the arm's may be among them, in any order.
struct JointReadings {
  double time = 0;  ///< s
  std::span<const std::string> names{};
  std::span<const double> positions{};  ///< rad, of each name
};

enum class TrackState : std::uint8_t {
  kNone,      ///< no pipe yet
  kLocked,    ///< seen in this image
  kCoasting,  ///< not seen, predicted: not used as a measurement
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
  double angle = 0;   ///< rad, from u towards v, of an axis: a half turn is none
  /// m, [0.1, 1e4], from the camera to the middle of the section; NaN: not known.
  double range = std::numeric_limits<double>::quiet_NaN();
};

/// What nav_msgs/Odometry says.
struct VehicleMotion {
  double time = 0;                                                 ///< s
  Eigen::Quaterniond R_map_base = Eigen::Quaterniond::Identity();  ///< base to map
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();              ///< m/s, of base's origin, base
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();          ///< rad/s, base
};

/// The first that applies, in this order.
enum class InputVerdict : std::uint8_t {
  kTaken = 0,
  kNotANumber = 1,    ///< a number that is used is not finite, or outside its range
  kNoRotation = 2,    ///< the norm of the quaternion is off 1 by more than 1e-3
  kMissingJoint = 3,  ///< a joint of the arm is not among the readings
  kFromTheFuture = 4,
  kStale = 5,           ///< or from before the first joint readings, or odometry that is used
  kOutOfOrder = 6,      ///< not younger than the last one that was taken
  kOtherImageSize = 7,  ///< not that of the camera's intrinsics, or these are not known
};
inline constexpr std::size_t kInputVerdicts = 8;

enum class ArmState : std::uint8_t {
  kIdle = 0,       ///< has not been told to do anything yet: commands nothing
  kTracking = 1,   ///< keeps the pipe in view
  kHolding = 2,    ///< comes to rest, and stays there
  kSearching = 3,  ///< gets ready and sweeps up and down
  kStowing = 4,    ///< on its way to `stow`
  kStowed = 5,     ///< there
  kFault = 6,      ///< comes to rest, until `reset`
};

enum class ArmReason : std::uint8_t {
  kNone = 0,
  kNoJointReadings = 1,  ///< none yet
  kStaleJointReadings = 2,
  kNoIntrinsics = 3,   ///< `set_camera` was not called
  kStaleOdometry = 4,  ///< or none yet
  kNoPipe = 5,         ///< none seen yet
  kStaleTrack = 6,
  kPipeLost = 7,
  kSearchedInVain = 8,
  kToldToStow = 9,
  kFollowingError = 10,  ///< a joint is not where it was commanded to be
  kOutsideLimits = 11,   ///< the arm was found beyond a joint limit
  kTooClose = 12,        ///< the arm was found closer to itself or the ground than it may be
};

/// What an arm is asked for.
enum class ArmRequest : std::uint8_t { kTrack, kStow };

/// At which limit of a joint its command was cut.
enum class JointCut : std::uint8_t { kNone, kPosition, kVelocity, kAcceleration };

/// For one cycle. The joints are to be at `position` with `velocity` one period from now.
struct ArmCommand {
  ArmState state = ArmState::kIdle;
  ArmReason reason = ArmReason::kNone;
  /// There is something to send: not before the first joint readings.
  bool commanded = false;
  JointVector position{};  ///< rad
  JointVector velocity{};  ///< rad/s

  // Of the pipe as it should be seen now; NaN unless it tracks (errors: a pipe that is not
  // upright).
  double error_u = std::numeric_limits<double>::quiet_NaN();  ///< pixels; 0 without an end in view
  double error_v = std::numeric_limits<double>::quiet_NaN();  ///< pixels
  double error_angle = std::numeric_limits<double>::quiet_NaN();  ///< rad, from level
  double range = std::numeric_limits<double>::quiet_NaN();        ///< m
  bool feed_forward = false;  ///< the motion of the vehicle was made up for
  double manipulability = 0;  ///< of the posture commanded
  std::array<JointCut, kMostJoints> cuts{};
  bool clearance_cut = false;  ///< slowed, not to hit itself or the ground
};

/// Commands of an arm that keeps the pipe in the middle of the image, level, and in range.
///
/// An image shows of a straight pipe the plane through it and the camera, and when an end of it is
/// in view, where along it the camera looks. The controller keeps the normal of that plane, at rest
/// in the map, as the mean of what images show, and turns the camera's y axis to it. The control
/// law: resolved rates by damped least squares (Nakamura and Hanafusa, Inverse
/// Kinematic Solutions With Singularity Robustness, 1986), from the plane through the camera and
/// the pipe.
///
/// What is commanded keeps within the position and velocity limits of the URDF and
/// `largest_acceleration` in each step, and never gets to where the arm could not come to rest
/// within them and at `least_clearance`. Holding brakes as hard as that allows, from the very cycle
/// on in which an input is stale. Allocates nothing after construction. Not for use by several
/// threads at once.
class ArmController {
 public:
  /// Throws as ArmControllerParameters::validate, and std::invalid_argument when `ready` or `stow`
  /// is outside the joint limits or too close, or the way between them is, or the camera is in a
  /// singular posture when ready.
  ArmController(ArmModel model, const ArmControllerParameters& parameters);
  ArmController(ArmController&&) noexcept;
  ArmController& operator=(ArmController&&) noexcept;
  ~ArmController();

  /// Intrinsics of the images to come. With another size of the image what was tracked is
  /// forgotten.
  void set_camera(const geometry::Camera& camera);

  /// Each takes an input or says why not; counts either. `now`: s; not finite: kNotANumber.
  InputVerdict observe(const JointReadings& readings, double now);
  InputVerdict observe(const PipeSection& section, double now);
  InputVerdict observe(const VehicleMotion& motion, double now);

  /// The command of this cycle. What was commanded before counts as done, one period ago; a step
  /// less than half a period after the last one, or `now` before it or not finite, gives the last
  /// command again. When `now` goes back by more than a second (a simulation that begins again)
  /// everything but the camera and the counts is forgotten. Once stowed for want of a pipe it stays
  /// so until kStow and kTrack are requested in turn, or `reset`.
  ArmCommand step(double now, ArmRequest request);

  /// Forgets all but camera and counts, faults too.
  void reset() noexcept;

  [[nodiscard]] const ArmModel& model() const noexcept;
  [[nodiscard]] const ArmControllerParameters& parameters() const noexcept;
  /// How many inputs of each kind had each verdict since construction.
  using Counts = std::array<std::size_t, kInputVerdicts>;
  [[nodiscard]] const Counts& joint_counts() const noexcept;
  [[nodiscard]] const Counts& section_counts() const noexcept;
  [[nodiscard]] const Counts& motion_counts() const noexcept;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// For people: "taken", "not a number", ...; "idle", "tracking", ...; "no joint states yet", ...
[[nodiscard]] const char* to_string(InputVerdict verdict) noexcept;
[[nodiscard]] const char* to_string(ArmState state) noexcept;
[[nodiscard]] const char* to_string(ArmReason reason) noexcept;

}  // namespace pipescout::manipulation
