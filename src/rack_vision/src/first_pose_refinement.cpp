// SPDX-License-Identifier: Apache-2.0
#include "first_pose_refinement.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/rack_vision/contour.hpp"

namespace pipescout::rack_vision::internal {
namespace {

using Eigen::Vector3d;

constexpr int kSamplesPerEdge = 8;
constexpr double kShortestEdge = 12;    // pixels
constexpr double kSmallestSigma = 0.3;  // pixels
constexpr double kFarthest = 0.6;       // m across and in height: farther is no refinement
constexpr double kMostTurn = 0.25;      // rad

PoseSolverParameters solver_parameters(double edge_bias) {
  PoseSolverParameters parameters;
  parameters.edge_bias_sigma = edge_bias;
  return parameters;
}

}  // namespace

PoseRefinement::PoseRefinement(const RackOutline& rack, const geometry::Camera& camera,
                               double edge_bias)
    : rack_(rack),
      camera_(camera),
      edge_search_(camera, {.samples_per_edge = kSamplesPerEdge}),
      solver_(rack.model, solver_parameters(edge_bias)) {
  std::ranges::copy(rack.offsets, problem_.offsets.mean.begin());
}

void PoseRefinement::search(const ImageView& image, const geometry::SE3& T_camera_rack,
                            double range, Edges which) {
  renderer_.render(rack_.model, rack_.offsets, camera_, T_camera_rack, edges_);
  searched_.clear();
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const VisibleEdge& edge = edges_[i];
    const bool along_flow = edge.id.kind == EdgeKind::kPipe && rack_.along_flow[edge.id.body];
    if ((edge.image_end - edge.image_start).norm() < kShortestEdge ||
        (which == Edges::kAlongFlow && !along_flow)) {
      continue;
    }
    const Pipe* pipe = edge.id.kind == EdgeKind::kPipe ? &rack_.model.pipes[edge.id.body] : nullptr;
    edge_search_.search(image, edge, static_cast<std::uint32_t>(i),
                        edge_normal(edge, pipe, T_camera_rack, camera_), range, {}, searched_);
  }
  samples_.clear();
  for (const SearchedSample& found : searched_) {
    if (found.count == 0) {
      continue;
    }
    EdgeSample& sample = samples_.emplace_back();
    sample.edge = edges_[found.edge].id;
    sample.candidate_count = static_cast<std::uint8_t>(found.count);
    for (std::size_t k = 0; k < static_cast<std::size_t>(found.count); ++k) {
      sample.candidates[k] = found.candidates[k].pixel;
    }
    sample.sigma = std::max(kSmallestSigma, found.candidates[0].sigma);
  }
}

std::optional<RefinedPose> PoseRefinement::refine(const ImageView& image,
                                                  const geometry::SE3& T_camera_rack,
                                                  double along_deviation, Edges edges,
                                                  std::span<const double> ranges) {
  problem_.T_camera_rack = T_camera_rack;
  PosePrior prior{T_camera_rack, geometry::Matrix6d::Zero()};
  prior.information(1, 1) = 1 / (along_deviation * along_deviation);
  problem_.pose_prior = prior;
  for (const double range : ranges) {
    search(image, problem_.T_camera_rack, range, edges);
    problem_.edges = samples_;
    solver_.solve(camera_, problem_, solution_);
    if (solution_.status != PoseStatus::kOk && solution_.status != PoseStatus::kNotConverged) {
      return std::nullopt;
    }
    problem_.T_camera_rack = solution_.T_camera_rack;
  }
  const Vector3d centre = problem_.T_camera_rack.inverse().translation();
  const Vector3d moved_by = centre - T_camera_rack.inverse().translation();
  const double turn =
      (problem_.T_camera_rack.rotation() * T_camera_rack.rotation().inverse()).log().norm();
  if (!(std::hypot(moved_by.x(), moved_by.z()) < kFarthest) || !(turn < kMostTurn)) {
    return std::nullopt;
  }
  geometry::Matrix6d to_tangent;
  for (Eigen::Index i = 0; i < 6; ++i) {
    to_tangent.col(i) = rack_motion(centre, geometry::Vector6d::Unit(i));
  }
  return RefinedPose{problem_.T_camera_rack,
                     to_tangent * solution_.covariance * to_tangent.transpose()};
}

}  // namespace pipescout::rack_vision::internal
