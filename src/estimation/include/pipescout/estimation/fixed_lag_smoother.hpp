// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "pipescout/estimation/factors.hpp"
#include "pipescout/estimation/imu_timeline.hpp"
#include "pipescout/estimation/robustness.hpp"

namespace pipescout::estimation {

/// Prior standard deviations of the global states; 0: the part is constant and not estimated. Each
/// in {0} or [1e-9, 1e6]. The mount angles are almost indistinguishable from the heading: while
/// they are estimated, the distance from the linearisation point must stay below 1e-3 rad
/// (RelinearisationThresholds::rotation), or they become wrong by several standard deviations.
struct GlobalDeviations {
  double odometer_scale = 0;
  double mount_yaw = 0;                ///< rad
  double mount_pitch = 0;              ///< rad
  double rack_position = 0;            ///< m, per axis
  double rack_rotation = 0;            ///< rad, per axis
  double gps_lever_arm = 0;            ///< m, per axis
  double gps_time_offset = 0;          ///< s
  double visual_pose_time_offset = 0;  ///< s
  double gyro_scale = 0;               ///< per axis
  double gyro_misalignment = 0;        ///< rad, of each axis towards each of the others
  double accelerometer_scale = 0;
  double accelerometer_misalignment = 0;  ///< rad
  OwnVector own = OwnVector::Zero();      ///< of GlobalStates::own, one by one

  /// In the order of the tangent space of GlobalStates.
  [[nodiscard]] GlobalVector tangent() const;
  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Largest distance of a state from its linearisation point. Only rotations are nonlinear:
/// positions, velocities and biases matter only as far as they are multiplied by rotations.
struct RelinearisationThresholds {
  double position = 0.1;            ///< m, in [1e-9, 1]
  double rotation = 0.01;           ///< rad, in [1e-9, 1]
  double velocity = 0.2;            ///< m/s, in [1e-9, 10]
  double gyro_bias = 0.005;         ///< rad/s, in [1e-9, 1]
  double accelerometer_bias = 0.2;  ///< m/s^2, in [1e-9, 10]
  double odometer_scale = 1e-3;     ///< in [1e-9, 1]
  double mount = 1e-3;              ///< rad, yaw and pitch, in [1e-9, 1]
  double time_offset = 0.01;        ///< s, of GPS and of visual poses, in [1e-9, 1]
  double imu_scale = 0.005;         ///< and misalignment, in [1e-9, 1]
  /// Of GlobalStates::own, one by one; at least 1e-9. Infinite: factors are linear in it.
  OwnVector own = OwnVector::Constant(std::numeric_limits<double>::infinity());
};

struct FixedLagSmootherParameters {
  double lag = 2;                             ///< s, in [0.01, 1000]
  std::size_t max_keyframes = 32;             ///< with more, the lag is shortened; in [3, 10000]
  std::size_t max_factors_per_keyframe = 16;  ///< in [1, 1000]
  std::size_t max_waiting = 64;               ///< measurements between updates; in [1, 100000]
  std::size_t max_imu_samples = 2048;         ///< within the lag; in [16, 10000000]
  double max_step = 1;  ///< s, between keyframes; more is a jump in time; in [1e-3, 100]
  double max_held_imu =
      0.03;               ///< s, for which the last IMU sample replaces missing ones; in [0, 1]
  double gravity = 9.81;  ///< m/s^2, in [0, 100]
  Earth earth{};
  ImuNoise imu_noise{};
  /// Process noise of velocity and rotation (random walks) while IMU samples are missing.
  double coasting_acceleration = 1;    ///< m/s^2/sqrt(Hz), in [1e-6, 1000]
  double coasting_angular_rate = 0.3;  ///< rad/s/sqrt(Hz), in [1e-6, 1000]
  /// About the vertical, in addition: what stands on the ground or hovers turns more than it tilts.
  double coasting_turn = 0;  ///< rad/s/sqrt(Hz), in [0, 1000]
  GlobalStates globals{};    ///< their initial values
  GlobalDeviations global_deviations{};
  /// Random walks of GlobalStates::own, per sqrt(s); 0: constant. In {0} or [1e-9, 1e6]. Within the
  /// lag a state is taken for constant: it walks when keyframes leave.
  OwnVector own_walks = OwnVector::Zero();
  /// By FactorKind. Kernels apply to all factors of measurements, gates to those of one time.
  std::array<Robustness, kFactorKinds> robustness = default_robustness();
  RelinearisationThresholds relinearisation{};
  /// linearisations in one update; remaining ones follow in the next. In [1, 100]
  int max_iterations = 3;

  /// Estimates how the camera of visual poses is mounted, from these standard deviations of its
  /// position (m) and rotation (rad), per axis, in {0} (known) or [1e-9, 1e6] and {0} or [1e-9, 1],
  /// in the last six of GlobalStates::own. Returns their place, for
  /// VisualPoseMeasurement::mounting. Throws std::invalid_argument naming the argument, or that
  /// they are in use.
  int estimate_camera_mounting(double position_deviation, double rotation_deviation);

  /// No kernels, gates of 0.9999 for GPS, headings, visual poses, welds, centre lines and factors
  /// of the user.
  [[nodiscard]] static std::array<Robustness, kFactorKinds> default_robustness();
  [[nodiscard]] ImuIntegration imu_integration() const noexcept;
  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Outcome of a measurement.
enum class Outcome : std::uint8_t {
  kAccepted,  ///< in the equations
  kWaiting,   ///< for an update at or after its time
  kGated,  ///< rejected by the chi-square gate, alone or together with the measurements of the same
           ///< update
  kLate,   ///< older than the lag
  kFuture,         ///< more than `max_step` ahead of the newest keyframe
  kDuplicate,      ///< a measurement with the same values and time exists
  kNotFinite,      ///< a NaN or infinity
  kBadCovariance,  ///< see InputFault
  kBadInterval,    ///< `to_time` not after `from_time`, or not in the same or the next keyframe
                   ///< interval
  kBadDirection,   ///< see InputFault
  kFull,  ///< no space, see the parameters; or more than 18 rows of relative measurements between
          ///< two keyframes
  kUninitialised,  ///< not initialised yet
  kQuarantined,    ///< it would have made the equations singular or moved the estimate by more than
                   ///< 1e6 (SI), or its derivatives are not finite
  kDead,  ///< a reading of an IMU that does not measure: a specific force of exactly 0, or an
          ///< angular rate that has repeated itself for long
};
inline constexpr std::size_t kOutcomes = 14;
/// The outcome for a measurement with this fault; `sound`: for one without.
[[nodiscard]] Outcome outcome_of(InputFault fault, Outcome sound) noexcept;
/// "accepted", "waiting", "gated", ...; "unknown" for any other value.
[[nodiscard]] std::string_view to_string(Outcome outcome) noexcept;

/// Reason of a reset.
enum class ResetReason : std::uint8_t {
  kNone,
  kTimeJumpForwards,   ///< an update more than `max_step` after the last
  kTimeJumpBackwards,  ///< an update before the lag
  kNumericalFailure,   ///< the equations cannot be solved, and no single factor is the cause
};
/// "none", "time_jump_forwards", ...; "unknown" for any other value.
[[nodiscard]] std::string_view to_string(ResetReason reason) noexcept;

/// One factor after an update.
struct FactorReport {
  FactorKind kind = FactorKind::kImu;
  Outcome outcome = Outcome::kAccepted;
  double time = 0;        ///< s, of the measurement; of relative ones `to_time`
  double chi_square = 0;  ///< at the estimate; of gated ones, against their prediction
  int degrees = 0;        ///< rows
  double weight = 1;      ///< of the robust kernel; 0 if not in the equations
};

struct UpdateReport {
  bool initialised = false;  ///< an estimate is available
  bool new_keyframe = false;
  bool time_refused = false;               ///< the time was not finite: no update
  ResetReason reset = ResetReason::kNone;  ///< reason of a reset in this update
  int iterations = 0;                      ///< linearisations
  int relinearised = 0;                    ///< relinearised states, over all iterations
  int marginalised = 0;                    ///< keyframes that left the window
  bool converged = false;                  ///< no state needs relinearisation
  double coasted = 0;                      ///< s of this step without the IMU
  std::vector<FactorReport> factors{};     ///< factors added by this update
};

/// Counts of one kind of factor since construction.
using OutcomeCounts = std::array<std::size_t, kOutcomes>;

/// Joint estimation of the keyframes of the last `lag` seconds, connected by the IMU, and of global
/// states. Older keyframes are marginalised to a Gaussian of the oldest keyframe and the global
/// states.
///
/// Normal equations are eliminated from the oldest keyframe to the newest, the global states last:
/// 15 x 15 blocks along a chain with a border. The Schur complement of each keyframe on the next
/// one is stored, so that an update begins at the oldest keyframe that it changes, and
/// marginalising the oldest keyframe is free. States in the marginal prior keep their first
/// linearisation point (first-estimates Jacobians; residuals are those of the current estimate).
/// Steps that raise the cost are damped (Levenberg and Marquardt).
///
/// Use: `initialise`, then `add` for each measurement, in any order, and `update` at each keyframe.
/// A measurement between two keyframes belongs to the earlier one, propagated to its time by the
/// IMU.
///
/// Only the constructor and `initialise` throw. After construction nothing allocates.
/// Deterministic. Not thread-safe: one thread at a time.
class FixedLagSmoother {
 public:
  /// Throws as FixedLagSmootherParameters::validate.
  explicit FixedLagSmoother(const FixedLagSmootherParameters& parameters);
  ~FixedLagSmoother();
  FixedLagSmoother(FixedLagSmoother&&) noexcept;
  FixedLagSmoother& operator=(FixedLagSmoother&&) noexcept;

  /// Resets everything except the counts and starts with one keyframe. Global states start as in
  /// the parameters. Throws std::invalid_argument when the time is not finite, and as PriorFactor.
  void initialise(double time, const NavState& mean, const StateMatrix& covariance);
  /// The same, but global states keep their estimates with their standard deviations; if the time
  /// is that of the newest keyframe, IMU samples and waiting measurements are kept.
  void restart(double time, const NavState& mean, const StateMatrix& covariance);

  /// In order of time; may overlap or leave gaps. Refused: not finite or beyond 1e4 rad/s, 1e6
  /// m/s^2 (kNotFinite); zero duration or one above `max_step` (kBadInterval); at or before the end
  /// of the last one (kLate, kDuplicate); more than twice `max_step` after the newest keyframe
  /// (kFuture). Samples before a keyframe must be added before its update; later they have no
  /// effect.
  Outcome add(const ImuSample& sample) noexcept;
  /// Any measurement of factors.hpp, and factors of the user, see factor.hpp. kWaiting, or the
  /// reason of a refusal.
  Outcome add(const AnyFactor& factor) noexcept;

  /// Adds a keyframe at `time` and all waiting measurements up to it, marginalises keyframes older
  /// than the lag, and solves. Less than 1e-4 s after the newest keyframe, or before it but within
  /// the lag, it adds no keyframe, only late measurements. The report is valid until the next
  /// update.
  const UpdateReport& update(double time) noexcept;

  /// From the next keyframe on. Throws as Earth::validate.
  void set_earth(const Earth& earth);

  [[nodiscard]] bool initialised() const noexcept;
  /// The following are for keyframes 0 (oldest) to keyframes() - 1; indices are not checked.
  [[nodiscard]] std::size_t keyframes() const noexcept;
  [[nodiscard]] double time(std::size_t keyframe) const noexcept;
  [[nodiscard]] const NavState& state(std::size_t keyframe) const noexcept;
  /// Over the tangent space at the linearisation point, which is within the thresholds of the
  /// estimate. The computing time grows with the distance to the newest keyframe.
  [[nodiscard]] StateMatrix covariance(std::size_t keyframe) const noexcept;

  [[nodiscard]] const GlobalStates& globals() const noexcept;
  /// In the order of GlobalVector; zero rows and columns for states that are not estimated.
  [[nodiscard]] Eigen::Matrix<double, kGlobalSize, kGlobalSize> global_covariance() const noexcept;

  /// The newest keyframe propagated by all later IMU samples; its time. Nothing when not
  /// initialised.
  struct Propagated {
    double time = 0;
    NavState state{};
  };
  [[nodiscard]] std::optional<Propagated> propagated() const noexcept;
  /// Covariance of `propagated()`. Must be initialised; not checked.
  [[nodiscard]] StateMatrix propagated_covariance() const noexcept;

  /// Factors in the equations, oldest first, with chi-squares at the estimate; includes IMU
  /// factors. Clears `reports`; allocates if its capacity is too small.
  void report_factors(std::vector<FactorReport>& reports) const;
  [[nodiscard]] const OutcomeCounts& counts(FactorKind kind) const noexcept;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::estimation
