// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "pipescout/thermal/leak_detector.hpp"

namespace pipescout::thermal {

/// The pipes of `FrameConditions::strips` in one image: where their axes are, and which of them is
/// in front. Keeps its memory.
class KnownPipes {
 public:
  /// The axis of one pipe within the image.
  struct Axis {
    std::size_t first = 0;  ///< strip
    std::size_t last = 0;   ///< one behind its last strip
    Eigen::Vector2d start = Eigen::Vector2d::Zero();
    Eigen::Vector2d end = Eigen::Vector2d::Zero();
    double half_width = 0;        ///< pixels, mean along the axis
    double metres_per_pixel = 0;  ///< likewise

    [[nodiscard]] double length() const { return (end - start).norm(); }
  };

  /// Strips without length and those that are not finite are left out.
  void set(std::span<const PipeStrip> strips, int width, int height);

  /// Of the pipes whose axis crosses the image, longest first.
  [[nodiscard]] std::span<const Axis> axes() const noexcept { return axes_; }
  /// Pixels, at the point of the axis next to `point`.
  [[nodiscard]] double half_width(const Axis& axis, const Eigen::Vector2d& point) const;
  /// Whether another pipe is in front of this one at `point`, or may be within errors of the pose.
  [[nodiscard]] bool hidden(const Axis& axis, const Eigen::Vector2d& point) const;
  /// Whether `point` is on another pipe, or may be within errors of the pose.
  [[nodiscard]] bool on_another(const Axis& axis, const Eigen::Vector2d& point) const;

 private:
  void add_axis(std::size_t first, std::size_t last, int width, int height);
  [[nodiscard]] std::size_t strip_at(const Axis& axis, const Eigen::Vector2d& point) const;

  std::vector<PipeStrip> strips_;
  std::vector<Axis> axes_;
};

}  // namespace pipescout::thermal
