// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <pipescout/geometry/camera.hpp>
#include <pipescout/geometry/se3.hpp>
#include <vector>

#include "pipescout/rack_vision/rack_model.hpp"
#include "pipescout/rack_vision/visible_edges.hpp"

/// Points on the surface of a rack: intersections with camera rays (positions of the texture points
/// of Lippiello and Cacace) and visibility of known points.
namespace pipescout::rack_vision {

/// Intersection of a ray with the rack.
struct SurfaceHit {
  EdgeKind kind = EdgeKind::kPipe;
  std::uint16_t body = 0;  ///< index of the pipe or of the support
  /// Section of the pipe, counted from 0 in the order of append_sections. Supports: 0.
  std::uint16_t part = 0;
  /// False: the flat end of a pipe, the ring of a step, or a support.
  bool on_side_of_pipe = true;
  double distance = 0;                               ///< m, from the origin of the ray
  Eigen::Vector3d point = Eigen::Vector3d::Zero();   ///< rack frame, m, the pipes' offsets included
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< outward, unit vector
};

/// The solid pipes and supports of a rack, for rays. Pipes end in flat discs.
class RackSurface {
 public:
  RackSurface() = default;  ///< no bodies
  /// As `update`.
  RackSurface(const RackModel& model, PipeOffsets offsets) { update(model, offsets); }

  /// Sets the rack with its pipes at these offsets. `model` must be valid. Throws
  /// std::invalid_argument when there are offsets, but not one per pipe, or one that is not finite.
  /// Allocates when the rack has more sections or supports than before.
  void update(const RackModel& model, PipeOffsets offsets);

  /// The nearest point in front of `origin` at which the ray enters a body. Nothing when it meets
  /// none, when `direction` is zero, or when a value is not finite. The distance is in metres for
  /// any length of `direction`. Within a body the distance is 0 and the normal is opposite to the
  /// ray. Allocates nothing.
  [[nodiscard]] std::optional<SurfaceHit> first_hit(
      const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const noexcept;

  /// The surface point at a pixel of the (distorted) image. Nothing also where the camera has no
  /// ray.
  [[nodiscard]] std::optional<SurfaceHit> seen_at(const geometry::Camera& camera,
                                                  const geometry::SE3& T_camera_rack,
                                                  const Eigen::Vector2d& pixel) const noexcept;

  /// Pixel of a surface point in the (distorted) image. Nothing when it is outside the image or
  /// nearer than `margin` pixels to its border; when the surface there does not face the camera,
  /// the cosine between `normal` (outward, unit vector) and the direction to the camera not being
  /// above `least_cosine`; or when a body is in front of it by more than 0.1 mm.
  [[nodiscard]] std::optional<Eigen::Vector2d> visible_at(const Eigen::Vector3d& point,
                                                          const Eigen::Vector3d& normal,
                                                          const geometry::Camera& camera,
                                                          const geometry::SE3& T_camera_rack,
                                                          double margin = 0,
                                                          double least_cosine = 0) const noexcept;

 private:
  struct Body {
    PipeSection section;
    std::uint16_t pipe;
    std::uint16_t part;
  };
  std::vector<Body> sections_;
  struct Box {
    Eigen::Vector3d lowest_corner, highest_corner;
  };
  std::vector<Box> boxes_;
  std::vector<PipeSection> of_one_pipe_;  ///< working memory of `update`
};

}  // namespace pipescout::rack_vision
