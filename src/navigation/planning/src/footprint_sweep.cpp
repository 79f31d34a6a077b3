// SPDX-License-Identifier: Apache-2.0
#include "footprint_sweep.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipescout/validation/check.hpp"

namespace pipescout::navigation {
namespace {

constexpr double kLargestDiscs = 6;
constexpr double kSpareCells = 3;
constexpr double kMostCells = 200;  // of a distance field

struct Box {
  Point2d low;
  Point2d high;
};

Box box_of(const Footprint& footprint) {
  Box box{footprint.corners().front(), footprint.corners().front()};
  for (const Point2d& corner : footprint.corners()) {
    box.low = {std::min(box.low.x, corner.x), std::min(box.low.y, corner.y)};
    box.high = {std::max(box.high.x, corner.x), std::max(box.high.y, corner.y)};
  }
  return box;
}

double disc_count(const Box& box) {
  const double shape = (box.high.x - box.low.x) / (box.high.y - box.low.y);
  return std::clamp(std::ceil(2 * shape), 1.0, kLargestDiscs);
}

double disc_radius_of(const Box& box) {
  return std::hypot((box.high.x - box.low.x) / disc_count(box) / 2, (box.high.y - box.low.y) / 2);
}

double reach_of_field(const OccupancyGrid& grid, const Footprint& footprint, double near) {
  const double wanted =
      std::max(disc_radius_of(box_of(footprint)) + near, footprint.inscribed_radius() + near) +
      kSpareCells * grid.resolution();
  return std::clamp(wanted, grid.resolution(), kMostCells * grid.resolution());
}

}  // namespace

FootprintSweep::FootprintSweep(OccupancyGrid grid, Footprint footprint,
                               const LatticeSettings& settings)
    : grid_(std::move(grid)),
      footprint_(std::move(footprint)),
      near_(settings.near),
      unknown_(settings.unknown),
      field_(grid_, unknown_, reach_of_field(grid_, footprint_, settings.near)) {
  const Box box = box_of(footprint_);
  const double count = disc_count(box);
  disc_radius_ = disc_radius_of(box);
  const double width = (box.high.x - box.low.x) / count;
  for (double i = 0; i < count; ++i) {
    discs_.push_back({box.low.x + (i + 1.0 / 2) * width, (box.low.y + box.high.y) / 2});
  }
}

CellBox FootprintSweep::change(std::span<const CellChange> cells) {
  if (cells.empty()) {
    return {{0, 0}, {-1, -1}};
  }
  CellBox box{cells.front().cell, cells.front().cell};
  for (const CellChange& change : cells) {
    if (!grid_.contains(change.cell)) {
      validation::refuse("cell: (", change.cell.column, ", ", change.cell.row,
                         ") is outside a grid of ", grid_.width(), " x ", grid_.height());
    }
    box.low = {std::min(box.low.column, change.cell.column),
               std::min(box.low.row, change.cell.row)};
    box.high = {std::max(box.high.column, change.cell.column),
                std::max(box.high.row, change.cell.row)};
  }
  for (const CellChange& change : cells) {
    grid_.set(change.cell, change.state);
  }
  field_.update(grid_, box);
  return box;
}

double FootprintSweep::room(const Pose2d& pose) const {
  const Pose2d in_grid = grid_.to_grid(pose);
  // To the edge of the grid.
  const double inside =
      std::min({in_grid.x, in_grid.y, grid_.width() - in_grid.x, grid_.height() - in_grid.y}) *
      grid_.resolution();
  const double cosine = std::cos(in_grid.heading) / grid_.resolution();
  const double sine = std::sin(in_grid.heading) / grid_.resolution();
  double room = std::min(inside, field_.largest());
  for (const Point2d& disc : discs_) {
    const Point2d centre{in_grid.x + cosine * disc.x - sine * disc.y,
                         in_grid.y + sine * disc.x + cosine * disc.y};
    room = std::min(room, field_.bounds(centre).low - disc_radius_);
  }
  return room;
}

bool FootprintSweep::collides_at(const Pose2d& pose) const {
  return !grid_.cell_at(pose.position()) || collides(footprint_, grid_, pose, unknown_);
}

bool FootprintSweep::is_free(const Pose2d& pose) const {
  return room(pose) > 0 || !collides_at(pose);
}

bool FootprintSweep::is_free(const Pose2d& start, const ArcList& arcs) const {
  constexpr double kRounding = 1e-9;  // m
  return free_length(start, arcs) >= length_of(arcs) - kRounding;
}

bool FootprintSweep::is_stretch_free(const Pose2d& start, const ArcPiece& arc, double from,
                                     double to) const {
  constexpr double kShortest = 1e-3;  // m; what may collide on less is taken to do so
  const Pose2d end = drive_arc(start, arc.curvature, std::copysign(to, arc.length));
  if (!grid_.cell_at(end.position())) {
    return false;
  }
  if (!may_collide_along(footprint_, grid_,
                         drive_arc(start, arc.curvature, std::copysign(from, arc.length)),
                         arc.curvature, std::copysign(to - from, arc.length), unknown_)) {
    return true;
  }
  const double middle = (from + to) / 2;
  return to - from > kShortest && !collides_at(end) && is_stretch_free(start, arc, from, middle) &&
         is_stretch_free(start, arc, middle, to);
}

double FootprintSweep::free_length(const Pose2d& start, const ArcList& arcs) const {
  constexpr double kStretch = 0.2;   // m
  constexpr double kWorthIt = 0.05;  // m; with less room, the footprint itself is checked
  Pose2d pose = start;
  double driven = 0;
  for (const ArcPiece& arc : arcs) {
    const double length = std::abs(arc.length);
    // No point of the footprint moves farther than this for each metre of the origin.
    const double swing = 1 + std::abs(arc.curvature) * footprint_.circumscribed_radius();
    for (double along = 0; along < length;) {
      const double free =
          room(drive_arc(pose, arc.curvature, std::copysign(along, arc.length))) / swing;
      if (free > kWorthIt) {
        along += free;
        continue;
      }
      const double to = std::min(length, along + kStretch);
      if (!is_stretch_free(pose, arc, along, to)) {
        return driven + along;
      }
      along = to;
    }
    pose = drive_arc(pose, arc.curvature, arc.length);
    driven += length;
  }
  return driven;
}

double FootprintSweep::nearness(const Pose2d& start, const ArcList& arcs) const {
  constexpr double kLargestStep = 0.25;  // m
  Pose2d pose = start;
  double sum = 0;
  for (const ArcPiece& arc : arcs) {
    const double length = std::abs(arc.length);
    const double parts = std::ceil(length / kLargestStep);
    for (double i = 0; i < parts; ++i) {
      const Pose2d middle = drive_arc(pose, arc.curvature, arc.length * (i + 1.0 / 2) / parts);
      const auto bounds = field_.bounds(grid_.to_grid(middle.position()));
      const double clearance = (bounds.low + bounds.high) / 2 - footprint_.inscribed_radius();
      sum += length / parts * std::clamp(1 - clearance / near_, 0.0, 1.0);
    }
    pose = drive_arc(pose, arc.curvature, arc.length);
  }
  return sum;
}

}  // namespace pipescout::navigation
