// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "pipescout/tracking/shapes.hpp"

/// Valves and vessels in a thermal image: connected regions above a threshold, as the observations
/// of Ibarguren and others (2013), section 7.1, of other shapes than pipes (section 8). Pixel (0,
/// 0) is the middle of the upper left one, x to the right, y down.
namespace pipescout::tracking {

struct HotRegionParameters {
  double threshold = 100;          ///< degrees Celsius, finite: the paper's
  std::size_t least_pixels = 30;   ///< [5, 1000000]: smaller regions are ignored
  double least_fill = 0.75;        ///< [0, 1]: pixels over those of the fitted shape
  std::size_t most_regions = 200;  ///< [1, 100000]: the first of the image, row by row

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Pixels that are connected by their edges.
struct HotRegion {
  std::size_t pixels = 0;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  ///< px
  /// px^2, of the pixels' area about the middle
  Eigen::Matrix2d second_moment = Eigen::Matrix2d::Zero();
};

/// Finds the regions that are whole in the image: one at its border is cut, and its moments are
/// those of another shape. Keeps its memory from image to image. Not thread-safe.
class HotRegionFinder {
 public:
  /// Throws as the parameters' `validate`.
  explicit HotRegionFinder(const HotRegionParameters& parameters);

  /// `celsius`: row by row; NaN is not hot. Valid until the next call. Throws std::invalid_argument
  /// when the number of temperatures is not that of the image's pixels.
  const std::vector<HotRegion>& find(std::span<const float> celsius, const ImageSize& image);

  /// The regions that fill a circle of the same area and middle.
  [[nodiscard]] std::vector<ValveShape::Region> valves() const;
  /// The regions that fill a rectangle of the same moments; its length is the longer side.
  [[nodiscard]] std::vector<VesselShape::Region> vessels() const;

 private:
  HotRegionParameters parameters_;
  std::vector<HotRegion> regions_;
  std::vector<unsigned char> open_;  // hot pixels that belong to no region yet
  std::vector<std::size_t> stack_;
};

}  // namespace pipescout::tracking
