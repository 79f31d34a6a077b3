// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/plant_yard.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include "pipescout/statistics/draw.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

using Eigen::Vector2d;

constexpr double kWallThickness = 0.3;
/// s that a mover waits before it turns back.
constexpr double kPatience = 4;
constexpr double kPersonHalfWidth = 0.3;

Vector2d axis(double angle) {
  return {std::cos(angle), std::sin(angle)};
}

std::array<Vector2d, 4> yard_corners(const YardBox& box) {
  const Vector2d along = axis(box.heading) * box.half_length;
  const Vector2d across = Vector2d(-std::sin(box.heading), std::cos(box.heading)) * box.half_width;
  return {Vector2d(box.centre + along + across), Vector2d(box.centre - along + across),
          Vector2d(box.centre - along - across), Vector2d(box.centre + along - across)};
}

double extent_along(const YardBox& box, const Vector2d& direction) {
  const Vector2d along = axis(box.heading);
  return box.half_length * std::abs(along.dot(direction)) +
         box.half_width * std::abs(Vector2d(-along.y(), along.x()).dot(direction));
}

bool separated(const YardBox& a, const YardBox& b, double angle) {
  const Vector2d direction = axis(angle);
  return std::abs((a.centre - b.centre).dot(direction)) >
         extent_along(a, direction) + extent_along(b, direction);
}

double distance_to_box(const Vector2d& point, const YardBox& box) {
  const Vector2d d = point - box.centre;
  const Vector2d along = axis(box.heading);
  const double x = std::max(std::abs(d.dot(along)) - box.half_length, 0.0);
  const double y = std::max(std::abs(d.dot(Vector2d(-along.y(), along.x()))) - box.half_width, 0.0);
  return std::hypot(x, y);
}

/// Where a ray enters the box; infinite if it does not (slab method).
double ray_range(const Vector2d& from, const Vector2d& direction, const YardBox& box) {
  const Vector2d d = from - box.centre;
  const Vector2d along = axis(box.heading);
  const Vector2d across(-along.y(), along.x());
  double enter = 0;
  double leave = std::numeric_limits<double>::infinity();
  for (const auto& [position, speed, half] :
       {std::array{d.dot(along), direction.dot(along), box.half_length},
        std::array{d.dot(across), direction.dot(across), box.half_width}}) {
    if (std::abs(speed) < 1e-12) {
      if (std::abs(position) > half) {
        return std::numeric_limits<double>::infinity();
      }
      continue;
    }
    const double one = (-half - position) / speed;
    const double other = (half - position) / speed;
    enter = std::max(enter, std::min(one, other));
    leave = std::min(leave, std::max(one, other));
  }
  return enter <= leave ? enter : std::numeric_limits<double>::infinity();
}

}  // namespace

double box_distance(const YardBox& a, const YardBox& b) {
  constexpr double kQuarter = std::numbers::pi / 2;
  const bool apart = separated(a, b, a.heading) || separated(a, b, a.heading + kQuarter) ||
                     separated(a, b, b.heading) || separated(a, b, b.heading + kQuarter);
  if (!apart) {
    return 0;
  }
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vector2d& corner : yard_corners(a)) {
    nearest = std::min(nearest, distance_to_box(corner, b));
  }
  for (const Vector2d& corner : yard_corners(b)) {
    nearest = std::min(nearest, distance_to_box(corner, a));
  }
  return nearest;
}

void PlantYardParameters::validate() const {
  validation::check_within("rows", rows, 2, 20);
  validation::check_within("row_length", row_length, 10, 200);
  validation::check_within("aisle", aisle, 2.5, 20);
  validation::check_within("row_width", row_width, 0.5, 10);
  validation::check_within("road", road, 4, 20);
  validation::check_within("people", people, 0, 50);
  validation::check_within("vehicles", vehicles, 0, 20);
  validation::check_within("unmapped", unmapped, 0, 50);
}

void LidarParameters::validate() const {
  validation::check_within("beams", beams, 8, 10000);
  validation::check_above("largest_range", largest_range, 0, 200);
  validation::check_within("noise", noise, 0, 1);
  validation::check_within("dropouts", dropouts, 0, 1);
}

PlantYard::PlantYard(const PlantYardParameters& parameters, std::uint64_t seed)
    : parameters_(parameters) {
  parameters_.validate();
  const auto& p = parameters_;
  statistics::Draw draw(seed, 1);
  const double pitch = p.aisle + p.row_width;
  for (int i = 0; i < p.rows; ++i) {
    mapped_.push_back({.centre = {p.row_length / 2, i * pitch},
                       .half_length = p.row_length / 2,
                       .half_width = p.row_width / 2});
  }
  const double bottom = -p.row_width / 2 - p.road;
  const double top = (p.rows - 1) * pitch + p.row_width / 2 + p.road;
  const double middle = (bottom + top) / 2;
  const double length = p.row_length / 2 + p.road;
  for (const double y : {bottom - kWallThickness, top + kWallThickness}) {
    mapped_.push_back({.centre = {p.row_length / 2, y},
                       .half_length = length + 2 * kWallThickness,
                       .half_width = kWallThickness});
  }
  for (const double x : {-p.road - kWallThickness, p.row_length + p.road + kWallThickness}) {
    mapped_.push_back(
        {.centre = {x, middle}, .half_length = kWallThickness, .half_width = (top - bottom) / 2});
  }
  for (int i = 0; i < p.unmapped; ++i) {
    const auto aisle = static_cast<int>(draw.index(static_cast<std::size_t>(p.rows - 1)));
    const double side = draw.happens(0.5) ? 1 : -1;
    const double half = draw.uniform(0.15, 0.3);
    const double reach = draw.uniform(0.2, 0.8);
    const double y = aisle_middle(aisle) + side * (p.aisle / 2 - reach);
    unmapped_.push_back({.centre = {draw.uniform(0.25, 0.75) * p.row_length, y},
                         .heading = draw.uniform(0, 3),
                         .half_length = half,
                         .half_width = draw.uniform(0.15, 0.3)});
  }
  for (int i = 0; i < p.people; ++i) {
    // Across a road, or along an aisle.
    YardMover mover;
    mover.box.half_length = kPersonHalfWidth;
    mover.box.half_width = kPersonHalfWidth;
    mover.speed = draw.uniform(0.5, 1.6);
    if (draw.happens(0.5)) {
      const bool west = draw.happens(0.5);
      const double x = west ? -p.road + 0.6 : p.row_length + 0.6;
      const double y = draw.uniform(bottom + 2, top - 2);
      mover.from = {x, y};
      mover.to = {x + p.road - 1.2, y + draw.uniform(-1, 1)};
    } else {
      const auto aisle = static_cast<int>(draw.index(static_cast<std::size_t>(p.rows - 1)));
      const double y = aisle_middle(aisle) + draw.uniform(-1, 1) * (p.aisle / 2 - 0.6);
      mover.from = {0.2 * p.row_length, y};
      mover.to = {0.8 * p.row_length, y};
    }
    mover.box.centre = mover.from + draw.uniform(0, 1) * (mover.to - mover.from);
    movers_.push_back(mover);
  }
  for (int i = 0; i < p.vehicles; ++i) {
    YardMover mover;
    mover.box.half_length = 1.5;
    mover.box.half_width = 0.75;
    mover.speed = draw.uniform(0.8, 2.0);
    mover.sight = 3;
    const bool west = draw.happens(0.5);
    const double x = west ? -p.road + 1.2 : p.row_length + p.road - 1.2;
    mover.from = {x, bottom + 2.5};
    mover.to = {x, top - 2.5};
    mover.box.centre = mover.from + draw.uniform(0, 1) * (mover.to - mover.from);
    movers_.push_back(mover);
  }
}

double PlantYard::aisle_middle(int i) const {
  return (i + 0.5) * (parameters_.aisle + parameters_.row_width);
}

template <class Function>
void PlantYard::for_each(Function function) const {
  for (const YardBox& box : mapped_) {
    function(box);
  }
  for (const YardBox& box : unmapped_) {
    function(box);
  }
  for (const YardMover& mover : movers_) {
    function(mover.box);
  }
}

void PlantYard::step(double dt, const YardBox& robot) {
  for (YardMover& mover : movers_) {
    const Vector2d way = mover.to - mover.box.centre;
    const double left = way.norm();
    if (left < mover.speed * dt) {
      std::swap(mover.from, mover.to);
      continue;
    }
    const Vector2d direction = way / left;
    mover.box.heading = std::atan2(direction.y(), direction.x());
    // What it would sweep within its sight, a little wider than itself.
    YardBox swept = mover.box;
    swept.centre += direction * (mover.sight / 2);
    swept.half_length += mover.sight / 2;
    swept.half_width += 0.2;
    if (box_distance(swept, robot) <= 0) {
      mover.halted += dt;
      if (mover.halted > kPatience) {
        std::swap(mover.from, mover.to);
        mover.halted = 0;
      }
      continue;
    }
    mover.halted = 0;
    mover.box.centre += direction * mover.speed * dt;
  }
}

bool PlantYard::collides(const YardBox& robot) const {
  return clearance(robot) <= 0;
}

double PlantYard::clearance(const YardBox& robot) const {
  const double radius = std::hypot(robot.half_length, robot.half_width);
  double nearest = std::numeric_limits<double>::infinity();
  for_each([&](const YardBox& box) {
    // Cheap bound first: this runs at 1 kHz.
    if (distance_to_box(robot.centre, box) - radius < nearest) {
      nearest = std::min(nearest, box_distance(robot, box));
    }
  });
  return nearest;
}

void PlantYard::scan(const LidarParameters& lidar, const Vector2d& position, double heading,
                     std::uint64_t seed, std::vector<float>& ranges) const {
  lidar.validate();
  statistics::Draw draw(seed, 2);
  ranges.resize(static_cast<std::size_t>(lidar.beams));
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const double angle =
        heading - std::numbers::pi +
        2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(lidar.beams);
    const Vector2d direction = axis(angle);
    double nearest = std::numeric_limits<double>::infinity();
    for_each([&](const YardBox& box) {
      nearest = std::min(nearest, ray_range(position, direction, box));
    });
    const bool lost = nearest > lidar.largest_range || draw.happens(lidar.dropouts);
    ranges[i] = lost ? std::numeric_limits<float>::infinity()
                     : static_cast<float>(std::max(0.01, nearest + lidar.noise * draw.normal()));
  }
}

}  // namespace pipescout::simulation
