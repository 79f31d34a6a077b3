// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "first_pose_slopes.hpp"
#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/contour.hpp"
#include "pipescout/rack_vision/rack_model.hpp"
#include "pipescout/rack_vision/visible_edges.hpp"

namespace pipescout::rack_vision::internal {

/// The rack as the search for a first pose needs it, worked out once.
struct RackOutline {
  RackOutline(const RackModel& rack, PipeOffsets pipe_offsets);

  const RackModel& model;
  PipeOffsets offsets;
  std::vector<std::vector<PipeSection>> sections;  ///< of each pipe
  std::vector<bool> along_flow;                    ///< whether a pipe runs along y
  double start = 0, end = 0;                       ///< of the pipes along y
};

/// How well a pose explains the image.
struct Evidence {
  double along = 0;                  ///< nats, of the visible contours of pipes along y
  double transverse = 0;             ///< nats, of all other edges
  double visible = 0;                ///< pixels of all edges
  double found = 0;                  ///< pixels of these that were found
  std::size_t contours = 0;          ///< of pipes along y, that were found
  std::size_t pipes = 0;             ///< along y, of which one was found
  std::size_t transverse_edges = 0;  ///< others that were found
};

class EvidenceFinder {
 public:
  EvidenceFinder(const RackOutline& rack, const geometry::Camera& camera, const SlopeImage& image)
      : rack_(rack), camera_(camera), image_(image) {}

  /// Looks for each visible edge within `reach` pixels (at most
  /// SlopeImage::kLargestReach). `line_share`: of bearings along the flow that
  /// have a line by chance.
  [[nodiscard]] Evidence find(const geometry::SE3& T_camera_rack, int reach, double line_share);

 private:
  const RackOutline& rack_;
  const geometry::Camera& camera_;
  const SlopeImage& image_;
  EdgeRenderer renderer_;
  std::vector<VisibleEdge> edges_;
};

}  // namespace pipescout::rack_vision::internal
