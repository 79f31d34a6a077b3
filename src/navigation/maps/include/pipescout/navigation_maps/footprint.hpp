// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "pipescout/navigation_maps/occupancy_grid.hpp"
#include "pipescout/navigation_maps/pose2d.hpp"

namespace pipescout::navigation {

/// How cells of no known state count in collision checks.
enum class UnknownCells { kBlocked, kFree };

/// The outline of a robot in its own frame: a simple polygon, convex or not.
class Footprint {
 public:
  /// A rectangle around the x axis: from `rear` m behind the origin to `front` m before it, `width`
  /// m wide. Throws std::invalid_argument unless front + rear and width are within (0, 100].
  static Footprint rectangle(double front, double rear, double width);
  /// Corners in order, either way round. Throws std::invalid_argument for fewer than 3, for what is
  /// not finite or farther than 100 m away, for no area, and for edges that cross or touch.
  static Footprint polygon(std::vector<Point2d> corners);

  /// Counter-clockwise.
  [[nodiscard]] const std::vector<Point2d>& corners() const { return corners_; }
  /// m, largest distance of the outline from the origin.
  [[nodiscard]] double circumscribed_radius() const { return circumscribed_radius_; }
  /// m, radius of the largest circle around the origin inside; 0 if the origin is outside.
  [[nodiscard]] double inscribed_radius() const { return inscribed_radius_; }
  /// Each as a convex polygon, counter-clockwise; together they are the footprint.
  [[nodiscard]] const std::vector<std::vector<Point2d>>& convex_parts() const { return parts_; }
  /// The same enlarged by `margin` m, [0, 10]: each corner is moved outwards so that no edge is
  /// nearer than that to where it was. Throws std::invalid_argument for other margins, and where
  /// the edges of a polygon that is not convex would cross.
  [[nodiscard]] Footprint inflated(double margin) const;

 private:
  explicit Footprint(std::vector<Point2d> corners);

  std::vector<Point2d> corners_;
  std::vector<std::vector<Point2d>> parts_;
  double circumscribed_radius_ = 0;
  double inscribed_radius_ = 0;
};

/// Whether the footprint at T_map_robot shares a point with a blocked cell. Exact but for rounding
/// of floating-point numbers: the polygon is turned, not the cells it covers at some heading. All
/// outside the grid counts as unknown. True for a pose that is not finite. Allocates nothing for
/// convex parts of up to 32 corners. O(rows + cells under the footprint).
[[nodiscard]] bool collides(const Footprint& footprint, const OccupancyGrid& grid,
                            const Pose2d& T_map_robot, UnknownCells unknown);

/// False only if the footprint collides nowhere on an arc of `length` m (negative: in reverse) with
/// a curvature in 1/m. It is then free at each of the infinitely many poses. True may be wrong by
/// the height of the arcs that its corners move on: checks the hull of each convex part at both
/// ends, enlarged by that height. True for arcs of more than half a turn. Allocates nothing for
/// convex parts of up to 8 corners.
[[nodiscard]] bool may_collide_along(const Footprint& footprint, const OccupancyGrid& grid,
                                     const Pose2d& T_map_robot, double curvature, double length,
                                     UnknownCells unknown);

/// Whether the footprints share a point. Exact, as above.
[[nodiscard]] bool overlap(const Footprint& a, const Pose2d& T_map_a, const Footprint& b,
                           const Pose2d& T_map_b);

}  // namespace pipescout::navigation
