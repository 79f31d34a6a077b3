// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "pipescout/odometry/weld_detector.hpp"
#include "weld_resampler.hpp"

namespace pipescout::odometry {

/// Joins what is read after a turn to what was read before it. The level drifts in time, so that
/// new cells beside old ones would make a step; the cells that are passed again tell by how much.
class LevelMatcher {
 public:
  explicit LevelMatcher(std::size_t channels) noexcept : channels_(channels) {}

  /// Takes off what is known of the drift.
  void correct(WeldCell& cell) const noexcept;

  /// A channel of a corrected cell, as it is read now and as it was read before.
  void compare(std::size_t channel, const Impedance& now, const Impedance& before) noexcept;
  void next_cell() noexcept { ++compared_; }

  /// Known pipe ends: learns the drift from the last cells that were compared, if they are enough,
  /// and corrects the cell that comes next once more.
  void settle(WeldCell& cell) noexcept;

  void forget() noexcept { compared_ = 0; }

 private:
  static constexpr std::size_t kCells = 15;

  std::size_t channels_;
  std::size_t compared_ = 0;
  std::array<std::array<Impedance, kCells>, kMaxEddyCurrentChannels> differences_{};
  std::array<Impedance, kMaxEddyCurrentChannels> level_{};
};

}  // namespace pipescout::odometry
