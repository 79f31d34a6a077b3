// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "pipescout/tracking/shape_tracker.hpp"

/// Two tubes that cross in the image, or pass each other in parallel, while one of them is hidden:
/// behind a post, or colder than the background for a while. Regions are simulated, not images.
namespace pipescout::tracking_study {

struct CrossingSettings {
  double frame_rate = 7.5;      ///< Hz
  double hidden = 1.0;          ///< s
  double before = 4.0;          ///< s, of both in view, until they meet
  double after = 4.0;           ///< s
  double parallel_share = 0.5;  ///< of the crossings in which the two are parallel
  double noise = 0.5;           ///< px, standard deviation of an end, across and along
  bool odometry = true;         ///< the motion of the image at the tracked tube is told
};

struct CrossingScore {
  std::size_t crossings = 0;
  std::size_t swaps = 0;           ///< at the end the track is on the other tube
  std::size_t lost = 0;            ///< at the end it is on none of the two, or not locked
  std::size_t tracked_hidden = 0;  ///< it was the tracked tube that was hidden

  CrossingScore& operator+=(const CrossingScore& other);
};

/// One crossing; the same seed gives the same bits. Either tube is hidden, with equal probability.
[[nodiscard]] CrossingScore score_crossing(const tracking::PipeTrackerParameters& tracker,
                                           const CrossingSettings& settings, std::uint64_t seed);

}  // namespace pipescout::tracking_study
