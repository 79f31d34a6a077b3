// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "pipescout/batch_estimation/batch_smoother.hpp"
#include "pipescout/estimation/fixed_lag_smoother.hpp"

namespace pipescout::benchmarks {

/// s, between keyframes.
inline constexpr double kKeyframeStep = 0.1;

/// What is measured between two keyframes, and at the second.
struct EstimatorStep {
  double time = 0;
  std::vector<estimation::ImuSample> imu{};
  std::optional<estimation::RelativePoseMeasurement> odometry{};
  std::optional<estimation::GpsMeasurement> gps{};
  std::optional<estimation::VisualPoseMeasurement> vision{};
};

/// Sensors as in the data set `fusion_stream`, without an end: IMU at 100 Hz, odometry (1 mm or 1
/// %, 0.5 mrad or 1 %) and vision (0.05 m, 0.5 deg) at 10 Hz, GPS (0.2 m) at 5 Hz, on a body that
/// flies loops.
class EstimatorStream {
 public:
  explicit EstimatorStream(std::uint64_t seed);
  /// The state at time 0.
  [[nodiscard]] const estimation::NavState& start() const noexcept { return start_; }
  /// The next step; the first leads from 0 to 0.1 s. Allocates nothing where `step` has room.
  void next(EstimatorStep& step);

 private:
  [[nodiscard]] Eigen::Vector3d noise(double deviation);

  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
  estimation::NavState start_;
  estimation::NavState state_;
  std::uint64_t steps_ = 0;
};

/// 60 s of one.
struct EstimatorRecording {
  estimation::NavState start{};
  std::vector<EstimatorStep> steps{};
  bool simulated = true;
};

/// `fusion_stream` itself when PIPESCOUT_SHARED_DATA says where it is, else simulated.
[[nodiscard]] EstimatorRecording estimator_recording(std::uint64_t seed);

/// Densities of that stream, no gates.
[[nodiscard]] estimation::FixedLagSmootherParameters estimator_parameters();

/// Starts at time 0.
void start(estimation::FixedLagSmoother& smoother, const estimation::NavState& state);
/// All but the update.
void feed(estimation::FixedLagSmoother& smoother, const EstimatorStep& step);

/// The window that the smoother has after `steps`[index] was fed and before it is updated, for
/// Ceres: the same factors, the estimates that the smoother begins with, and in place of what it
/// has left behind a Gaussian about the oldest keyframe.
[[nodiscard]] estimation::Recording window_for_ceres(const estimation::FixedLagSmoother& smoother,
                                                     const std::vector<EstimatorStep>& steps,
                                                     std::size_t index);

/// The first keyframes of a simulated stream, with the estimates of a fixed-lag smoother to begin
/// with.
[[nodiscard]] estimation::Recording batch_recording(std::uint64_t seed, std::size_t keyframes);

}  // namespace pipescout::benchmarks
