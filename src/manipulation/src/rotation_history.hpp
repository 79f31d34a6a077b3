// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>

#include "pipescout/geometry/so3.hpp"

namespace pipescout::manipulation::internal {

/// A rotation over the last second or so, to ask what it was when an image was taken. Allocates
/// nothing.
class RotationHistory {
 public:
  /// `rate`: rad/s, right; used beyond the last one. `time`, s, after that of the last one, and not
  /// kept when less than `spacing` after the last that was kept, which it replaces then.
  void add(double time, const geometry::SO3& rotation, const Eigen::Vector3d& rate, double spacing);
  /// Between two that are known, or beyond the last one. Nothing before the oldest one.
  [[nodiscard]] std::optional<geometry::SO3> at(double time) const;
  void clear() noexcept { size_ = 0; }

 private:
  struct Sample {
    double time = 0;
    geometry::SO3 rotation{};
    Eigen::Vector3d rate = Eigen::Vector3d::Zero();
  };
  static constexpr std::size_t kMost = 128;

  [[nodiscard]] const Sample& back(std::size_t age) const {
    return samples_[(next_ + kMost - 1 - age) % kMost];
  }

  std::array<Sample, kMost> samples_{};
  std::size_t next_ = 0;
  std::size_t size_ = 0;
};

}  // namespace pipescout::manipulation::internal
