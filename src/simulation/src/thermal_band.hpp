// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "pipescout/geometry/se3.hpp"

namespace pipescout::simulation::internal {

/// Counts before the sensor, row by row.
struct CountPlane {
  int width = 0;
  int height = 0;
  std::vector<float> values;

  [[nodiscard]] float* row(int y) noexcept {
    return values.data() + static_cast<std::ptrdiff_t>(y) * width;
  }
};

/// A camera at one moment, in the frame of the row.
struct ThermalEye {
  geometry::SE3 T_camera_row;
  geometry::Vector6d velocity;  ///< of the camera, in its frame
  Eigen::Matrix3d K;
  Eigen::Matrix3d K_inverse;
  double exposure = 0;   ///< s
  double lens_blur = 0;  ///< pixels
  int width = 0;
  int height = 0;
};

/// A line of the image: a distance in pixels, with a sign, a u + b v + c of pixel (u, v).
using ImageLine = Eigen::Vector3d;

/// The line in which a plane through the camera, with this normal in its frame, is seen.
[[nodiscard]] ImageLine image_line(const Eigen::Matrix3d& K_inverse, const Eigen::Vector3d& normal);

/// An upright or lying cylinder, as long as it likes, as it is seen. `place` goes along its axis.
struct CylinderView {
  std::array<ImageLine, 2> outlines;  ///< positive inside
  ImageLine axis;
  /// Place = shift + numerator . m / denominator . m of m = (u, v, 1), on the plane through the
  /// axis that faces the camera; its denominator is positive before the camera.
  Eigen::Vector3d numerator;
  Eigen::Vector3d denominator;
  double shift = 0;

  [[nodiscard]] double place_at(const Eigen::Vector2d& pixel) const noexcept;
  /// Pixels between the outlines, across the axis, at a pixel of it.
  [[nodiscard]] double width_at(const Eigen::Vector2d& pixel) const noexcept;
};

/// Of the cylinder about the line through `point` (place 0) along `direction`, unit, both in the
/// row. Nothing when the camera is within it.
[[nodiscard]] std::optional<CylinderView> view_cylinder(const ThermalEye& eye,
                                                        const Eigen::Vector3d& point,
                                                        const Eigen::Vector3d& direction,
                                                        double radius);

/// The part of a line between two places that is in the image, from the lower place to the higher.
struct AxisInImage {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
  bool whole = false;  ///< neither end is cut off
};
[[nodiscard]] std::optional<AxisInImage> axis_in_image(const ThermalEye& eye,
                                                       const Eigen::Vector3d& point,
                                                       const Eigen::Vector3d& direction,
                                                       double from_place, double to_place);

/// How what stands still moves in the image during an exposure.
struct BandBlur {
  double along = 0;   ///< m of places, to either side of the middle together
  double across = 0;  ///< pixels
};
/// Of the axis where it is seen nearest to the pixel.
[[nodiscard]] BandBlur band_blur(const ThermalEye& eye, const CylinderView& view,
                                 const Eigen::Vector3d& point, const Eigen::Vector3d& direction,
                                 double place);

struct BandSample {
  float counts = 0;
  float cover = 0;  ///< [0, 1]
};

/// Paints a cylinder. Holds memory only.
class BandPainter {
 public:
  explicit BandPainter(int height);

  /// Finds what of it is seen. False: nothing.
  bool see(const ThermalEye& eye, const CylinderView& view, double across);
  /// The places that are seen; `samples` are evenly from `least` to `most`.
  [[nodiscard]] double least() const noexcept { return least_; }
  [[nodiscard]] double most() const noexcept { return most_; }
  [[nodiscard]] std::span<BandSample> samples(std::size_t count) noexcept;
  void paint(CountPlane& plane) const noexcept;

 private:
  struct Run {
    int from = 0;
    int to = 0;  // exclusive
  };
  CylinderView view_;
  std::vector<Run> runs_;  // of each row
  std::vector<BandSample> samples_;
  std::size_t count_ = 0;
  double softness_ = 1;  // pixels over which an outline comes
  double least_ = 0;
  double most_ = 0;
};

/// The share of a box of length `width` about `place` that lies between `from` and `to`.
[[nodiscard]] inline double box_share(double place, double width, double from, double to) noexcept {
  const double low = std::max(from, place - width / 2);
  const double high = std::min(to, place + width / 2);
  return high > low ? (high - low) / width : 0;
}

}  // namespace pipescout::simulation::internal
