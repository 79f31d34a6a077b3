// SPDX-License-Identifier: Apache-2.0
#include "image_window.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace pipescout::rack_vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// m; the nearest that is shown. Nearer to the eye pixels mean nothing.
constexpr double kNearest = 1e-3;

/// Share of the image that the bounds of a distorted one are wider than the points tried on its
/// border. What they let through too much is taken away point by point.
constexpr double kMargin = 0.05;

struct Rectangle {
  Vector2d low, high;
};

/// Bounds, in ideal pixels, of what the image shows. The border of a distorted one reaches farthest
/// in its corners, or where it is nearest to the centre.
Rectangle ideal_bounds(const geometry::Camera& camera) {
  const geometry::CameraParameters& c = camera.parameters();
  const Vector2d high(c.width - 1, c.height - 1);
  Rectangle bounds{Vector2d::Zero(), high};
  if (!camera.has_distortion()) {
    return bounds;
  }
  const double u = std::clamp(c.centre_u, 0.0, high.x());
  const double v = std::clamp(c.centre_v, 0.0, high.y());
  for (const Vector2d& at :
       {Vector2d(0, 0), Vector2d(u, 0), Vector2d(high.x(), 0), Vector2d(0, v),
        Vector2d(high.x(), v), Vector2d(0, high.y()), Vector2d(u, high.y()), high}) {
    if (const std::optional<Vector2d> ideal = camera.undistort(at)) {
      bounds.low = bounds.low.cwiseMin(*ideal);
      bounds.high = bounds.high.cwiseMax(*ideal);
    }
  }
  const Vector2d margin = kMargin * (bounds.high - bounds.low);
  return {bounds.low - margin, bounds.high + margin};
}

}  // namespace

ImageWindow::ImageWindow(const geometry::Camera& camera, const geometry::SE3& T_camera_rack)
    : camera_(camera), projection_(camera.matrix() * T_camera_rack.rotation().matrix()) {
  eye_ = T_camera_rack.rotation().inverse() * Vector3d(-T_camera_rack.translation());
  const Rectangle bounds = ideal_bounds(camera);
  const Vector3d u = projection_.row(0);
  const Vector3d v = projection_.row(1);
  const Vector3d w = projection_.row(2);
  planes_ = {u - bounds.low.x() * w, bounds.high.x() * w - u, v - bounds.low.y() * w,
             bounds.high.y() * w - v};
}

Vector2d ImageWindow::pixel(const Vector3d& point) const noexcept {
  return (projection_ * point).hnormalized();
}

bool ImageWindow::clip(Vector3d& start, Vector3d& end) const noexcept {
  Interval inside;
  const auto keep = [&](double at_start, double at_end) {
    if (at_start < 0 && at_end < 0) {
      return false;
    }
    if (at_start < 0) {
      inside.from = std::max(inside.from, at_start / (at_start - at_end));
    } else if (at_end < 0) {
      inside.to = std::min(inside.to, at_start / (at_start - at_end));
    }
    return inside.from < inside.to;
  };
  const auto depth = projection_.row(2);
  if (!keep(depth.dot(start) - kNearest, depth.dot(end) - kNearest)) {
    return false;
  }
  for (const Vector3d& plane : planes_) {
    if (!keep(plane.dot(start), plane.dot(end))) {
      return false;
    }
  }
  const Vector3d along = end - start;
  end = start + inside.to * along;
  start += inside.from * along;
  return true;
}

bool ImageWindow::shows(const Vector3d& point) const noexcept {
  const std::optional<Vector2d> seen = camera_.distort(pixel(point));
  return seen && camera_.contains(*seen);
}

void ImageWindow::append_outside(const Vector3d& start, const Vector3d& end,
                                 std::vector<Interval>& outside) const {
  if (!camera_.has_distortion()) {
    return;
  }
  // A straight line is bent, but not twice within one of these pieces.
  constexpr int kPieces = 16;
  constexpr double kAccuracy = 1e-3;  // pixels
  const double depth_start = projection_.row(2).dot(start);
  const double depth_end = projection_.row(2).dot(end);
  const Vector3d along = end - start;
  const double length = (pixel(end) - pixel(start)).norm();
  // Part of the segment at a part of its image.
  const auto part = [&](double in_image) {
    return in_image * depth_start / (depth_end + in_image * (depth_start - depth_end));
  };
  const auto shown = [&](double in_image) { return shows(start + part(in_image) * along); };
  const auto border = [&](double from, double to) {
    const bool at_from = shown(from);
    while ((to - from) * length > kAccuracy) {
      const double middle = (from + to) / 2;
      (shown(middle) == at_from ? from : to) = middle;
    }
    return at_from ? from : to;  // the side that is shown
  };
  bool was_shown = shown(0);
  double begin = 0;
  for (int i = 1; i <= kPieces; ++i) {
    const double at = static_cast<double>(i) / kPieces;
    const bool is_shown = shown(at);
    if (is_shown != was_shown) {
      const double change = border(at - 1.0 / kPieces, at);
      if (is_shown) {
        outside.push_back({part(begin), part(change)});
      } else {
        begin = change;
      }
    }
    was_shown = is_shown;
  }
  if (!was_shown) {
    outside.push_back({part(begin), 1});
  }
}

}  // namespace pipescout::rack_vision
