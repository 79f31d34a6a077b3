// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

#include "pipescout/tracking/shape_tracker.hpp"

namespace pipescout::tracking::test {

inline constexpr ImageSize kImage{.width = 320, .height = 240};
inline constexpr double kFrame = 0.04;  // s

inline double wrapped(double angle) {
  return std::remainder(angle, std::numbers::pi);
}

inline PipeRegion region_of(const PipeShape::State& state) {
  const Eigen::Vector2d half =
      state[2] / 2 * Eigen::Vector2d(std::cos(state[3]), std::sin(state[3]));
  return {.start = state.head<2>() - half, .end = state.head<2>() + half, .half_width = 6};
}

/// What comes with a picture.
struct Beside {
  std::optional<ImageMotion> motion{};
  std::optional<TrackHint<PipeShape>> hint{};
};

/// A tracker of pipes, and the pictures that it is shown one after the other.
struct Pictures {
  explicit Pictures(std::uint64_t seed = 1) : tracker(PipeShape{}, {}, seed) {}

  const PipeTrack& show(const std::vector<PipeRegion>& regions, const Beside& beside = {}) {
    time += period;
    return tracker.update({.time = time,
                           .image = image,
                           .regions = regions,
                           .motion = beside.motion,
                           .hint = beside.hint});
  }
  void show_often(const std::vector<PipeRegion>& regions, int times) {
    for (int i = 0; i < times; ++i) {
      show(regions);
    }
  }
  /// A pipe, cut at the border.
  const PipeTrack& show_in_view(const PipeShape::State& pipe) {
    return show({region_of(PipeShape::in_view(pipe, image).shape)});
  }
  [[nodiscard]] const PipeTrack& track() const { return tracker.track(); }
  [[nodiscard]] std::size_t faults(TrackFault fault) const {
    return tracker.faults()[static_cast<std::size_t>(fault)];
  }

  PipeTracker tracker;
  ImageSize image = kImage;
  double period = kFrame;
  double time = 0;
};

}  // namespace pipescout::tracking::test
