// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

/// First poses and predictions that are wrong.
namespace pipescout::rack_study {

struct FirstPoseSettings {
  double position_error = 0.05;                         ///< m, in a random direction
  double orientation_error = 5 * 0.017453292519943295;  ///< rad, about a random axis
  double outlier_share = 0;
};

struct FirstPoseScore {
  std::size_t trials = 0;
  std::size_t converged = 0;     ///< said to be good, and within what the covariance says
  std::size_t refused = 0;       ///< the status says that it is not to be used
  std::size_t silent_wrong = 0;  ///< said to be good, and 7 standard deviations off or more

  FirstPoseScore& operator+=(const FirstPoseScore& other) noexcept;
};

/// One frame each, at random places of flights over the paper's rack, 25 texture points a pipe,
/// 2 px of noise and quantised pixels.
[[nodiscard]] FirstPoseScore try_first_poses(const FirstPoseSettings& settings, std::size_t trials,
                                             std::uint64_t seed);

}  // namespace pipescout::rack_study
