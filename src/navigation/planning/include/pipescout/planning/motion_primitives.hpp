// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "pipescout/navigation_maps/path.hpp"

/// Short feasible motions that join the states of a lattice (Pivtoraiko and Kelly, "Generating near
/// minimal spanning control sets for constrained motion planning in discrete state spaces", 2005).
namespace pipescout::navigation {

/// A piece of constant curvature.
struct ArcPiece {
  double curvature = 0;  ///< 1/m
  double length = 0;     ///< m, negative in reverse
};

/// A motion forwards: straight, an arc, straight.
struct MotionPrimitive {
  std::int64_t id = 0;
  int start_heading = 0;  ///< positions in LatticePrimitives::headings
  int end_heading = 0;
  int columns = 0;  ///< from start to end, in spacings of the lattice
  int rows = 0;
  std::vector<ArcPiece> pieces;

  [[nodiscard]] double length() const;
  /// m, of the arc; 0 if there is none.
  [[nodiscard]] double radius() const;
  [[nodiscard]] double arc_length() const;
};

/// Motions forwards from each heading of a lattice; those in reverse are the same, driven back.
struct LatticePrimitives {
  double turning_radius = 1;     ///< m, smallest, (0, 1000]
  double spacing = 0.1;          ///< m, of the lattice, (0, 100]; has nothing to do with a map's
  std::vector<double> headings;  ///< rad, all different
  std::vector<MotionPrimitive> primitives;

  /// Throws std::invalid_argument naming the primitive: headings that are not there, an arc below
  /// the turning radius, a heading with no primitive, pieces that end elsewhere.
  void validate() const;
  /// Poses of a primitive from (0, 0) at its start heading, at least every `step` m.
  [[nodiscard]] std::vector<Pose2d> poses(const MotionPrimitive& primitive, double step) const;
};

/// The 16 headings along which straight lines meet lattice points: multiples of 90 degrees and
/// those of (2, 1), (1, 1), (1, 2), from 0 counter-clockwise; rad, [0, 2 pi).
[[nodiscard]] std::vector<double> lattice_headings();

/// Straight on, and left and right by one heading and by two; for each heading of its own, not
/// mirrored. Throws std::invalid_argument for values outside their ranges, and for a spacing of
/// more than half the turning radius.
[[nodiscard]] LatticePrimitives generate_primitives(double turning_radius, double spacing);

/// Straight, arc, straight from (0, 0, start) to (x, y, end). Empty where that needs to go back.
[[nodiscard]] std::vector<ArcPiece> straight_arc_straight(double start, double end,
                                                          const Point2d& to);

}  // namespace pipescout::navigation
