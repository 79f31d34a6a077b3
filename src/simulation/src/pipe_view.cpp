// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/pipe_view.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace pipescout::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNearest = 1e-3;  // m, before the camera

/// The part of a straight line, shares of it, on the inner side of a plane through the camera.
struct Stretch {
  double begin = 0;
  double end = 1;

  void cut(const Vector3d& inwards, double beyond, const Vector3d& from, const Vector3d& along) {
    const double at_begin = inwards.dot(from) - beyond;
    const double change = inwards.dot(along);
    if (change == 0) {
      end = at_begin >= 0 ? end : begin - 1;
    } else if (change > 0) {
      begin = std::max(begin, -at_begin / change);
    } else {
      end = std::min(end, -at_begin / change);
    }
  }
  [[nodiscard]] bool empty() const { return !(begin < end); }
};

}  // namespace

std::optional<PipeView> view_pipe(const StraightPipe& pipe, const geometry::Camera& camera,
                                  const geometry::SE3& T_map_camera) {
  const geometry::SE3 T_camera_map = T_map_camera.inverse();
  const Vector3d from = T_camera_map * pipe.from;
  const Vector3d along = T_camera_map * pipe.to - from;
  const Vector3d direction = along.normalized();
  const Vector3d nearest = from - from.dot(direction) * direction;
  const double distance = nearest.norm();
  if (!(distance > pipe.radius)) {
    return std::nullopt;
  }
  const double right = camera.parameters().width - 1;
  const double bottom = camera.parameters().height - 1;
  // Rows of K: a point is right of column c where (k0 - c k2) . p > 0.
  const Eigen::Matrix3d& K = camera.matrix();
  const Vector3d u = K.row(0).transpose();
  const Vector3d v = K.row(1).transpose();
  const Vector3d z = Vector3d::UnitZ();
  Stretch between_columns;
  between_columns.cut(z, kNearest, from, along);
  between_columns.cut(u, 0, from, along);
  between_columns.cut(right * z - u, 0, from, along);
  if (between_columns.empty()) {
    return std::nullopt;
  }
  Stretch seen = between_columns;
  seen.cut(v, 0, from, along);
  seen.cut(bottom * z - v, 0, from, along);
  if (seen.empty()) {
    return std::nullopt;
  }
  const auto pixel = [&](double share) -> Vector2d {
    return (K * (from + share * along)).hnormalized();
  };
  PipeView view{.from = pixel(seen.begin), .to = pixel(seen.end)};

  // The middle of the section in the image, and where its ray meets the plane of pipe and camera.
  const Vector3d ray = camera.inverse_matrix() * ((view.from + view.to) / 2).homogeneous();
  const Vector3d towards = nearest / distance;
  view.range = distance * ray.norm() / ray.dot(towards);

  // Edges lie in planes through the camera that touch the pipe: turned about its direction from
  // the plane of the axis by the angle that the radius shows under.
  const double angle = std::asin(pipe.radius / distance);
  const Vector3d normal = direction.cross(towards);
  view.whole_width = true;
  for (const double side : {-angle, angle}) {
    const Vector3d edge = std::cos(side) * normal + std::sin(side) * towards;
    const Vector3d line = camera.inverse_matrix().transpose() * edge;  // of (u, v, 1)
    for (const double share : {between_columns.begin, between_columns.end}) {
      const double row = -(line.x() * pixel(share).x() + line.z()) / line.y();
      view.whole_width = view.whole_width && row >= 0 && row <= bottom;
    }
  }
  return view;
}

}  // namespace pipescout::simulation
