// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <pipescout/geometry/camera.hpp>
#include <pipescout/geometry/se3.hpp>
#include <vector>

#include "pipescout/rack_vision/rack_model.hpp"

/// The visible edges of a rack: the contour lines of its pipes in closed form (Lippiello and
/// Cacace, equations 10 to 14, with the vector missing in equation 10) and the edges of its
/// supports, without occluded parts and parts outside the image.
namespace pipescout::rack_vision {

enum class EdgeKind : std::uint8_t { kPipe, kSupport };

/// Persistent identifier of an edge: the same edge of the same body has the same value in every
/// view.
struct EdgeId {
  EdgeKind kind = EdgeKind::kPipe;
  std::uint16_t body = 0;  ///< index of the pipe or of the support in the model
  /// Section of the pipe, counted from 0 in the order of append_sections; or edge of the support,
  /// 0 to 11, as in support_edge.
  std::uint16_t part = 0;
  /// Pipes: 0 is the line of equation (13), 1 that of equation (14). From above the pipe, looking
  /// along the flow, they are the left and the right one. Supports: 0.
  std::uint8_t side = 0;

  bool operator==(const EdgeId&) const = default;
};

/// A straight section of an edge that is completely visible.
struct VisibleEdge {
  EdgeId id;
  /// Rack frame, m, on the contour line. Pipes: `end` is farther along the flow. Supports: towards
  /// larger coordinates.
  Eigen::Vector3d start, end;
  /// Their ideal pixels: those of a camera with the same K without distortion.
  Eigen::Vector2d image_start, image_end;
};

/// Contour line of one section of a pipe, not clipped.
struct ContourLine {
  Eigen::Vector3d start, end;  ///< on the surface, at the section's start and end
  /// Outward unit vector, constant along the line; perpendicular to all rays to the line.
  Eigen::Vector3d normal;
};

/// Both contour lines of a section, seen from `eye`, a point of the rack frame; index is
/// EdgeId::side. A tangent plane of a cone through the eye touches it where the radial direction e
/// has e . (eye - start) = radius of the (extended) cone at the eye; for a cylinder these are
/// equations (10) to (14). Returns false, and does not change `lines`, when there are none: the eye
/// is within the (extended) cone, or on its axis.
[[nodiscard]] bool contour_lines(const PipeSection& section, const Eigen::Vector3d& eye,
                                 ContourLine (&lines)[2]) noexcept;

/// Ends of one of the 12 edges of a support, start towards smaller coordinates. `part`: it runs
/// along axis a = part / 4 (0 is x); with bit 0 set it is at the highest corner along the axis
/// after a (x follows z), with bit 1 set along the one after that. Throws std::invalid_argument for
/// parts above 11.
struct SupportEdge {
  Eigen::Vector3d start, end;
};
[[nodiscard]] SupportEdge support_edge(const Support& support, std::uint16_t part);

/// Finds the visible edges. Only working memory is kept between calls: the result is a function of
/// the arguments. One thread at a time per object.
class EdgeRenderer {
 public:
  EdgeRenderer();
  ~EdgeRenderer();
  EdgeRenderer(EdgeRenderer&&) noexcept;
  EdgeRenderer& operator=(EdgeRenderer&&) noexcept;

  /// Replaces the content of `edges` by the visible sections, ordered by pipe, section, side and
  /// position along the edge, then by support and part. An edge with an occluded middle gives
  /// several sections. Sections shorter than 0.05 pixels are omitted; occlusions shorter than that
  /// are ignored.
  ///
  /// Contour lines of pipes end with their section: at pipe ends, at steps and where a reducer
  /// begins. Edges of a support are those with at least one face towards the camera. Pipes and
  /// supports are solid: from within one, nothing is visible. The ends of `VisibleEdge` project
  /// into the image of the camera with its distortion.
  ///
  /// `model` must be valid (RackModel::validate is not called); T_camera_rack is H of the paper,
  /// camera frames are optical. Allocates only until the largest number of sections has occurred.
  /// Throws std::invalid_argument when there are offsets, but not one per pipe, when an offset is
  /// not finite, when the pose is not finite, or when the model has more than kMaxSections sections
  /// or kMaxSupports supports.
  void render(const RackModel& model, PipeOffsets offsets, const geometry::Camera& camera,
              const geometry::SE3& T_camera_rack, std::vector<VisibleEdge>& edges);

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace pipescout::rack_vision
