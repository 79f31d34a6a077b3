// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "pipescout/odometry/weld_detector.hpp"

namespace pipescout::odometry {

/// The mean of the samples over one cell.
struct WeldCell {
  std::int64_t index = 0;
  double samples = 0.0;
  double offset = 0.0;  ///< mean position of the samples from the middle of the cell, cells
  std::array<Impedance, kMaxEddyCurrentChannels> means{};
};

/// Sorts samples into cells, and judges the steps of the distance between them. What the level
/// drifts while the crawler stands would look like a step in distance: it is taken off.
class WeldResampler {
 public:
  enum class Outcome : std::uint8_t {
    kNothing,    ///< the sample went into the open cell, or is an outlier
    kCell,       ///< a cell was closed, the next is open: see `closed`
    kNewOrigin,  ///< the same, and the next cell is a confirmed jump away
  };

  explicit WeldResampler(const WeldDetectorParameters& parameters);

  /// A sample whose distance is within 1e9 cells and whose values are finite.
  Outcome add(double distance, std::span<const Impedance> channels, WeldDetectorCounts& counts);
  /// Closes the open cell, if there is one: see `closed`.
  bool close() noexcept;
  [[nodiscard]] const WeldCell& closed() const noexcept { return closed_; }

 private:
  [[nodiscard]] bool confirmed(std::int64_t cell, WeldDetectorCounts& counts) noexcept;
  void open(std::int64_t cell) noexcept;
  void compensate(double place, std::span<const Impedance> channels) noexcept;
  void accumulate(double place) noexcept;

  using Values = std::array<Impedance, kMaxEddyCurrentChannels>;

  std::size_t channels_;
  double cells_per_metre_;
  std::int64_t largest_step_;  // cells
  std::size_t standing_after_;
  double stand_ = 0.0;  // cells, where the crawler may be standing
  std::size_t stand_samples_ = 0;
  Values first_{};  // means of the first and of the latest samples there
  Values latest_{};
  Values drift_{};       // of the level, over all stands
  Values level_free_{};  // the present sample without it
  bool is_open_ = false;
  WeldCell open_;
  WeldCell closed_;
  std::int64_t suspect_ = 0;  // where the samples have jumped to, so they say
  int witnesses_ = 0;
};

}  // namespace pipescout::odometry
