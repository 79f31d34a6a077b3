// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/pose_bound.hpp"

#include <Eigen/Cholesky>
#include <array>
#include <optional>
#include <stdexcept>

namespace pipescout::rack_study {
namespace {

using geometry::SE3;
using geometry::Vector6d;
using rack_vision::EdgeId;

constexpr double kStep = 1e-6;  // m and rad
constexpr std::size_t kPoses = 12;

/// Image line through two points of a contour, normalised: over ideal pixels.
Eigen::Vector3d seen_line(const Eigen::Matrix3d& k, const SE3& T_camera_rack,
                          const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d line = (k * (T_camera_rack * a)).cross(k * (T_camera_rack * b));
  return line / line.head<2>().norm();
}

std::optional<Eigen::Vector3d> seen_line(const rack_vision::RackModel& model,
                                         const Eigen::Matrix3d& k, const SE3& T_camera_rack,
                                         const EdgeId& edge,
                                         std::vector<rack_vision::PipeSection>& sections) {
  if (edge.kind == rack_vision::EdgeKind::kSupport) {
    const auto ends = rack_vision::support_edge(model.supports[edge.body], edge.part);
    return seen_line(k, T_camera_rack, ends.start, ends.end);
  }
  sections.clear();
  rack_vision::append_sections(model.pipes[edge.body], 0, sections);
  rack_vision::ContourLine both[2];
  if (!rack_vision::contour_lines(sections[edge.part], T_camera_rack.inverse().translation(),
                                  both)) {
    return {};
  }
  return seen_line(k, T_camera_rack, both[edge.side].start, both[edge.side].end);
}

}  // namespace

geometry::Matrix6d pose_bound(const rack_vision::RackModel& model, const geometry::Camera& camera,
                              const SE3& T_camera_rack, const simulation::RackFeatures& features,
                              const geometry::Matrix6d& prior) {
  const Eigen::Matrix3d& k = camera.matrix();
  std::array<SE3, kPoses> poses;  // forward and backward in turn
  for (int i = 0; i < static_cast<int>(kPoses); ++i) {
    const Vector6d step = (i % 2 == 0 ? kStep : -kStep) * Vector6d::Unit(i / 2);
    poses[static_cast<std::size_t>(i)] = rack_vision::moved(T_camera_rack, step);
  }
  geometry::Matrix6d information = prior;
  std::vector<rack_vision::PipeSection> sections;
  std::optional<EdgeId> current;
  rack_vision::Matrix36d derivative;
  for (const auto& sample : features.edges) {
    if (!current || !(*current == sample.edge)) {
      current = sample.edge;
      for (int i = 0; i < 6; ++i) {
        const auto forward =
            seen_line(model, k, poses[static_cast<std::size_t>(2 * i)], sample.edge, sections);
        const auto backward =
            seen_line(model, k, poses[static_cast<std::size_t>(2 * i + 1)], sample.edge, sections);
        if (!forward || !backward) {
          throw std::logic_error("pose_bound: an edge was seen that has no contour");
        }
        derivative.col(i) = (*forward - *backward) / (2 * kStep);
      }
    }
    const Vector6d row = derivative.transpose() * sample.candidates[0].homogeneous();
    information += row * row.transpose() / (sample.sigma * sample.sigma);
  }
  for (const auto& point : features.points) {
    Eigen::Matrix<double, 2, 6> rows;
    for (int i = 0; i < 6; ++i) {
      const Eigen::Vector3d forward = k * (poses[static_cast<std::size_t>(2 * i)] * point.place);
      const Eigen::Vector3d backward =
          k * (poses[static_cast<std::size_t>(2 * i + 1)] * point.place);
      rows.col(i) = (forward.hnormalized() - backward.hnormalized()) / (2 * kStep);
    }
    information += rows.transpose() * rows / (point.sigma * point.sigma);
  }
  return information.ldlt().solve(geometry::Matrix6d::Identity());
}

}  // namespace pipescout::rack_study
