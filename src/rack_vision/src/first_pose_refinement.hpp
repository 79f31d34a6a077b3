// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "first_pose_evidence.hpp"
#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/edge_search.hpp"
#include "pipescout/rack_vision/image_view.hpp"
#include "pipescout/rack_vision/pose_solver.hpp"

namespace pipescout::rack_vision::internal {

/// A pose that all visible edges agree on.
struct RefinedPose {
  geometry::SE3 T_camera_rack;
  /// Of mu = [translation; rotation], T' = T exp(mu) (equation 5).
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
};

/// Refines a pose that is a few pixels off: edge search and pose solver in
/// turn, as the tracker does, without any memory.
class PoseRefinement {
 public:
  PoseRefinement(const RackOutline& rack, const geometry::Camera& camera, double edge_bias);

  /// Which edges take part.
  enum class Edges : std::uint8_t {
    kAll,
    kAlongFlow,  ///< contours of pipes along y: the camera's y stays as it is
  };

  /// One round for each of the `ranges`, pixels. `along_deviation`: of the
  /// camera's y, which is that of `T_camera_rack` before the image says
  /// anything, m. Nothing when the solver does not agree or leads far away.
  [[nodiscard]] std::optional<RefinedPose> refine(const ImageView& image,
                                                  const geometry::SE3& T_camera_rack,
                                                  double along_deviation, Edges edges,
                                                  std::span<const double> ranges);

 private:
  void search(const ImageView& image, const geometry::SE3& T_camera_rack, double range,
              Edges which);

  const RackOutline& rack_;
  const geometry::Camera& camera_;
  EdgeRenderer renderer_;
  EdgeSearch edge_search_;
  PoseSolver solver_;
  PoseProblem problem_;
  PoseSolution solution_;
  std::vector<VisibleEdge> edges_;
  std::vector<SearchedSample> searched_;
  std::vector<EdgeSample> samples_;
};

}  // namespace pipescout::rack_vision::internal
