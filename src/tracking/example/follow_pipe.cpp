// SPDX-License-Identifier: Apache-2.0
// Follows a pipe that sways in the image and is hidden for half a second, beside another one.
#include <cmath>
#include <iostream>
#include <vector>

#include "pipescout/tracking/shape_tracker.hpp"

using namespace pipescout::tracking;

int main() {
  constexpr double kPeriod = 0.04;  // s
  PipeTracker tracker(PipeShape{}, PipeTrackerParameters{}, 1);
  for (int i = 0; i < 75; ++i) {
    const double y = 120 + 20 * std::sin(2 * kPeriod * i);
    std::vector<PipeRegion> regions;
    if (i < 40 || i >= 52) {
      regions.push_back({.start = {60, y}, .end = {260, y + 10}, .half_width = 6});
    }
    regions.push_back({.start = {60, y + 60}, .end = {260, y + 70}, .half_width = 6});
    const PipeTrack& track = tracker.update(
        {.time = kPeriod * i, .image = {.width = 320, .height = 240}, .regions = regions});
    if (i % 5 == 0) {
      std::cout << kPeriod * i << " s: " << to_string(track.state) << ", [x y l alpha] "
                << track.estimate.transpose() << ", confidence " << track.confidence << '\n';
    }
  }
  return tracker.track().state == TrackState::kLocked ? 0 : 1;
}
