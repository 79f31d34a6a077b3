// SPDX-License-Identifier: Apache-2.0
#include "first_pose_pencil.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "pipescout/linear_algebra/symmetric_eigen.hpp"

namespace pipescout::rack_vision::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kPairedSegments = 36;     // the longest; each two of them propose a pencil
constexpr double kSmallestSine = 0.015;         // between planes that propose: 10 pixels or so
constexpr double kSameDirectionCosine = 0.966;  // 15 degrees

/// Square of the distance, in pixels, from a segment's end to the line that
/// joins its middle and the vanishing point.
double squared_miss(const SegmentPlane& plane, const Matrix3d& camera_matrix,
                    const Vector3d& direction) {
  const Vector3d vanishing = camera_matrix * direction;
  const Vector2d middle = 0.5 * (plane.segment.start + plane.segment.end);
  const Vector2d towards = vanishing.head<2>() - vanishing.z() * middle;
  const Vector2d half = plane.segment.end - middle;
  const double beside = half.x() * towards.y() - half.y() * towards.x();
  return beside * beside / towards.squaredNorm();
}

/// Total length of the segments that point along `direction`; those that miss
/// it count less.
double support(std::span<const SegmentPlane> planes, const Matrix3d& camera_matrix,
               const Vector3d& direction, double tolerance) {
  double sum = 0;
  for (const SegmentPlane& plane : planes) {
    const double miss = squared_miss(plane, camera_matrix, direction) / (tolerance * tolerance);
    sum += plane.length * std::max(0.0, 1 - miss);
  }
  return sum;
}

/// Least squares over the segments that point along `direction`; a plane's
/// normal is as good as its segment is long, and there are as many pixels that
/// say so.
Vector3d refined(std::span<const SegmentPlane> planes, const Matrix3d& camera_matrix,
                 const Vector3d& direction, double tolerance) {
  Matrix3d moments = Matrix3d::Zero();
  for (const SegmentPlane& plane : planes) {
    if (points_along(plane, camera_matrix, direction, tolerance)) {
      moments += std::pow(plane.length, 3) * plane.normal * plane.normal.transpose();
    }
  }
  const Vector3d axis = linear_algebra::symmetric_eigen(moments).vectors.col(0);
  return axis.dot(direction) < 0 ? Vector3d(-axis) : axis;
}

}  // namespace

std::vector<SegmentPlane> segment_planes(std::span<const ImageSegment> segments,
                                         const geometry::Camera& camera) {
  std::vector<SegmentPlane> planes;
  planes.reserve(segments.size());
  for (const ImageSegment& segment : segments) {
    const Vector2d along = segment.end - segment.start;
    const double length = along.norm();
    if (!std::isfinite(length) || !(length > 0) || !segment.start.allFinite()) {
      continue;
    }
    const Vector3d start = camera.inverse_matrix() * segment.start.homogeneous();
    const Vector3d end = camera.inverse_matrix() * segment.end.homogeneous();
    planes.push_back({segment, start.cross(end).normalized(), along / length, length});
  }
  return planes;
}

bool points_along(const SegmentPlane& plane, const Matrix3d& camera_matrix,
                  const Vector3d& direction, double tolerance) {
  return squared_miss(plane, camera_matrix, direction) <= tolerance * tolerance;
}

std::vector<Vector3d> find_pencils(std::span<const SegmentPlane> planes,
                                   const geometry::Camera& camera, double largest_tilt,
                                   double tolerance, std::size_t most) {
  std::vector<std::size_t> longest(planes.size());
  std::iota(longest.begin(), longest.end(), std::size_t{0});
  std::ranges::stable_sort(longest, std::greater<>{},
                           [&](std::size_t i) { return planes[i].length; });
  longest.resize(std::min(longest.size(), kPairedSegments));
  struct Proposal {
    Vector3d direction;
    double length;
  };
  std::vector<Proposal> proposals;
  for (std::size_t i = 0; i < longest.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Vector3d cross = planes[longest[i]].normal.cross(planes[longest[j]].normal);
      const double sine = cross.norm();
      if (sine < kSmallestSine || std::abs(cross.z()) > sine * std::sin(largest_tilt)) {
        continue;
      }
      const Vector3d direction = cross / sine;
      proposals.push_back({direction, support(planes, camera.matrix(), direction, tolerance)});
    }
  }
  std::ranges::stable_sort(proposals, std::greater<>{}, &Proposal::length);
  std::vector<Vector3d> pencils;
  for (const Proposal& proposal : proposals) {
    if (pencils.size() == most) {
      break;
    }
    const bool known = std::ranges::any_of(pencils, [&](const Vector3d& other) {
      return std::abs(other.dot(proposal.direction)) > kSameDirectionCosine;
    });
    if (known) {
      continue;
    }
    Vector3d direction = proposal.direction;
    for (const double narrowing : {1.0, 0.7, 0.5}) {
      direction = refined(planes, camera.matrix(), direction, narrowing * tolerance);
    }
    pencils.push_back(direction);
  }
  return pencils;
}

}  // namespace pipescout::rack_vision::internal
