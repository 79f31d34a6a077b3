// SPDX-License-Identifier: Apache-2.0
#include "pipe_plane.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace pipescout::manipulation::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kLeastAngle = 1e-3;  // rad, between the ends of a section that has a direction
constexpr double kBorder = 3;  // pixels: an end nearer to the border may be that of the image

}  // namespace

std::optional<SectionView> view_of(const PipeSection& section,
                                   const geometry::Camera& camera) noexcept {
  const Vector2d middle(section.u, section.v);
  const Vector2d half =
      section.length / 2 * Vector2d(std::cos(section.angle), std::sin(section.angle));
  // Ends may lie beyond the border, where the intrinsics need not hold. The line goes on.
  const double shortened = std::min(1.0, camera.parameters().width / 4.0 / half.norm());
  const auto one = camera.ray(middle - shortened * half);
  const auto other = camera.ray(middle + shortened * half);
  const auto centre = camera.ray(middle);
  if (!one || !other || !centre) {
    return std::nullopt;
  }
  const Vector3d across = other->cross(*one);
  if (across.norm() < kLeastAngle * one->norm() * other->norm()) {
    return std::nullopt;
  }
  SectionView view{.normal = across.normalized()};
  if (view.normal.y() < 0) {
    view.normal = -view.normal;
  }
  if (camera.contains(middle - half, kBorder) || camera.contains(middle + half, kBorder)) {
    view.turn = std::atan2(centre->x(), centre->z());
  }
  const double row = camera.parameters().centre_v;
  view.offset =
      std::max(std::abs(middle.y() - half.y() - row), std::abs(middle.y() + half.y() - row)) /
      camera.parameters().height;
  return view;
}

void PipePlane::observe(const Vector3d& normal, double range, double share) {
  if (!known_) {
    normal_ = normal;
    range_ = range;
    known_ = true;
    return;
  }
  // A plane has no side: that of an upright pipe may come either way round.
  const double side = normal.dot(normal_) < 0 ? -1 : 1;
  const Vector3d mean = normal_ + share * (side * normal - normal_);
  normal_ = mean.normalized();  // at most a right angle between both: never 0
  range_ += share * (range - range_);
}

void PipePlane::move(const Vector3d& moved, const Vector3d& forward) {
  // The camera leaves the plane by moved . normal, and the plane turns about the pipe after it.
  normal_ = (normal_ + moved.dot(normal_) / range_ * forward).normalized();
}

geometry::SO3 looking_along(const Vector3d& normal, const Vector3d& forward) {
  Eigen::Matrix3d R;
  R.col(1) = normal;
  R.col(2) = (forward - forward.dot(normal) * normal).normalized();
  R.col(0) = R.col(1).cross(R.col(2));
  return geometry::SO3::from_matrix(R);
}

}  // namespace pipescout::manipulation::internal
