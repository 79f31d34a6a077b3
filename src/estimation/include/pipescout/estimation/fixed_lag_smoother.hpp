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

/// Standard deviations of what is known beforehand of the global states; 0 keeps a part at its
/// initial value and out of the equations. Each in {0} or [1e-9, 1e6]. The mount angles hide behind
/// the heading: while they are sought, states must not be linearised farther off than 1e-3 rad
/// (RelinearisationThresholds::rotation), or they come out wrong by several deviations.
struct GlobalDeviations {
  double odometer_scale = 0;
  double mount_yaw = 0;          ///< rad
  double mount_pitch = 0;        ///< rad
  double rack_position = 0;      ///< m, per axis
  double rack_rotation = 0;      ///< rad, per axis
  double gps_lever_arm = 0;      ///< m, per axis
  double gps_time_offset = 0;    ///< s
  double gyro_scale = 0;         ///< per axis
  double gyro_misalignment = 0;  ///< rad, of each axis towards each of the others
  double accelerometer_scale = 0;
  double accelerometer_misalignment = 0;  ///< rad

  /// In the order of the tangent space of GlobalStates.
  [[nodiscard]] GlobalVector tangent() const;
  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// How far a state may move from where it was linearised. Only rotations bend the equations:
/// positions, velocities and biases matter as far as they are turned.
struct RelinearisationThresholds {
  double position = 0.1;            ///< m, in [1e-9, 1]
  double rotation = 0.01;           ///< rad, in [1e-9, 1]
  double velocity = 0.2;            ///< m/s, in [1e-9, 10]
  double gyro_bias = 0.005;         ///< rad/s, in [1e-9, 1]
  double accelerometer_bias = 0.2;  ///< m/s^2, in [1e-9, 10]
  double odometer_scale = 1e-3;     ///< in [1e-9, 1]
  double mount = 1e-3;              ///< rad, yaw and pitch, in [1e-9, 1]
  double gps_time_offset = 0.01;    ///< s, in [1e-9, 1]
  double imu_scale = 0.005;         ///< and misalignment, in [1e-9, 1]
};

struct FixedLagSmootherParameters {
  double lag = 2;                             ///< s, in [0.01, 1000]
  std::size_t max_keyframes = 32;             ///< beyond it the lag is shorter; in [3, 10000]
  std::size_t max_factors_per_keyframe = 16;  ///< in [1, 1000]
  std::size_t max_waiting = 64;               ///< measurements between updates; in [1, 100000]
  std::size_t max_imu_samples = 2048;         ///< within the lag; in [16, 10000000]
  double max_step = 1;         ///< s, between keyframes; more is a jump of time; in [1e-3, 100]
  double max_held_imu = 0.03;  ///< s, that the last IMU sample stands for those missing;
                               ///< in [0, 1]
  double gravity = 9.81;       ///< m/s^2, in [0, 100]
  ImuNoise imu_noise{};
  /// Where the IMU says nothing the velocity and the rotation walk at random.
  double coasting_acceleration = 1;    ///< m/s^2/sqrt(Hz), in [1e-6, 1000]
  double coasting_angular_rate = 0.3;  ///< rad/s/sqrt(Hz), in [1e-6, 1000]
  GlobalStates globals{};              ///< what is known of them beforehand
  GlobalDeviations global_deviations{};
  /// By FactorKind. Kernels are for all that are made of measurements, gates for those of one time.
  std::array<Robustness, kFactorKinds> robustness = default_robustness();
  RelinearisationThresholds relinearisation{};
  int max_iterations = 3;  ///< linearisations in one update; what is left waits for the next. In
                           ///< [1, 100]

  /// No kernels, gates of 0.9999 for GPS, headings, visual poses, welds and centre lines.
  [[nodiscard]] static std::array<Robustness, kFactorKinds> default_robustness();
  [[nodiscard]] ImuIntegration imu_integration() const noexcept;
  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// What became of a measurement.
enum class Outcome : std::uint8_t {
  kAccepted,       ///< in the equations
  kWaiting,        ///< for an update at or after its time
  kGated,          ///< refused by the consistency gate, before what came with it or after
  kLate,           ///< older than the lag
  kFuture,         ///< more than `max_step` ahead of the newest keyframe
  kDuplicate,      ///< the same numbers of the same time are there already
  kNotFinite,      ///< a NaN or infinity
  kBadCovariance,  ///< see InputFault
  kBadInterval,    ///< `to_time` not after `from_time`, or not in the same or the next keyframe
                   ///< interval
  kBadDirection,   ///< see InputFault
  kFull,           ///< no room: see the parameters; or more than 18 rows of relative measurements
                   ///< between two keyframes
  kUninitialised,  ///< there is no state yet
  kQuarantined,    ///< it would have made the equations singular or have led the estimate more than
                   ///< 1e6 (SI) away, or its derivatives are not finite
};
inline constexpr std::size_t kOutcomes = 13;
/// What becomes of a measurement with such a fault; `sound`: of one without.
[[nodiscard]] Outcome outcome_of(InputFault fault, Outcome sound) noexcept;
/// "accepted", "waiting", "gated", ...; "unknown" for a value that is no enumerator.
[[nodiscard]] std::string_view to_string(Outcome outcome) noexcept;

/// Why all was forgotten.
enum class ResetReason : std::uint8_t {
  kNone,
  kTimeJumpForwards,   ///< an update more than `max_step` after the last
  kTimeJumpBackwards,  ///< an update before the lag
  kNumericalFailure,   ///< the equations cannot be solved, though no single factor is to blame
};
/// "none", "time_jump_forwards", ...; "unknown" for a value that is no enumerator.
[[nodiscard]] std::string_view to_string(ResetReason reason) noexcept;

/// One factor after an update.
struct FactorReport {
  FactorKind kind = FactorKind::kImu;
  Outcome outcome = Outcome::kAccepted;
  double time = 0;        ///< s, of the measurement; of relative ones `to_time`
  double chi_square = 0;  ///< at the estimate; of gated ones, against their prediction
  int degrees = 0;        ///< rows
  double weight = 1;      ///< of the robust kernel; 0 for what is not in the equations
};

struct UpdateReport {
  bool initialised = false;  ///< there is an estimate
  bool new_keyframe = false;
  bool time_refused = false;               ///< it was not finite: nothing was done
  ResetReason reset = ResetReason::kNone;  ///< why this update has forgotten all
  int iterations = 0;                      ///< linearisations
  int relinearised = 0;                 ///< states that were linearised anew, over all iterations
  int marginalised = 0;                 ///< keyframes that have left the lag
  bool converged = false;               ///< nothing is left to linearise anew
  double coasted = 0;                   ///< s of this step without the IMU
  std::vector<FactorReport> factors{};  ///< those that came in with this update
};

/// Of one kind of factor, since construction.
using OutcomeCounts = std::array<std::size_t, kOutcomes>;

/// Keyframes of the last `lag` seconds, linked by the IMU, and global states, estimated together;
/// what is older is kept as a Gaussian about the oldest keyframe and the global states.
///
/// Normal equations are eliminated from the oldest keyframe to the newest, the global states last:
/// 15 x 15 blocks along a chain with a border. What the elimination of a keyframe leaves to the
/// next is kept, so that an update begins at the oldest keyframe that it changes, and so that
/// leaving out the oldest costs nothing: what it leaves is the Schur complement. States bound by it
/// keep the place where they were linearised first (first-estimates Jacobians; residuals are those
/// of the estimate). Steps that raise the cost are damped (Levenberg and Marquardt).
///
/// Use: `initialise`, then `add` as measurements come, in any order, and `update` at each keyframe.
/// A measurement between two keyframes belongs to the earlier, carried to its time by the IMU.
///
/// Nothing but the constructor and `initialise` throws. After construction nothing allocates.
/// Deterministic. Not thread-safe: one thread at a time.
class FixedLagSmoother {
 public:
  /// Throws as FixedLagSmootherParameters::validate.
  explicit FixedLagSmoother(const FixedLagSmootherParameters& parameters);
  ~FixedLagSmoother();
  FixedLagSmoother(FixedLagSmoother&&) noexcept;
  FixedLagSmoother& operator=(FixedLagSmoother&&) noexcept;

  /// Forgets all but the counts and starts with one keyframe. Global states start as in the
  /// parameters. Throws std::invalid_argument when the time is not finite, and as PriorFactor.
  void initialise(double time, const NavState& mean, const StateMatrix& covariance);
  /// The same, but global states go on from their estimates, with their standard deviations; at the
  /// time of the newest keyframe IMU samples and waiting measurements are kept.
  void restart(double time, const NavState& mean, const StateMatrix& covariance);

  /// In order of time; may overlap or leave gaps. Refused: not finite, or of a size that no sensor
  /// measures (kNotFinite: above 1e4 rad/s, 1e6 m/s^2); no duration or one above `max_step`
  /// (kBadInterval); at or before the end of the last one (kLate, kDuplicate); more than twice
  /// `max_step` after the newest keyframe (kFuture). Those of the time before a keyframe have to
  /// come before its update: later they change no more.
  Outcome add(const ImuSample& sample) noexcept;
  /// kWaiting, or why it is refused.
  Outcome add(const GpsMeasurement& m) noexcept;
  Outcome add(const HeadingMeasurement& m) noexcept;
  Outcome add(const VisualPoseMeasurement& m) noexcept;
  Outcome add(const WeldMeasurement& m) noexcept;
  Outcome add(const CentreLineMeasurement& m) noexcept;
  Outcome add(const NonHolonomicMeasurement& m) noexcept;
  Outcome add(const ZeroVelocityMeasurement& m) noexcept;
  Outcome add(const OdometerMeasurement& m) noexcept;
  Outcome add(const RelativePoseMeasurement& m) noexcept;
  Outcome add(const ZeroAngularRateMeasurement& m) noexcept;

  /// Adds a keyframe at `time` and all waiting measurements up to it, drops what leaves the lag,
  /// and solves. Less than 1e-4 s after the newest keyframe, or before it but within the lag: no
  /// new keyframe; late measurements go in. The report is valid until the next update.
  const UpdateReport& update(double time) noexcept;

  [[nodiscard]] bool initialised() const noexcept;
  /// The following are for keyframes 0 (oldest) to keyframes() - 1; indices are not checked.
  [[nodiscard]] std::size_t keyframes() const noexcept;
  [[nodiscard]] double time(std::size_t keyframe) const noexcept;
  [[nodiscard]] const NavState& state(std::size_t keyframe) const noexcept;
  /// Over the tangent space at the place of linearisation, which is within the thresholds of the
  /// estimate. The cost grows with the distance to the newest.
  [[nodiscard]] StateMatrix covariance(std::size_t keyframe) const noexcept;

  [[nodiscard]] const GlobalStates& globals() const noexcept;
  /// 31 x 31; zero rows and columns for what is not estimated.
  [[nodiscard]] Eigen::Matrix<double, kGlobalSize, kGlobalSize> global_covariance() const noexcept;

  /// The newest keyframe carried on by all IMU samples since; its time. Without a state: not
  /// initialised, nothing.
  struct Propagated {
    double time = 0;
    NavState state{};
  };
  [[nodiscard]] std::optional<Propagated> propagated() const noexcept;
  /// That of `propagated()`. Not checked: initialised.
  [[nodiscard]] StateMatrix propagated_covariance() const noexcept;

  /// Factors in the equations now, oldest first, chi-squares at the estimate; IMU factors included.
  /// Clears `reports`; allocates where that has no room.
  void report_factors(std::vector<FactorReport>& reports) const;
  [[nodiscard]] const OutcomeCounts& counts(FactorKind kind) const noexcept;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::estimation
