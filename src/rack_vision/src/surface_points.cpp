// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/surface_points.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace pipescout::rack_vision {
namespace {

using Eigen::Vector3d;

/// m; how far in front of a point a body must be to hide it. The point itself lies on a body, and
/// texture points are where an estimate put them.
constexpr double kInFront = 1e-4;

/// Where a ray from the eye (0) enters a body.
struct Entry {
  double distance = 0;
  Vector3d normal = Vector3d::Zero();
  bool on_side = false;
};

/// Part of a ray within two parallel planes at `low` and `high`, both measured along the normal on
/// which the ray moves by `speed`, beginning at `at`. Infinite when it moves along them.
struct Slab {
  double from = -std::numeric_limits<double>::infinity();
  double to = std::numeric_limits<double>::infinity();

  Slab(double low, double high, double at, double speed) {
    if (speed != 0) {
      from = std::min((low - at) / speed, (high - at) / speed);
      to = std::max((low - at) / speed, (high - at) / speed);
    } else if (!(at >= low && at <= high)) {
      to = from;  // never within
    }
  }
};

/// `direction` is a unit vector.
std::optional<Entry> entry(const PipeSection& section, const Vector3d& origin,
                           const Vector3d& direction) {
  const Vector3d& axis = section.direction;
  const Vector3d from_start = origin - section.start;
  const double z = axis.dot(from_start);
  const double speed = axis.dot(direction);
  const Slab ends(0, section.length, z, speed);
  if (!(ends.from <= ends.to) || ends.to < 0) {
    return std::nullopt;
  }
  // Negative within the cone, continued to both sides: c + 2 b s + a s^2.
  const Vector3d radial = from_start - z * axis;
  const Vector3d radial_speed = direction - speed * axis;
  const double slope = (section.radius_end - section.radius_start) / section.length;
  const double radius = section.radius_start + slope * z;
  const double growth = slope * speed;
  const double a = radial_speed.squaredNorm() - growth * growth;
  const double b = radial.dot(radial_speed) - radius * growth;
  const double c = radial.squaredNorm() - radius * radius;
  const double first = std::max(0.0, ends.from);
  const auto within = [&](double s) { return c + s * (2 * b + s * a) < 0; };
  if (within(first)) {
    if (ends.from < 0) {
      return Entry{0, -direction, false};  // it begins within the body
    }
    return Entry{first, speed > 0 ? Vector3d(-axis) : axis, false};
  }
  const double discriminant = b * b - a * c;
  if (!(discriminant > 0)) {
    return std::nullopt;
  }
  // The first of the two crossings behind `first`; only one of them may be on the right half of the
  // double cone, that between the ends.
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  double nearest = std::numeric_limits<double>::infinity();
  for (const double s : {a != 0 ? q / a : nearest, q != 0 ? c / q : nearest}) {
    if (s >= first && s <= ends.to) {
      nearest = std::min(nearest, s);
    }
  }
  if (!std::isfinite(nearest)) {
    return std::nullopt;
  }
  const Vector3d outward = (radial + nearest * radial_speed).normalized();
  return Entry{nearest, (outward - slope * axis) / std::sqrt(1 + slope * slope), true};
}

std::optional<Entry> entry(const Vector3d& lowest_corner, const Vector3d& highest_corner,
                           const Vector3d& origin, const Vector3d& direction) {
  Entry result{-std::numeric_limits<double>::infinity(), -direction, false};
  double to = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const Slab slab(lowest_corner[axis], highest_corner[axis], origin[axis], direction[axis]);
    if (slab.from > result.distance) {
      result.distance = slab.from;
      result.normal = (direction[axis] > 0 ? -1 : 1) * Vector3d::Unit(axis);
    }
    to = std::min(to, slab.to);
  }
  if (!(result.distance < to) || to < 0) {
    return std::nullopt;
  }
  if (result.distance < 0) {
    return Entry{0, -direction, false};
  }
  return result;
}

}  // namespace

void RackSurface::update(const RackModel& model, PipeOffsets offsets) {
  if (!offsets.empty() && offsets.size() != model.pipes.size()) {
    throw std::invalid_argument("there are " + std::to_string(offsets.size()) + " offsets for " +
                                std::to_string(model.pipes.size()) + " pipes");
  }
  if (!std::ranges::all_of(offsets, [](double offset) { return std::isfinite(offset); })) {
    throw std::invalid_argument("an offset of a pipe is not finite");
  }
  sections_.clear();
  for (std::size_t pipe = 0; pipe < model.pipes.size(); ++pipe) {
    of_one_pipe_.clear();
    append_sections(model.pipes[pipe], offsets.empty() ? 0 : offsets[pipe], of_one_pipe_);
    for (std::size_t part = 0; part < of_one_pipe_.size(); ++part) {
      sections_.push_back(
          {of_one_pipe_[part], static_cast<std::uint16_t>(pipe), static_cast<std::uint16_t>(part)});
    }
  }
  boxes_.clear();
  for (const Support& support : model.supports) {
    boxes_.push_back({support.lowest_corner, support.highest_corner});
  }
}

std::optional<SurfaceHit> RackSurface::first_hit(const Vector3d& origin,
                                                 const Vector3d& direction) const noexcept {
  const double norm = direction.norm();
  if (!(norm > 0) || !std::isfinite(norm) || !origin.allFinite()) {
    return std::nullopt;
  }
  const Vector3d unit = direction / norm;
  std::optional<SurfaceHit> hit;
  const auto take = [&](const std::optional<Entry>& found, EdgeKind kind, std::size_t body,
                        std::uint16_t part) {
    if (found && (!hit || found->distance < hit->distance)) {
      hit = SurfaceHit{kind,
                       static_cast<std::uint16_t>(body),
                       part,
                       found->on_side,
                       found->distance,
                       origin + found->distance * unit,
                       found->normal};
    }
  };
  for (const Body& body : sections_) {
    take(entry(body.section, origin, unit), EdgeKind::kPipe, body.pipe, body.part);
  }
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    take(entry(boxes_[i].lowest_corner, boxes_[i].highest_corner, origin, unit), EdgeKind::kSupport,
         i, 0);
  }
  return hit;
}

std::optional<SurfaceHit> RackSurface::seen_at(const geometry::Camera& camera,
                                               const geometry::SE3& T_camera_rack,
                                               const Eigen::Vector2d& pixel) const noexcept {
  const std::optional<Vector3d> ray = camera.ray(pixel);
  if (!ray) {
    return std::nullopt;
  }
  const geometry::SE3 T_rack_camera = T_camera_rack.inverse();
  return first_hit(T_rack_camera.translation(), T_rack_camera.rotation() * *ray);
}

std::optional<Eigen::Vector2d> RackSurface::visible_at(
    const Vector3d& point, const Vector3d& normal, const geometry::Camera& camera,
    const geometry::SE3& T_camera_rack, double margin, double least_cosine) const noexcept {
  const std::optional<Eigen::Vector2d> pixel = camera.project(T_camera_rack * point);
  if (!pixel || !camera.contains(*pixel, margin)) {
    return std::nullopt;
  }
  const Vector3d eye = T_camera_rack.inverse().translation();
  const Vector3d to_eye = eye - point;
  const double distance = to_eye.norm();
  if (!(normal.dot(to_eye) > least_cosine * distance)) {
    return std::nullopt;
  }
  const std::optional<SurfaceHit> hit = first_hit(eye, -to_eye);
  if (hit && hit->distance < distance - kInFront) {
    return std::nullopt;
  }
  return pixel;
}

}  // namespace pipescout::rack_vision
