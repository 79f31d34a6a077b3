// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "pipescout/estimation/fixed_lag_smoother.hpp"

/// A whole recording smoothed at once by Ceres, with the factors of pipescout_estimation: reference
/// trajectories, and what the sensors' calibration is. Frames and units as there.
namespace pipescout::estimation {

using AnyMeasurement =
    std::variant<GpsMeasurement, HeadingMeasurement, VisualPoseMeasurement, WeldMeasurement,
                 NonHolonomicMeasurement, ZeroVelocityMeasurement, OdometerMeasurement,
                 RelativePoseMeasurement, ZeroAngularRateMeasurement, CentreLineMeasurement>;

struct Recording {
  std::vector<double> times{};  ///< s, of the keyframes, each more than 1e-4 s after the last
  NavState first{};             ///< what is known beforehand of the first keyframe's state
  StateMatrix first_covariance = StateMatrix::Zero();  ///< over the tangent space at `first`
  /// Where to begin, a state for each keyframe; without any the IMU carries `first` on.
  std::vector<NavState> guesses{};
  /// With what scale the IMU is first integrated from each keyframe on, as from each guess with
  /// its biases; without any it is the one in BatchSmootherParameters::globals.
  std::vector<ImuScale> imu_scale_guesses{};
  std::vector<ImuSample> imu{};                ///< in order of time
  std::vector<AnyMeasurement> measurements{};  ///< in any order, between the keyframes
};

enum class LinearSolver : std::uint8_t {
  kSparseCholesky,  ///< of the normal equations of all states
  kSparseSchur,     ///< every other keyframe first, as far as factors allow it
};

struct BatchSmootherParameters {
  double gravity = 9.81;       ///< m/s^2, in [0, 100]
  double max_held_imu = 0.03;  ///< s, that the last IMU sample stands for those missing;
                               ///< in [0, 1]
  ImuNoise imu_noise{};
  /// Where the IMU says nothing the velocity and the rotation walk at random.
  double coasting_acceleration = 1;    ///< m/s^2/sqrt(Hz), in [1e-6, 1000]
  double coasting_angular_rate = 0.3;  ///< rad/s/sqrt(Hz), in [1e-6, 1000]
  GlobalStates globals{};              ///< what is known of them beforehand
  GlobalDeviations global_deviations{};
  /// Kernels by FactorKind; gates are not used: all is judged together.
  std::array<Robustness, kFactorKinds> robustness{};
  LinearSolver linear_solver = LinearSolver::kSparseCholesky;
  int max_iterations = 50;  ///< of each solution, in [1, 10000]
  double tolerance = 1e-9;  ///< relative change of the cost that ends it, in [1e-16, 1e-2]
  /// How often the IMU is integrated anew with the biases and the scale found, and all is solved
  /// again, while these still change by more than 1e-4 rad/s, 1e-3 m/s^2 or 1e-4. In [0, 100].
  int max_reintegrations = 3;

  /// Those that the two smoothers share.
  [[nodiscard]] static BatchSmootherParameters like(const FixedLagSmootherParameters& online);
  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct BatchProgress {
  int reintegrations = 0;  ///< so far
  int iteration = 0;       ///< of this solution
  double cost = 0;         ///< half the sum of all chi-squares, as the kernels have them
};
/// Called after each iteration; false ends the work with what is there.
using BatchProgressCallback = std::function<bool(const BatchProgress&)>;

struct BatchReport {
  bool converged = false;
  double first_cost = 0;
  double cost = 0;
  int iterations = 0;  ///< of all solutions
  int reintegrations = 0;
  double coasted = 0;           ///< s without the IMU
  std::size_t refused_imu = 0;  ///< samples: not finite, of no duration, or not after the last
  std::vector<FactorReport> factors{};  ///< of the measurements, in their order, then of the IMU;
                                        ///< those refused too (kLate, kFuture: not between the
                                        ///< keyframes; or what InputFault says)
  std::string message{};                ///< of Ceres
};

/// A recording, and the estimate of its states. Memory (some 50 kB a keyframe) and time grow
/// linearly with its length. Deterministic, and on one thread, as far as the BLAS under Ceres is.
/// Not thread-safe.
class BatchSmoother {
 public:
  /// Throws std::invalid_argument as BatchSmootherParameters::validate and PriorFactor, and when
  /// the times are none, not finite or not in order, or guesses are not finite or not as many.
  BatchSmoother(const BatchSmootherParameters& parameters, Recording recording);
  ~BatchSmoother();
  BatchSmoother(BatchSmoother&&) noexcept;
  BatchSmoother& operator=(BatchSmoother&&) noexcept;

  /// Goes on from the estimate that is there. The report is valid until the next call. Bad data do
  /// not throw; they are reported.
  const BatchReport& solve(const BatchProgressCallback& progress = {});

  /// One for each keyframe.
  [[nodiscard]] const std::vector<NavState>& states() const noexcept;
  [[nodiscard]] const GlobalStates& globals() const noexcept;

  /// Over the tangent spaces at the estimates, in the order of `keyframes`, whose range is not
  /// checked. Empty when the equations are singular. Costs a QR decomposition of all equations, and
  /// for each keyframe 15 substitutions over the whole recording.
  [[nodiscard]] std::vector<StateMatrix> covariances(std::span<const std::size_t> keyframes) const;
  /// Zero rows and columns for what is not estimated; all zero when the equations are singular.
  [[nodiscard]] Eigen::Matrix<double, kGlobalSize, kGlobalSize> global_covariance() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::estimation
