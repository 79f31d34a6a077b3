// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/rack_model.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <locale>
#include <numbers>
#include <sstream>

#include "section_overlap.hpp"

namespace pipescout::rack_vision {
namespace {

using Part = InvalidRack::Part;

/// Larger coordinates (m) are a mistake of units, or no rack.
constexpr double kLargestCoordinate = 1e5;
constexpr const char* kCoordinateRange = "finite and at most 100 km";

bool is_coordinate(double value) {
  return std::abs(value) <= kLargestCoordinate;
}

/// The pipe or support in which a field is wrong.
struct Place {
  Part part;
  std::size_t index;
  std::string name;

  void require(bool holds, const std::string& field, double value, const char* range) const {
    if (!holds) {
      std::ostringstream text;
      text.imbue(std::locale::classic());
      text << field << " is " << value << "; it must be " << range;
      fail(text.str());
    }
  }
  [[noreturn]] void fail(const std::string& message) const {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text << (part == Part::kPipe ? "pipe " : "support ") << index;
    if (!name.empty()) {
      text << " '" << name << "'";
    }
    throw InvalidRack(part, index, text.str() + ": " + message);
  }
};

[[noreturn]] void fail_rack(const std::string& message) {
  throw InvalidRack(Part::kRack, 0, message);
}

void check_radii(const Place& place, const std::vector<RadiusAt>& radii) {
  if (radii.size() < 2) {
    place.fail("radii has " + std::to_string(radii.size()) + " entries; it must have at least 2");
  }
  for (std::size_t i = 0; i < radii.size(); ++i) {
    const std::string field = "radii[" + std::to_string(i) + "]";
    place.require(is_coordinate(radii[i].radius) && radii[i].radius > 0, field + ".radius",
                  radii[i].radius, "above 0 m");
    place.require(is_coordinate(radii[i].along), field + ".along", radii[i].along,
                  kCoordinateRange);
    if (i == 0) {
      place.require(radii[i].along == 0, field + ".along", radii[i].along,
                    "0: the first is that of the start");
    } else {
      place.require(radii[i].along >= radii[i - 1].along, field + ".along", radii[i].along,
                    "at least that of the previous entry");
    }
  }
  place.require(radii.back().along > 0, "radii: along of the last entry", radii.back().along,
                "above 0 m: it is the length of the pipe");
}

void check_shape_deviation(const Place& place, const Pipe& pipe) {
  // Three deviations of the radius must leave a pipe.
  const double radius = pipe.smallest_radius() / 3;
  const ShapeDeviation& shape = pipe.shape_deviation;
  const auto within = [](double value, double most) { return value >= 0 && value <= most; };
  place.require(within(shape.height, kMostHeightDeviation), "height_deviation", shape.height,
                "0 to 0.3 m");
  place.require(within(shape.direction, kMostDirectionDeviation), "direction_deviation",
                shape.direction, "0 to 0.1 rad");
  place.require(within(shape.radius, radius), "radius_deviation", shape.radius,
                "at least 0 m, and at most a third of the smallest radius");
  if (shape.height > 0 && std::abs(pipe.direction.z()) > std::numbers::sqrt2 / 2) {
    place.fail("height_deviation must be 0 for a pipe steeper than 45 degrees");
  }
}

void check_pipe(const Place& place, const Pipe& pipe) {
  constexpr const char* kAxes = "xyz";
  for (int axis = 0; axis < 3; ++axis) {
    place.require(is_coordinate(pipe.start[axis]), std::string("start.") + kAxes[axis],
                  pipe.start[axis], kCoordinateRange);
  }
  const double norm = pipe.direction.norm();
  place.require(std::abs(norm - 1) <= 1e-6, "the norm of direction", norm, "1");
  check_radii(place, pipe.radii);
  // A shift along its own axis shows in no contour line.
  const double across = pipe.direction.tail<2>().norm();
  if (pipe.movable && across < 1e-3) {
    place.fail("movable is true; it must be false for a pipe that runs along x");
  }
  check_shape_deviation(place, pipe);
}

void check_support(const Place& place, const Support& support) {
  constexpr const char* kAxes = "xyz";
  for (int axis = 0; axis < 3; ++axis) {
    const double low = support.lowest_corner[axis];
    const double high = support.highest_corner[axis];
    place.require(is_coordinate(low), std::string("lowest_corner.") + kAxes[axis], low,
                  kCoordinateRange);
    place.require(is_coordinate(high), std::string("highest_corner.") + kAxes[axis], high,
                  kCoordinateRange);
    place.require(high > low, std::string("highest_corner.") + kAxes[axis], high,
                  "above that of the lowest corner");
  }
}

template <typename Bodies>
void check_names(Part part, const Bodies& bodies) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Place place{part, i, bodies[i].name};
    if (bodies[i].name.empty()) {
      place.fail("name is empty");
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (bodies[j].name == bodies[i].name) {
        place.fail("name is also that of number " + std::to_string(j));
      }
    }
  }
}

void check_overlaps(const std::vector<Pipe>& pipes) {
  std::vector<std::vector<PipeSection>> sections(pipes.size());
  for (std::size_t i = 0; i < pipes.size(); ++i) {
    append_sections(pipes[i], 0, sections[i]);
    for (std::size_t j = 0; j < i; ++j) {
      for (const PipeSection& a : sections[i]) {
        for (const PipeSection& b : sections[j]) {
          if (sections_overlap(a, b)) {
            Place{Part::kPipe, i, pipes[i].name}.fail("intersects pipe " + std::to_string(j) +
                                                      " '" + pipes[j].name + "'");
          }
        }
      }
    }
  }
}

}  // namespace

double Pipe::largest_radius() const {
  return std::ranges::max_element(radii, {}, &RadiusAt::radius)->radius;
}

double Pipe::smallest_radius() const {
  return std::ranges::min_element(radii, {}, &RadiusAt::radius)->radius;
}

void RackModel::validate() const {
  if (pipes.empty() || pipes.size() > kMaxPipes) {
    fail_rack("the rack has " + std::to_string(pipes.size()) + " pipes; it must have 1 to " +
              std::to_string(kMaxPipes));
  }
  if (supports.size() > kMaxSupports) {
    fail_rack("the rack has " + std::to_string(supports.size()) +
              " supports; it must have at most " + std::to_string(kMaxSupports));
  }
  check_names(Part::kPipe, pipes);
  check_names(Part::kSupport, supports);
  const auto shaped = static_cast<std::size_t>(
      std::ranges::count_if(pipes, [](const Pipe& pipe) { return pipe.shape_deviation.any(); }));
  if (shaped > kMaxShapedPipes) {
    fail_rack("the rack has " + std::to_string(shaped) +
              " pipes with deviations of their shape; it must have at most " +
              std::to_string(kMaxShapedPipes));
  }
  std::vector<PipeSection> sections;
  for (std::size_t i = 0; i < pipes.size(); ++i) {
    check_pipe({Part::kPipe, i, pipes[i].name}, pipes[i]);
    append_sections(pipes[i], 0, sections);
  }
  if (pipes[0].movable) {
    Place{Part::kPipe, 0, pipes[0].name}.fail(
        "movable is true; it must be false for the first pipe, which defines the frame");
  }
  if (pipes[0].shape_deviation.any()) {
    Place{Part::kPipe, 0, pipes[0].name}.fail(
        "deviations of its shape must be 0 for the first pipe, which defines the frame");
  }
  if (sections.size() > kMaxSections) {
    fail_rack("the rack has " + std::to_string(sections.size()) +
              " sections of pipes; it must have at most " + std::to_string(kMaxSections));
  }
  for (std::size_t i = 0; i < supports.size(); ++i) {
    check_support({Part::kSupport, i, supports[i].name}, supports[i]);
  }
  check_overlaps(pipes);
}

std::vector<Pipe> row_of_pipes(std::span<const RowPipe> row) {
  std::vector<Pipe> pipes;
  double left = 0;
  for (const RowPipe& entry : row) {
    const Place place{Part::kPipe, pipes.size(), entry.name};
    Pipe pipe{.name = entry.name, .radii = entry.radii};
    check_pipe(place, pipe);
    if (!pipes.empty()) {
      place.require(is_coordinate(entry.gap) && entry.gap >= 0, "gap", entry.gap, "at least 0 m");
      left += entry.gap;
    }
    const double radius = pipe.largest_radius();
    pipe.start = {left + radius, 0, radius};
    pipe.movable = !pipes.empty();
    left += 2 * radius;
    pipes.push_back(std::move(pipe));
  }
  return pipes;
}

Pipe shaped(const Pipe& pipe, const PipeShape& shape) {
  const Eigen::Vector3d& direction = pipe.direction;
  const Eigen::Vector3d level = direction.cross(Eigen::Vector3d::UnitZ());
  constexpr double kUpright = 1e-3;  // there all sides are alike
  const Eigen::Vector3d right =
      level.norm() > kUpright ? level.normalized() : Eigen::Vector3d::UnitX();
  Pipe result = pipe;
  result.direction =
      (direction + shape.turn_aside * right + shape.turn_up * right.cross(direction)).normalized();
  const double half = 0.5 * pipe.length();
  result.start = pipe.start + half * (direction - result.direction) +
                 Eigen::Vector3d(shape.offset, 0, shape.height);
  for (RadiusAt& each : result.radii) {
    each.radius += shape.radius;
  }
  return result;
}

void append_sections(const Pipe& pipe, double offset, std::vector<PipeSection>& sections) {
  const Eigen::Vector3d start = pipe.start + offset * Eigen::Vector3d::UnitX();
  for (std::size_t i = 1; i < pipe.radii.size(); ++i) {
    const RadiusAt& from = pipe.radii[i - 1];
    const RadiusAt& to = pipe.radii[i];
    if (to.along > from.along) {
      sections.push_back({start + from.along * pipe.direction, pipe.direction,
                          to.along - from.along, from.radius, to.radius});
    }
  }
}

}  // namespace pipescout::rack_vision
