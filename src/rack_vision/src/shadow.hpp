// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

#include "pipescout/rack_vision/rack_model.hpp"

/// What a convex body hides of a straight line. The part of a line behind a convex body is one
/// interval, since the shadow of the body (all that it hides from the eye) is convex as well; both
/// kinds of bodies have it in closed form.
///
/// All points here are relative to the eye, in the axes of the rack. A body is smaller by kSkin
/// than it is, so that a line that only touches it is not hidden.
namespace pipescout::rack_vision {

inline constexpr double kSkin = 1e-6;  ///< m

/// Part of a segment: 0 is its start, 1 its end.
struct Interval {
  double from = 0;
  double to = 1;
};

/// A half-space inside . x >= 0 in front of the eye.
using ViewPlanes = std::array<Eigen::Vector3d, 4>;

/// Shadow of a section of a pipe, a solid cylinder or truncated cone with flat ends.
class SectionShadow {
 public:
  SectionShadow(const PipeSection& section, const Eigen::Vector3d& eye);

  /// The eye is within the body.
  [[nodiscard]] bool holds_eye() const noexcept;
  /// No point of the body is inside all planes, as far as one plane alone tells.
  [[nodiscard]] bool outside(const ViewPlanes& planes) const noexcept;
  /// What it hides of the segment from `a` to `b`; false: nothing.
  [[nodiscard]] bool hides(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                           Interval& hidden) const noexcept;

 private:
  /// A point or a direction in the frame of the section: x and y across, x pointing to the eye, z
  /// along the axis; and what the radius of the cone changes by.
  struct Local {
    double x, y, z, radius;
  };
  [[nodiscard]] Local local(const Eigen::Vector3d& direction) const noexcept;
  [[nodiscard]] bool hides_point(const Local& p) const noexcept;
  void widen_by_tangents(const Local& p, const Local& e, Interval& hull) const noexcept;
  void widen_by_crossing(const Local& p, const Local& e, Interval& hull) const noexcept;
  void widen_by_rims(const Local& p, const Local& e, Interval& hull) const noexcept;

  Eigen::Vector3d across_x_, across_y_, along_;
  Eigen::Vector3d start_;  ///< relative to the eye
  double length_;
  double radius_start_, radius_end_, slope_;
  Local eye_{};
  bool has_tangents_ = false;
  double tangent_x_ = 0, tangent_y_ = 0;  ///< normals of the tangent planes are (x, +-y, -slope)
  double nearest_ = 0;  ///< the body is at least so far from the eye, across the axis
};

/// Shadow of a support.
class SupportShadow {
 public:
  SupportShadow(const Support& support, const Eigen::Vector3d& eye);

  [[nodiscard]] bool holds_eye() const noexcept { return count_ == 0; }
  [[nodiscard]] bool outside(const ViewPlanes& planes) const noexcept;
  [[nodiscard]] bool hides(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                           Interval& hidden) const noexcept;

 private:
  struct HalfSpace {
    Eigen::Vector3d normal;
    double offset;  ///< normal . x <= offset is in the shadow
  };
  Eigen::Vector3d low_, high_;  ///< relative to the eye
  /// Planes through the eye and the outline, at most 6; then the faces turned to the eye, at
  /// most 3.
  std::array<HalfSpace, 9> planes_;
  std::size_t count_ = 0;
};

}  // namespace pipescout::rack_vision
