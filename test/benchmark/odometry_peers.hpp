// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "odometry_inputs.hpp"
#include "pipescout/odometry/weld_positioning.hpp"

/// The plain ways to do what the odometry benchmark measures: a yardstick for the time that
/// everything else costs, not rivals in what they find.
namespace pipescout::benchmarks {

/// The paper's method and no more: `ConsensusFusion` on the latest reading of each wheel, once for
/// each round of samples. Returns the sum of the distances.
[[nodiscard]] double fuse_each_round(const WheelInput& input);

/// Doublets of four widths, correlated with the samples around each sample by direct convolution:
/// no background, no decision, no place.
class DirectConvolution {
 public:
  DirectConvolution();
  /// The largest output of the four.
  double next(std::complex<double> value);

 private:
  static constexpr std::size_t kWidths = 4;
  static constexpr std::size_t kTaps = 64;  ///< 0.1 m at 0.3 m/s and 200 samples a second
  std::array<std::array<double, kTaps>, kWidths> kernels_{};
  std::array<std::complex<double>, kTaps> latest_{};
  std::size_t next_ = 0;
};

/// The place in the tally, in either direction, whose lengths are nearest to the latest ones:
/// least squares over all places, with one hypothesis, no scale and no missed welds.
class FingerprintSearch {
 public:
  explicit FingerprintSearch(std::span<const odometry::TallyJoint> tally);
  std::size_t add_joint(double length);

 private:
  static constexpr std::size_t kLatest = 10;
  std::vector<double> lengths_;
  std::vector<double> reversed_;
  std::vector<double> latest_;
};

/// Needleman and Wunsch on the joint lengths, the full matrix: one scale, no probabilities.
/// Returns the number of joints that are matched.
[[nodiscard]] std::size_t align_full_matrix(std::span<const odometry::WeldPosition> a,
                                            std::span<const odometry::WeldPosition> b);

}  // namespace pipescout::benchmarks
