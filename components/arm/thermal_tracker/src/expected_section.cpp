// SPDX-License-Identifier: Apache-2.0
#include "expected_section.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout {
namespace {

using tracking::PipeShape;

constexpr double kNearest = 0.2;  // m, before the camera
/// Of the length of the section: how far its middle and its ends may be from where they should be,
/// standard, where posts and what is before the pipe hide parts of it.
constexpr double kAlong = 0.25;

/// The part of a line from `from` to `to`, camera frame, that is before the camera.
bool cut_in_front(Eigen::Vector3d& from, Eigen::Vector3d& to) {
  if (std::max(from.z(), to.z()) <= kNearest) {
    return false;
  }
  for (auto [behind, front] : {std::pair{&from, &to}, std::pair{&to, &from}}) {
    if (behind->z() < kNearest) {
      *behind += (kNearest - behind->z()) / (front->z() - behind->z()) * (*front - *behind);
    }
  }
  return true;
}

double largest_deviation(const Eigen::Matrix3d& covariance) {
  return std::sqrt(std::max(0.0, covariance.diagonal().maxCoeff()));
}

}  // namespace

std::optional<ExpectedSection> expected_section(std::span<const leak_findings::PipeLine> lines,
                                                double line_deviation,
                                                const geometry::Camera& camera,
                                                const leak_findings::FramePose& pose,
                                                const geometry::SE3& T_base_camera) {
  const geometry::SE3 T_camera_map = (pose.T_map_base * T_base_camera).inverse();
  const tracking::ImageSize image{camera.parameters().width, camera.parameters().height};
  std::optional<ExpectedSection> nearest;
  for (const leak_findings::PipeLine& line : lines) {
    Eigen::Vector3d from = T_camera_map * line.from;
    Eigen::Vector3d to = T_camera_map * line.to;
    if (!cut_in_front(from, to)) {
      continue;
    }
    const auto start = camera.project(from);
    const auto end = camera.project(to);
    if (!start || !end) {
      continue;
    }
    const auto seen =
        PipeShape::in_view(PipeShape::state_of({.start = *start, .end = *end}), image);
    if (!seen.in_view) {
      continue;
    }
    // Along the image of a line the inverse of the depth is linear.
    const Eigen::Vector2d middle = seen.shape.head<2>();
    const double share = std::clamp((middle - *start).norm() / (*end - *start).norm(), 0.0, 1.0);
    const double depth = 1 / ((1 - share) / from.z() + share / to.z());
    if (!nearest || depth < nearest->depth) {
      nearest = ExpectedSection{.hint = {.shape = seen.shape}, .depth = depth};
    }
  }
  if (!nearest) {
    return std::nullopt;
  }
  const double focal = camera.parameters().focal_length;
  const double length = nearest->hint.shape[PipeShape::kLength];
  const double angle = nearest->hint.shape[PipeShape::kAngle];
  const double position =
      std::hypot(largest_deviation(pose.covariance.topLeftCorner<3, 3>()), line_deviation);
  const double rotation = largest_deviation(pose.covariance.bottomRightCorner<3, 3>());
  const double pixels = std::hypot(1.0, focal * std::hypot(position / nearest->depth, rotation));
  nearest->hint.deviation[PipeShape::kX] = std::hypot(pixels, kAlong * length * std::cos(angle));
  nearest->hint.deviation[PipeShape::kY] = std::hypot(pixels, kAlong * length * std::sin(angle));
  nearest->hint.deviation[PipeShape::kLength] = std::hypot(2 * pixels, 2 * kAlong * length);
  // A robot that is elsewhere sees the line elsewhere, hardly turned: of a short piece in the
  // corner of the image, too, the angle is known.
  nearest->hint.deviation[PipeShape::kAngle] =
      2 * std::hypot(rotation, position / nearest->depth, 1 / length);
  return nearest;
}

}  // namespace pipescout
