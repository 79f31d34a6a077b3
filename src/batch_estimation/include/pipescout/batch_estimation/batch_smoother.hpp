// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "pipescout/estimation/fixed_lag_smoother.hpp"

/// Batch smoothing of a whole recording by Ceres, with the factors of pipescout_estimation, for
/// reference trajectories and calibration. Frames and units as there.
namespace pipescout::estimation {

struct Recording {
  std::vector<double> times{};  ///< s, of the keyframes, each more than 1e-4 s after the last
  NavState first{};             ///< prior of the first keyframe's state
  StateMatrix first_covariance = StateMatrix::Zero();  ///< over the tangent space at `first`
  /// Initial values, a state for each keyframe; if empty, `first` is propagated by the IMU.
  std::vector<NavState> guesses{};
  /// Scale of the first integration of the IMU from each keyframe; the biases are those of the
  /// initial values. If empty, that of BatchSmootherParameters::globals.
  std::vector<ImuScale> imu_scale_guesses{};
  std::vector<ImuSample> imu{};  ///< in order of time
  /// In any order, between the keyframes: measurements of factors.hpp, and factors of the user.
  std::vector<AnyFactor> measurements{};
};

enum class LinearSolver : std::uint8_t {
  kSparseCholesky,  ///< on the normal equations of all states
  kSparseSchur,     ///< every other keyframe first, as far as factors allow it
};

struct BatchSmootherParameters {
  double gravity = 9.81;  ///< m/s^2, in [0, 100]
  Earth earth{};
  /// s, for which the last IMU sample replaces missing ones; in [0, 1]
  double max_held_imu = 0.03;
  ImuNoise imu_noise{};
  /// Process noise of velocity and rotation (random walks) while IMU samples are missing.
  double coasting_acceleration = 1;    ///< m/s^2/sqrt(Hz), in [1e-6, 1000]
  double coasting_angular_rate = 0.3;  ///< rad/s/sqrt(Hz), in [1e-6, 1000]
  double coasting_turn = 0;            ///< rad/s/sqrt(Hz), about the vertical, added; in [0, 1000]
  GlobalStates globals{};              ///< their initial values
  GlobalDeviations global_deviations{};
  /// Kernels by FactorKind; gates are not used.
  std::array<Robustness, kFactorKinds> robustness{};
  LinearSolver linear_solver = LinearSolver::kSparseCholesky;
  int max_iterations = 50;  ///< of each solution, in [1, 10000]
  double tolerance = 1e-9;  ///< relative change of the cost that ends it, in [1e-16, 1e-2]
  /// Largest number of re-integrations of the IMU with the estimated biases and scale, each
  /// followed by another solution, while these change by more than 1e-4 rad/s, 1e-3 m/s^2 or 1e-4.
  /// In [0, 100].
  int max_reintegrations = 3;

  /// Those that the two smoothers share.
  [[nodiscard]] static BatchSmootherParameters like(const FixedLagSmootherParameters& online);
  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct BatchProgress {
  int reintegrations = 0;  ///< so far
  int iteration = 0;       ///< of this solution
  double cost = 0;         ///< half the sum of all chi-squares, after the kernels
};
/// Called after each iteration; false stops with the current estimate.
using BatchProgressCallback = std::function<bool(const BatchProgress&)>;

struct BatchReport {
  bool converged = false;
  double first_cost = 0;
  double cost = 0;
  int iterations = 0;  ///< of all solutions
  int reintegrations = 0;
  double coasted = 0;           ///< s without the IMU
  std::size_t refused_imu = 0;  ///< samples: not finite, of zero duration, or not after the last
  std::vector<FactorReport> factors{};  ///< of the measurements, in their order, then of the IMU;
                                        // /< including refused ones (kLate, kFuture: not between
                                        // the keyframes; or as InputFault)
  std::string message{};                ///< of Ceres
};

/// A recording, and the estimate of its states. Memory (some 50 kB a keyframe) and time grow
/// linearly with its length. Deterministic, and on one thread, as far as the BLAS under Ceres is.
/// Not thread-safe.
class BatchSmoother {
 public:
  /// Throws std::invalid_argument as BatchSmootherParameters::validate and PriorFactor, and when
  /// times are empty, not finite or not in order, or initial values are not finite or of another
  /// number.
  BatchSmoother(const BatchSmootherParameters& parameters, Recording recording);
  ~BatchSmoother();
  BatchSmoother(BatchSmoother&&) noexcept;
  BatchSmoother& operator=(BatchSmoother&&) noexcept;

  /// Continues from the current estimate. The report is valid until the next call. Invalid data do
  /// not throw; they are reported.
  const BatchReport& solve(const BatchProgressCallback& progress = {});

  /// One for each keyframe.
  [[nodiscard]] const std::vector<NavState>& states() const noexcept;
  [[nodiscard]] const GlobalStates& globals() const noexcept;

  /// Over the tangent spaces at the estimates, in the order of `keyframes`, whose range is not
  /// checked. Empty when the equations are singular. Takes a QR decomposition of all equations, and
  /// for each keyframe 15 substitutions over the whole recording.
  [[nodiscard]] std::vector<StateMatrix> covariances(std::span<const std::size_t> keyframes) const;
  /// Zero rows and columns for states that are not estimated; all zero when the equations are
  /// singular.
  [[nodiscard]] Eigen::Matrix<double, kGlobalSize, kGlobalSize> global_covariance() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::estimation
