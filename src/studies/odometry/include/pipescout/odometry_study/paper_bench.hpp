// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

/// The set-up of Wang, Cao, Luan and Zhang (Robot 30(3), 2008), section 4, as a stream: a bench of
/// 18 joints of 5.5 m, three wheels of sigma 0.06, 0.055 and 0.056 m a joint, 50 samples a second
/// at 0.3 m/s, counted in millimetres.
namespace pipescout::odometry_study {

inline constexpr double kBenchJoint = 5.5;  ///< m
inline constexpr int kBenchJoints = 18;

/// Which readings of a joint are wrong: by 0.2 m (3.6 sigma) to 1.65 m, because the wheel slips by
/// up to 30 % on some stretch of the joint.
enum class BenchSlips : std::uint8_t {
  kNone,
  kOneAtATime,   ///< one reading in ten, never two of one joint
  kIndependent,  ///< each with probability 0.1: two of three at once in 3 % of the joints
};

struct BenchError {
  double percent_at_ten_joints = 0.0;  ///< of the distance, absolute
  double percent = 0.0;                ///< the same at the end of the bench
  double sigmas = 0.0;                 ///< at the end, in stated standard deviations, signed
};

/// One drive along the bench, with a fusion that is told the sigmas. The same seed, the same bits.
[[nodiscard]] BenchError run_paper_bench(BenchSlips slips, std::uint64_t seed);

}  // namespace pipescout::odometry_study
