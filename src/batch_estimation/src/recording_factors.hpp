// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "pipescout/batch_estimation/batch_smoother.hpp"
#include "pipescout/estimation/carried_factor.hpp"
#include "pipescout/estimation/imu_timeline.hpp"

namespace pipescout::estimation {

/// Times that differ by less are one, s; as in FixedLagSmoother.
inline constexpr double kSameTime = 1e-4;

/// Throws std::invalid_argument as BatchSmoother says of recordings.
void require_sound(const Recording& recording);

/// A measurement of a recording as a factor of keyframes, or why it is none.
struct PlacedMeasurement {
  FactorReport report{};  // chi-square and weight are for later
  std::optional<AnyFactor> factor{};
  double from_time = 0;
  double to_time = 0;
  std::size_t from = 0;  // keyframes at or before these
  std::size_t to = 0;
  CarryingMotions motions{};
};

/// Those keyframes: `times` in order, not empty.
[[nodiscard]] PlacedMeasurement placed(const AnyFactor& factor, const std::vector<double>& times);

/// Samples that a timeline can take, in order; what overlaps is cut off.
[[nodiscard]] ImuTimeline timeline_of(const std::vector<ImuSample>& samples, std::size_t& refused);

}  // namespace pipescout::estimation
