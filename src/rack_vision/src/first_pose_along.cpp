// SPDX-License-Identifier: Apache-2.0
#include "first_pose_along.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pipescout::rack_vision::internal {
namespace {

using Eigen::Vector3d;

constexpr double kBin = 0.02;           // m
constexpr double kLongestRange = 2000;  // m: memory stays bounded

/// A straight line along rack x, or a pipe along it (radius > 0).
struct CrossingLine {
  double y, z, radius;
};

std::vector<CrossingLine> crossing_lines(const RackOutline& rack) {
  std::vector<CrossingLine> lines;
  for (const Support& support : rack.model.supports) {
    for (const double y : {support.lowest_corner.y(), support.highest_corner.y()}) {
      for (const double z : {support.lowest_corner.z(), support.highest_corner.z()}) {
        lines.push_back({y, z, 0});
      }
    }
  }
  for (std::size_t i = 0; i < rack.sections.size(); ++i) {
    for (const PipeSection& section : rack.sections[i]) {
      if (std::abs(section.direction.x()) > 0.9998) {
        const double radius = 0.5 * (section.radius_start + section.radius_end);
        lines.push_back({section.start.y(), section.start.z(), radius});
        lines.push_back({section.start.y(), section.start.z(), -radius});
      }
    }
  }
  return lines;
}

}  // namespace

std::vector<double> places_along(const geometry::SE3& T_camera_rack,
                                 std::span<const SegmentPlane> planes, const RackOutline& rack,
                                 const geometry::Camera& camera, double tolerance, double low,
                                 double high, std::size_t most) {
  const std::vector<CrossingLine> lines = crossing_lines(rack);
  if (lines.empty() || !(high >= low) || high - low > kLongestRange) {
    return {};
  }
  const Eigen::Matrix3d R_rack_camera = T_camera_rack.rotation().matrix().transpose();
  const Vector3d centre = -(R_rack_camera * T_camera_rack.translation());
  std::vector<double> votes(static_cast<std::size_t>((high - low) / kBin) + 3, 0.0);
  std::vector<std::size_t> bins;  // of one segment
  for (const SegmentPlane& plane : planes) {
    if (!points_along(plane, camera.matrix(), R_rack_camera.transpose() * Vector3d::UnitX(),
                      tolerance)) {
      continue;
    }
    const Vector3d n = R_rack_camera * plane.normal;
    if (std::abs(n.y()) < 0.2) {
      continue;
    }
    bins.clear();
    for (const CrossingLine& line : lines) {
      // n . (point - centre) = -+radius, with n_x = 0.
      const double y = line.y + (n.z() * (line.z - centre.z()) + line.radius) / n.y();
      if (y >= low && y <= high) {
        bins.push_back(static_cast<std::size_t>((y - low) / kBin) + 1);
      }
    }
    // The upper and the lower edge of a beam are not two reasons to be at one
    // place.
    std::ranges::sort(bins);
    std::size_t last = 0;
    for (const std::size_t bin : bins) {
      if (last == 0 || bin > last + 1) {
        votes[bin] += plane.length;
        votes[bin - 1] += 0.5 * plane.length;
        votes[bin + 1] += 0.5 * plane.length;
        last = bin;
      }
    }
  }
  std::vector<std::size_t> peaks;
  for (std::size_t i = 1; i + 1 < votes.size(); ++i) {
    if (votes[i] > 0 && votes[i] >= votes[i - 1] && votes[i] > votes[i + 1]) {
      peaks.push_back(i);
    }
  }
  std::ranges::stable_sort(peaks, std::greater<>{}, [&](std::size_t i) { return votes[i]; });
  peaks.resize(std::min(peaks.size(), most));
  std::vector<double> places;
  for (const std::size_t i : peaks) {
    places.push_back(low + (static_cast<double>(i) - 0.5) * kBin);
  }
  return places;
}

geometry::SE3 at_place(const geometry::SE3& T_camera_rack, double y) {
  Vector3d centre = T_camera_rack.inverse().translation();
  centre.y() = y;
  return {T_camera_rack.rotation(), -(T_camera_rack.rotation() * centre)};
}

}  // namespace pipescout::rack_vision::internal
