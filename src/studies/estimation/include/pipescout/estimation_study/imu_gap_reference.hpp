// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/estimation_study/run_score.hpp"
#include "pipescout/estimation_study/vehicle_run.hpp"

/// What bursts without the IMU cost at least: a reference for the error of an estimator.
namespace pipescout::estimation_study {

/// m, root mean square of the position over the times of `lossy.estimates`, of a reference that is
/// told more than any estimator can know. Outside the gaps of the IMU it is as good as the
/// estimator that has all data (`whole`). At the beginning of each gap it is told the true
/// position, velocity and acceleration; within it, the true attitude for each fix of an antenna,
/// the true place of the rack, the true speed of a robot with wheels; at its end, the truth. All
/// that it has to find out is where the robot steers in the gap, from the same fixes and visual
/// poses as they arrive: a Kalman filter with an acceleration that is a first-order Gauss-Markov
/// process (Singer, 1970, "Estimating optimal tracking filter performance for manned maneuvering
/// targets"), whose size, correlation time and vertical part are those of a grid that fit this run
/// best in hindsight.
///
/// `run`: with its losses; `lossy` and `whole`: the scores with and without them. Infinite without
/// estimates.
[[nodiscard]] double imu_gap_reference(const VehicleRun& run, const RunScore& lossy,
                                       const RunScore& whole);

}  // namespace pipescout::estimation_study
