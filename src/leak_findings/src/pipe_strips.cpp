// SPDX-License-Identifier: Apache-2.0
#include "pipe_strips.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace pipescout::leak_findings {
namespace {

using Eigen::Vector3d;

/// m before the camera: nothing is nearer.
constexpr double kNearest = 0.1;
/// m, and one minus a cosine: lines go on at this distance and angle.
constexpr double kJoined = 1e-6;

/// What the camera sees, at depth 1.
struct View {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;
};

/// By the corners of the image and the middles of its sides: one of them is farthest out, whatever
/// the lens does.
View view_of(const geometry::Camera& camera) {
  View view;
  const double right = camera.parameters().width - 1;
  const double bottom = camera.parameters().height - 1;
  for (const double u : {0.0, 0.5 * right, right}) {
    for (const double v : {0.0, 0.5 * bottom, bottom}) {
      if (const auto ray = camera.ray({u, v})) {
        view.low = view.low.cwiseMin(ray->head<2>());
        view.high = view.high.cwiseMax(ray->head<2>());
      }
    }
  }
  return view;
}

/// The part of an axis, camera frame, whose surface may be in view, as shares of its length.
std::optional<std::array<double, 2>> in_view(const Vector3d& from, const Vector3d& to,
                                             double radius, const View& view) {
  std::array<double, 2> part{0, 1};
  // Where `normal` * x + `least` > 0.
  const auto clip = [&](const Vector3d& normal, double least) {
    const double start = normal.dot(from) + least;
    const double end = normal.dot(to) + least;
    if (start < 0 && end < 0) {
      part = {1, 0};
    } else if (start < 0) {
      part[0] = std::max(part[0], start / (start - end));
    } else if (end < 0) {
      part[1] = std::min(part[1], start / (start - end));
    }
  };
  clip(Vector3d::UnitZ(), -kNearest);
  for (int i = 0; i < 2; ++i) {
    Vector3d low = Vector3d::Unit(i) - view.low[i] * Vector3d::UnitZ();
    Vector3d high = view.high[i] * Vector3d::UnitZ() - Vector3d::Unit(i);
    clip(low.normalized(), radius);
    clip(high.normalized(), radius);
  }
  return part[0] < part[1] ? std::optional(part) : std::nullopt;
}

/// The cross-section of a pipe in the image.
struct CrossSection {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  // pixels, between its edges
  double half_width = 0;                             // pixels
  double depth = 0;                                  // m, of the surface
};

/// By the points of the surface, next to a point of the axis, that rays from the camera touch.
std::optional<CrossSection> project(const geometry::Camera& camera, const Vector3d& on_axis,
                                    const Vector3d& direction, double radius) {
  const Vector3d to_camera = -(on_axis - direction * direction.dot(on_axis));
  const double distance = to_camera.norm();
  if (distance <= radius) {
    return std::nullopt;
  }
  const Vector3d towards = to_camera / distance;
  const Vector3d aside = direction.cross(towards);
  const double cosine = radius / distance;
  const Vector3d ahead = radius * cosine * towards;
  const Vector3d beside = radius * std::sqrt(1 - cosine * cosine) * aside;
  const auto one = camera.project(on_axis + ahead + beside);
  const auto other = camera.project(on_axis + ahead - beside);
  const double depth = (on_axis + radius * towards).z();
  if (!one || !other || !(depth > 0)) {
    return std::nullopt;
  }
  return CrossSection{0.5 * (*one + *other), 0.5 * (*one - *other).norm(), depth};
}

bool goes_on(const PipeLine& before, const PipeLine& line) {
  return (line.from - before.to).norm() <= kJoined &&
         (line.to - line.from).normalized().dot((before.to - before.from).normalized()) >=
             1 - kJoined;
}

}  // namespace

std::vector<thermal::PipeStrip> pipe_strips(std::span<const PipeLine> lines,
                                            const geometry::Camera& camera,
                                            const geometry::SE3& T_map_camera) {
  std::vector<thermal::PipeStrip> strips;
  if (!std::ranges::all_of(lines, [](const PipeLine& line) { return line.radius > 0; })) {
    return strips;
  }
  const View view = view_of(camera);
  const geometry::SE3 T_camera_map = T_map_camera.inverse();
  std::size_t pipe = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const PipeLine& line = lines[i];
    pipe += i > 0 && !goes_on(lines[i - 1], line) ? 1U : 0U;
    const Vector3d from = T_camera_map * line.from;
    const Vector3d to = T_camera_map * line.to;
    const auto part = in_view(from, to, line.radius, view);
    if (!part) {
      continue;
    }
    const Vector3d direction = (to - from).normalized();
    const auto start = project(camera, from + part->front() * (to - from), direction, line.radius);
    const auto end = project(camera, from + part->back() * (to - from), direction, line.radius);
    if (!start || !end) {
      continue;
    }
    const double pixels = (end->middle - start->middle).norm();
    if (pixels > 0) {
      strips.push_back(
          {.pipe = pipe,
           .start = start->middle,
           .end = end->middle,
           .half_width = {start->half_width, end->half_width},
           .depth = {start->depth, end->depth},
           .metres_per_pixel = (part->back() - part->front()) * (to - from).norm() / pixels});
    }
  }
  return strips;
}

}  // namespace pipescout::leak_findings
