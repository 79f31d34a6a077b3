// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "pipescout/estimation_study/run_score.hpp"

/// The state estimator in worlds that it was not told about, next to one that was.
namespace pipescout::estimation_study {

/// Of one world; both estimators get the same data.
struct WorldScore {
  RunScore nominal{};  ///< told the nominal values: the preset and the data sheets
  RunScore told{};     ///< told noise, correlation of GPS, wheel scale, side slip and stamps as
                       ///< they are
};

/// A run of `duration` s in the world of this seed, drawn from `ranges`. GPS is single-point for
/// the ground robot, RTK for the UAV. Throws as RunOptions::validate and WorldRanges::validate.
[[nodiscard]] WorldScore score_world(Vehicle vehicle, double duration,
                                     const simulation::WorldRanges& ranges, std::uint64_t seed);

}  // namespace pipescout::estimation_study
