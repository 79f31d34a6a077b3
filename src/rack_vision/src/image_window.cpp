// SPDX-License-Identifier: Apache-2.0
#include "image_window.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace pipescout::rack_vision {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// m; the nearest that is shown. Nearer to the eye pixels mean nothing.
constexpr double kNearest = 1e-3;

/// Share of the image that the bounds of a distorted one are wider, or narrower, than the points
/// tried on its border. The border itself is found point by point.
constexpr double kMargin = 0.03;

struct Rectangle {
  Vector2d low, high;
};

/// Rectangles in ideal pixels: all that the image shows is in the first, all of the second is
/// shown.
struct Bounds {
  Rectangle outer, inner;
};

/// The border of a distorted image reaches farthest, and least far, in its corners and where it is
/// nearest to the centre.
Bounds ideal_bounds(const geometry::Camera& camera) {
  const geometry::CameraParameters& c = camera.parameters();
  const Vector2d last(c.width - 1, c.height - 1);
  const Rectangle image{Vector2d::Zero(), last};
  if (!camera.has_distortion()) {
    return {image, image};
  }
  const Vector2d centre(std::clamp(c.centre_u, 0.0, last.x()),
                        std::clamp(c.centre_v, 0.0, last.y()));
  // Where the image shows more than the lens model covers, its border is a circle around the axis;
  // `inner` is then the square in it.
  const double radius = camera.largest_radius();
  const Vector2d reach(radius * (c.focal_length + std::abs(c.skew)),
                       radius * c.aspect_ratio * c.focal_length);
  const Vector2d axis_pixel(c.centre_u, c.centre_v);
  Bounds bounds{{centre, centre}, {Vector2d::Constant(-1e9), Vector2d::Constant(1e9)}};
  const auto reaches_circle = [&](int axis, double sign) {
    const double outer = axis_pixel[axis] + sign * reach[axis];
    const double inner = axis_pixel[axis] + sign * reach[axis] / std::numbers::sqrt2;
    auto& wide = sign < 0 ? bounds.outer.low[axis] : bounds.outer.high[axis];
    auto& narrow = sign < 0 ? bounds.inner.low[axis] : bounds.inner.high[axis];
    wide = sign < 0 ? std::min(wide, outer) : std::max(wide, outer);
    narrow = sign < 0 ? std::max(narrow, inner) : std::min(narrow, inner);
  };
  for (const int axis : {0, 1}) {
    const int other = 1 - axis;
    for (const double along : {0.0, centre[other], last[other]}) {
      Vector2d at;
      at[other] = along;
      at[axis] = 0;
      if (const std::optional<Vector2d> ideal = camera.undistort(at)) {
        bounds.outer.low[axis] = std::min(bounds.outer.low[axis], (*ideal)[axis]);
        bounds.inner.low[axis] = std::max(bounds.inner.low[axis], (*ideal)[axis]);
      } else {
        reaches_circle(axis, -1);
      }
      at[axis] = last[axis];
      if (const std::optional<Vector2d> ideal = camera.undistort(at)) {
        bounds.outer.high[axis] = std::max(bounds.outer.high[axis], (*ideal)[axis]);
        bounds.inner.high[axis] = std::min(bounds.inner.high[axis], (*ideal)[axis]);
      } else {
        reaches_circle(axis, 1);
      }
    }
  }
  const Vector2d margin = kMargin * (bounds.outer.high - bounds.outer.low);
  bounds.outer = {bounds.outer.low - margin, bounds.outer.high + margin};
  bounds.inner = {bounds.inner.low + margin, bounds.inner.high - margin};
  return bounds;
}

/// Planes through the eye and the sides of a rectangle; `projection` is K R_camera_rack.
ViewPlanes planes_through(const Rectangle& rectangle, const Eigen::Matrix3d& projection) {
  const Vector3d u = projection.row(0);
  const Vector3d v = projection.row(1);
  const Vector3d w = projection.row(2);
  return {u - rectangle.low.x() * w, rectangle.high.x() * w - u, v - rectangle.low.y() * w,
          rectangle.high.y() * w - v};
}

/// Takes what is not inside a plane, given where start and end of the segment are, from `inside`;
/// false: nothing is left.
bool keep(double at_start, double at_end, Interval& inside) {
  if (at_start < 0 && at_end < 0) {
    return false;
  }
  if (at_start < 0) {
    inside.from = std::max(inside.from, at_start / (at_start - at_end));
  } else if (at_end < 0) {
    inside.to = std::min(inside.to, at_start / (at_start - at_end));
  }
  return inside.from < inside.to;
}

bool keep(const ViewPlanes& planes, const Vector3d& start, const Vector3d& end, Interval& inside) {
  return std::ranges::all_of(planes, [&](const Vector3d& plane) {
    return keep(plane.dot(start), plane.dot(end), inside);
  });
}

}  // namespace

ImageWindow::ImageWindow(const geometry::Camera& camera, const geometry::SE3& T_camera_rack)
    : camera_(camera),
      rotation_(T_camera_rack.rotation().matrix()),
      projection_(camera.matrix() * rotation_),
      eye_(rotation_.transpose() * Vector3d(-T_camera_rack.translation())) {
  const Bounds bounds = ideal_bounds(camera);
  planes_ = planes_through(bounds.outer, projection_);
  shown_planes_ = planes_through(bounds.inner, projection_);
}

Vector2d ImageWindow::pixel(const Vector3d& point) const noexcept {
  return (projection_ * point).hnormalized();
}

bool ImageWindow::clip(Vector3d& start, Vector3d& end) const noexcept {
  Interval inside;
  const auto depth = projection_.row(2);
  if (!keep(depth.dot(start) - kNearest, depth.dot(end) - kNearest, inside) ||
      !keep(planes_, start, end, inside)) {
    return false;
  }
  const Vector3d along = end - start;
  end = start + inside.to * along;
  start += inside.from * along;
  return true;
}

double ImageWindow::inside_border(const Vector3d& point) const noexcept {
  const std::optional<Vector2d> seen = camera_.project(rotation_ * point);
  if (!seen) {
    return kFarOutside;
  }
  const geometry::CameraParameters& c = camera_.parameters();
  return std::min({seen->x(), c.width - 1 - seen->x(), seen->y(), c.height - 1 - seen->y()});
}

/// The regula falsi in its Illinois form; with bisection where there is no value to go by.
double ImageWindow::border_between(const Vector3d& start, const Vector3d& along, Place shown,
                                   Place not_shown) const noexcept {
  constexpr double kAim = 1e-3;  // pixels inside the border, so that what is returned is shown
  constexpr int kMostSteps = 60;
  double high = shown.inside - kAim;
  double low = not_shown.inside - kAim;
  if (high <= kAim) {
    return shown.at;
  }
  int side = 0;
  for (int i = 0; i < kMostSteps; ++i) {
    const double at = not_shown.inside <= kFarOutside
                          ? (shown.at + not_shown.at) / 2
                          : (shown.at * low - not_shown.at * high) / (low - high);
    const double inside = inside_border(start + at * along);
    if (std::abs(inside - kAim) <= kAim) {
      return at;
    }
    if (inside > kAim) {
      shown = {at, inside};
      high = inside - kAim;
      low = side > 0 ? low / 2 : low;
      side = 1;
    } else {
      not_shown = {at, inside};
      low = inside - kAim;
      high = side < 0 ? high / 2 : high;
      side = -1;
    }
  }
  return shown.at;
}

void ImageWindow::append_outside(const Vector3d& start, const Vector3d& end,
                                 std::vector<Interval>& outside) const {
  if (!camera_.has_distortion()) {
    return;
  }
  const Vector3d along = end - start;
  // In the image a straight line is bent: it may cross a border twice. But not within one of these
  // pieces, of equal length in the image; in the middle of the image there is no border.
  constexpr int kPieces = 12;
  const double depth_start = projection_.row(2).dot(start);
  const double depth_end = projection_.row(2).dot(end);
  Interval middle;
  if (!keep(shown_planes_, start, end, middle)) {
    middle = {2, 2};
  }
  Place last{0, inside_border(start)};
  double begin = 0;  // of the outside part that is open
  for (int i = 1; i <= kPieces; ++i) {
    const double in_image = static_cast<double>(i) / kPieces;
    double at = in_image * depth_start / (depth_end + in_image * (depth_start - depth_end));
    if (at > middle.from && at < middle.to) {
      if (last.at >= middle.from) {
        continue;  // it stays inside
      }
      at = middle.from;
    } else if (at >= middle.to && last.at < middle.to && last.at >= middle.from) {
      last = {middle.to, 1};  // what was passed over ended here
    }
    const Place place{at, inside_border(start + at * along)};
    if (place.is_shown() && !last.is_shown()) {
      outside.push_back({begin, border_between(start, along, place, last)});
    } else if (!place.is_shown() && last.is_shown()) {
      begin = border_between(start, along, last, place);
    }
    last = place;
  }
  if (!last.is_shown()) {
    outside.push_back({begin, 1});
  }
}

}  // namespace pipescout::rack_vision
