// SPDX-License-Identifier: Apache-2.0
#include "pipescout/planning/motion_primitives.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "pipescout/validation/check.hpp"

namespace pipescout::navigation {
namespace {

constexpr double kLargestTurningRadius = 1000;  // m
constexpr double kLargestSpacing = 100;         // m
constexpr double kExact = 1e-6;                 // m and rad, of rounding

Pose2d end_of(const Pose2d& start, const std::vector<ArcPiece>& pieces) {
  Pose2d pose = start;
  for (const ArcPiece& piece : pieces) {
    pose = drive_arc(pose, piece.curvature, piece.length);
  }
  return pose;
}

/// Smallest steps along the 16 headings, in spacings.
constexpr std::array<std::array<int, 2>, 16> kDirections{{{1, 0},
                                                          {2, 1},
                                                          {1, 1},
                                                          {1, 2},
                                                          {0, 1},
                                                          {-1, 2},
                                                          {-1, 1},
                                                          {-2, 1},
                                                          {-1, 0},
                                                          {-2, -1},
                                                          {-1, -1},
                                                          {-1, -2},
                                                          {0, -1},
                                                          {1, -2},
                                                          {1, -1},
                                                          {2, -1}}};

MotionPrimitive straight(int heading, double length, double spacing) {
  const auto& step = kDirections[static_cast<std::size_t>(heading)];
  const double one = std::hypot(step[0], step[1]) * spacing;
  const int count = std::max(1, static_cast<int>(std::round(length / one)));
  return {.start_heading = heading,
          .end_heading = heading,
          .columns = count * step[0],
          .rows = count * step[1],
          .pieces = {{0, count * one}}};
}

/// The shortest turn between two headings that ends on the lattice.
std::optional<MotionPrimitive> shortest_turn(int start, int end, double turning_radius,
                                             double spacing, const std::vector<double>& headings) {
  const double from = headings[static_cast<std::size_t>(start)];
  const double to = headings[static_cast<std::size_t>(end)];
  const double turn = std::abs(wrap_angle(to - from));
  // The arc alone is this long; its end is at most two spacings off the lattice.
  const int reach = static_cast<int>(std::ceil(2 * turning_radius * turn / spacing)) + 4;
  std::optional<MotionPrimitive> best;
  for (int rows = -reach; rows <= reach; ++rows) {
    for (int columns = -reach; columns <= reach; ++columns) {
      auto pieces = straight_arc_straight(from, to, {columns * spacing, rows * spacing});
      if (pieces.empty()) {
        continue;
      }
      MotionPrimitive found{.start_heading = start,
                            .end_heading = end,
                            .columns = columns,
                            .rows = rows,
                            .pieces = std::move(pieces)};
      if (found.radius() >= turning_radius && (!best || found.length() < best->length())) {
        best = std::move(found);
      }
    }
  }
  return best;
}

}  // namespace

double MotionPrimitive::length() const {
  double sum = 0;
  for (const ArcPiece& piece : pieces) {
    sum += std::abs(piece.length);
  }
  return sum;
}

double MotionPrimitive::radius() const {
  for (const ArcPiece& piece : pieces) {
    if (piece.curvature != 0) {
      return 1 / std::abs(piece.curvature);
    }
  }
  return 0;
}

double MotionPrimitive::arc_length() const {
  double sum = 0;
  for (const ArcPiece& piece : pieces) {
    sum += piece.curvature != 0 ? std::abs(piece.length) : 0;
  }
  return sum;
}

void LatticePrimitives::validate() const {
  validation::check_above("turning_radius", turning_radius, 0, kLargestTurningRadius);
  validation::check_above("spacing", spacing, 0, kLargestSpacing);
  if (headings.empty()) {
    validation::refuse("headings: none given");
  }
  for (const double heading : headings) {
    validation::require("headings", heading, true, "the finite numbers");
  }
  std::vector<bool> has_one(headings.size(), false);
  for (const MotionPrimitive& primitive : primitives) {
    const auto start = static_cast<std::size_t>(primitive.start_heading);
    const auto end = static_cast<std::size_t>(primitive.end_heading);
    if (start >= headings.size() || end >= headings.size()) {
      validation::refuse("primitive ", primitive.id, ": a heading is not one of the ",
                         headings.size());
    }
    const Pose2d reached = end_of({0, 0, headings[start]}, primitive.pieces);
    const Point2d planned{primitive.columns * spacing, primitive.rows * spacing};
    if (primitive.pieces.empty() || !is_finite(reached) ||
        distance(reached.position(), planned) > kExact ||
        std::abs(wrap_angle(reached.heading - headings[end])) > kExact) {
      validation::refuse("primitive ", primitive.id, ": it ends at (", reached.x, ", ", reached.y,
                         ", ", reached.heading, "), not at (", planned.x, ", ", planned.y, ", ",
                         headings[end], ")");
    }
    const double radius = primitive.radius();
    if (radius != 0 && radius < turning_radius * (1 - kExact)) {
      validation::refuse("primitive ", primitive.id, ": its radius is ", radius,
                         " m; it must be at least ", turning_radius);
    }
    has_one[start] = true;
  }
  for (std::size_t i = 0; i < has_one.size(); ++i) {
    if (!has_one[i]) {
      validation::refuse("primitives: none starts at heading ", i);
    }
  }
}

std::vector<Pose2d> LatticePrimitives::poses(const MotionPrimitive& primitive, double step) const {
  validation::require("step", step, step > 0, "above 0");
  Pose2d pose{0, 0, headings.at(static_cast<std::size_t>(primitive.start_heading))};
  std::vector<Pose2d> result{pose};
  for (const ArcPiece& piece : primitive.pieces) {
    const double parts = std::ceil(std::abs(piece.length) / step);
    for (double i = 1; i <= parts; ++i) {
      result.push_back(drive_arc(pose, piece.curvature, piece.length * i / parts));
    }
    pose = result.back();
  }
  return result;
}

std::vector<double> lattice_headings() {
  std::vector<double> headings;
  for (const auto& direction : kDirections) {
    const double angle = std::atan2(direction[1], direction[0]);
    headings.push_back(angle < 0 ? angle + 2 * std::numbers::pi : angle);
  }
  return headings;
}

LatticePrimitives generate_primitives(double turning_radius, double spacing) {
  validation::check_above("turning_radius", turning_radius, 0, kLargestTurningRadius);
  validation::check_above("spacing", spacing, 0, turning_radius / 2);
  LatticePrimitives result{.turning_radius = turning_radius,
                           .spacing = spacing,
                           .headings = lattice_headings(),
                           .primitives = {}};
  constexpr int kHeadings = static_cast<int>(kDirections.size());
  for (int start = 0; start < kHeadings; ++start) {
    for (const int turn : {1, -1, 2, -2}) {
      const int end = (start + turn + kHeadings) % kHeadings;
      if (auto primitive = shortest_turn(start, end, turning_radius, spacing, result.headings)) {
        result.primitives.push_back(std::move(*primitive));
      }
    }
    // A short one to meet places exactly, and one about as long as a turn.
    const MotionPrimitive one = straight(start, 0, spacing);
    const MotionPrimitive more = straight(start, turning_radius / 2, spacing);
    result.primitives.push_back(one);
    if (more.columns != one.columns || more.rows != one.rows) {
      result.primitives.push_back(more);
    }
  }
  for (std::size_t i = 0; i < result.primitives.size(); ++i) {
    result.primitives[i].id = static_cast<std::int64_t>(i);
  }
  result.validate();
  return result;
}

std::vector<ArcPiece> straight_arc_straight(double start, double end, const Point2d& to) {
  const double turn = wrap_angle(end - start);
  const Point2d u{std::cos(start), std::sin(start)};
  const Point2d v{std::cos(end), std::sin(end)};
  if (std::abs(turn) < kExact) {
    const double along = to.x * u.x + to.y * u.y;
    const double across = to.y * u.x - to.x * u.y;
    return along > kExact && std::abs(across) < kExact ? std::vector<ArcPiece>{{0, along}}
                                                       : std::vector<ArcPiece>{};
  }
  // The lines along start and end meet `before` m after the start and `after` m before the end.
  const double determinant = u.x * v.y - u.y * v.x;
  if (std::abs(determinant) < kExact) {
    return {};
  }
  const double before = (to.x * v.y - to.y * v.x) / determinant;
  const double after = (u.x * to.y - u.y * to.x) / determinant;
  const double tangent = std::min(before, after);
  if (tangent <= kExact) {
    return {};
  }
  const double radius = tangent / std::tan(std::abs(turn) / 2);
  std::vector<ArcPiece> pieces;
  if (before - tangent > kExact) {
    pieces.push_back({0, before - tangent});
  }
  pieces.push_back({std::copysign(1 / radius, turn), radius * std::abs(turn)});
  if (after - tangent > kExact) {
    pieces.push_back({0, after - tangent});
  }
  return pieces;
}

}  // namespace pipescout::navigation
