// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

/// A rack that comes into view late, and whose pose is hardly known before: global states must be
/// linearised where they are found, whatever else has been marginalised before.
namespace pipescout::estimation_study {

struct LateRackSettings {
  double duration = 50;             ///< s, of the flight
  double seen_from = 25;            ///< s
  double position_deviation = 2;    ///< m, per axis, of the rack's pose beforehand
  double rotation_deviation = 0.5;  ///< rad, per axis
};

/// Of the rack's pose at the end. NEES: normalised squared error, expected 6.
struct LateRackScore {
  double online_nees = 0;
  double batch_nees = 0;       ///< of the batch smoother with the same measurements
  double online_position = 0;  ///< m
  double online_rotation = 0;  ///< rad
  double accepted_share = 0;   ///< of the visual poses, on line
};

/// A flight with IMU (industrial grade) at 100 Hz, GPS at 5 Hz and visual poses at 10 Hz, on a
/// course that no model of the estimator knows. The prior is true: the rack's pose is drawn from
/// it.
[[nodiscard]] LateRackScore score_late_rack(const LateRackSettings& settings, std::uint64_t seed);

}  // namespace pipescout::estimation_study
