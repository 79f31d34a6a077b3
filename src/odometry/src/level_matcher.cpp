// SPDX-License-Identifier: Apache-2.0
#include "level_matcher.hpp"

#include <algorithm>

namespace pipescout::odometry {
void LevelMatcher::correct(WeldCell& cell) const noexcept {
  for (std::size_t c = 0; c < channels_; ++c) {
    cell.means[c].x -= level_[c].x;
    cell.means[c].y -= level_[c].y;
  }
}

void LevelMatcher::compare(std::size_t channel, const Impedance& now,
                           const Impedance& before) noexcept {
  differences_[channel][compared_ % kCells] = {now.x - before.x, now.y - before.y};
}

void LevelMatcher::settle(WeldCell& cell) noexcept {
  if (compared_ >= kCells) {  // a shorter turn takes no time
    for (std::size_t c = 0; c < channels_; ++c) {
      // Medians: pulses that a slipping odometer has displaced do not count.
      const auto median = [&](double Impedance::*part) {
        std::array<double, kCells> values{};
        for (std::size_t i = 0; i < kCells; ++i) {
          values[i] = differences_[c][i].*part;
        }
        std::nth_element(values.begin(), values.begin() + kCells / 2, values.end());
        return values[kCells / 2];
      };
      const Impedance drift{median(&Impedance::x), median(&Impedance::y)};
      level_[c].x += drift.x;
      level_[c].y += drift.y;
      cell.means[c].x -= drift.x;
      cell.means[c].y -= drift.y;
    }
  }
  compared_ = 0;
}

}  // namespace pipescout::odometry
