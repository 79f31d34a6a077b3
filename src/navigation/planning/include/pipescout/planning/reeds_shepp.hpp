// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "pipescout/navigation_maps/path.hpp"

/// Shortest paths of a car that drives forwards and in reverse, without obstacles (Reeds and Shepp,
/// "Optimal paths for a car that goes both forwards and backwards", 1990, section 8).
namespace pipescout::navigation {

/// A piece of constant steering.
struct SteeringPiece {
  int turn = 0;       ///< +1 left, 0 straight, -1 right, as far as the steering goes
  double length = 0;  ///< m, negative in reverse
};

/// Up to five pieces that lead from one pose to another.
struct SteeringWord {
  std::array<SteeringPiece, 5> pieces;
  int count = 0;

  [[nodiscard]] double length() const;
};

/// All words of the paper that join the poses with a turning radius in m (above 0), shortest first.
/// Empty for poses that are not finite.
[[nodiscard]] std::vector<SteeringWord> reeds_shepp_words(const Pose2d& from, const Pose2d& to,
                                                          double radius);

/// m, of the shortest word. Allocates nothing. Infinity for poses that are not finite.
[[nodiscard]] double reeds_shepp_length(const Pose2d& from, const Pose2d& to, double radius);

/// The word as a path with a pose at least every `step` m; cusps have two poses.
[[nodiscard]] Path drive_word(const Pose2d& from, const SteeringWord& word, double radius,
                              double step);

}  // namespace pipescout::navigation
