// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "first_pose_pencil.hpp"
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

/// A segment that lies on an edge of the model.
struct EdgeMatch {
  EdgeId id;
  bool along_flow = true;      ///< whether the edge is one of a pipe along y
  Eigen::Vector2d start, end;  ///< the part of the segment that lies on it, ideal pixels
};

/// How well a pose explains the segments, in pixels of edge length.
struct Evidence {
  double predicted = 0;             ///< of the visible contours of pipes along y
  double covered = 0;               ///< of these, with segments on them; near ones count more
  double transverse_predicted = 0;  ///< the same of all other edges
  double transverse_covered = 0;
  std::size_t visible_contours = 0;  ///< of pipes along y, 40 pixels of each at least
  std::size_t contours = 0;          ///< of pipes along y, that have a segment
  std::size_t pipes = 0;             ///< along y, that have one
  /// Segments along the flow within the outline of a pipe that lie on no edge: what is on the
  /// ground is not seen through pipes.
  double on_pipes = 0;
  std::vector<EdgeMatch> matches;

  /// What is found, less half of what is missing or should not be there.
  [[nodiscard]] double value() const {
    return covered - 0.5 * (predicted - covered) - 0.5 * on_pipes;
  }
  /// The same with the other edges, of which many are too weak to be found.
  [[nodiscard]] double total_value() const {
    return value() + transverse_covered - 0.2 * (transverse_predicted - transverse_covered);
  }
  /// Share of the contours, and of the lines on pipes, that is explained.
  [[nodiscard]] double share() const {
    return predicted > 0 ? covered / (predicted + on_pipes) : 0;
  }
};

class EvidenceFinder {
 public:
  EvidenceFinder(const RackOutline& rack, const geometry::Camera& camera,
                 std::span<const SegmentPlane> planes)
      : rack_(rack), camera_(camera), planes_(planes) {}

  /// A segment lies on an edge when it does so within `tolerance` pixels.
  [[nodiscard]] Evidence find(const geometry::SE3& T_camera_rack, double tolerance);

  /// Least squares over the matches, a few steps: the pose moved, and the information on the
  /// motion [dc; dphi] of contour.hpp. Edges whose image depends on the place along the flow, those
  /// of reducers among them, take part when `place_is_seen`: at a wrong place they would pull the
  /// rest. `along` is what is known of the camera's y beforehand. Nothing when the steps lead away.
  struct Fit {
    geometry::SE3 T_camera_rack;
    geometry::Matrix6d information;
    double rms = 0;        ///< of the distances of segment ends from their edges, pixels
    double inflation = 1;  ///< of the variances: squared residuals against those expected, >= 1
  };
  struct Along {
    double value;
    double standard_deviation;
  };
  [[nodiscard]] std::optional<Fit> fit(const geometry::SE3& T_camera_rack,
                                       std::span<const EdgeMatch> matches, bool place_is_seen,
                                       const Along& along, double sigma) const;

 private:
  /// `matched`: for each segment.
  [[nodiscard]] double length_on_pipes(const geometry::SE3& T_camera_rack,
                                       const std::vector<bool>& matched) const;
  [[nodiscard]] bool tells_place(const EdgeMatch& match) const;
  [[nodiscard]] bool line_of(const EdgeId& id, const CameraView& view, ImageLine& line) const;

  const RackOutline& rack_;
  const geometry::Camera& camera_;
  std::span<const SegmentPlane> planes_;
  EdgeRenderer renderer_;
  std::vector<VisibleEdge> edges_;
};

}  // namespace pipescout::rack_vision::internal
