// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

/// Model of a pipe rack for localisation: Lippiello and Cacace, "Robust visual localization of a
/// UAV over a pipe-rack based on the Lie group SE(3)". Equation numbers below are those of that
/// paper.
///
/// The `rack` frame: x across the pipes, y along the flow, z up; z = 0 is the plane on which the
/// pipes rest, and the origin is below the left-most line of the first pipe, at its start. All
/// lengths are in metres.
namespace pipescout::rack_vision {

inline constexpr std::size_t kMaxPipes = 32;
inline constexpr std::size_t kMaxSections = 128;  ///< of all pipes together
inline constexpr std::size_t kMaxSupports = 64;
inline constexpr std::size_t kMaxShapedPipes = 8;       ///< with a ShapeDeviation
inline constexpr double kMostHeightDeviation = 0.3;     ///< m, see ShapeDeviation
inline constexpr double kMostDirectionDeviation = 0.1;  ///< rad

/// Radius of a pipe at a position along it.
struct RadiusAt {
  double along = 0;   ///< m from the start of the pipe
  double radius = 0;  ///< m, > 0
};

/// How far a pipe may be from what the model has, one sigma, beside its offset; 0: not at all.
struct ShapeDeviation {
  double height = 0;     ///< m: all of it along rack z
  double direction = 0;  ///< rad: of the axis about its middle, to each of two sides
  double radius = 0;     ///< m: of all its radii alike, as insulation does

  [[nodiscard]] bool any() const noexcept { return height > 0 || direction > 0 || radius > 0; }
};

/// A straight pipe. Its radius is linear between two entries of `radii` (a cylinder where they are
/// equal, a reducer where they differ); two entries at one position are a step.
struct Pipe {
  std::string name;
  Eigen::Vector3d start = Eigen::Vector3d::Zero();       ///< on its axis, rack frame
  Eigen::Vector3d direction = Eigen::Vector3d::UnitY();  ///< unit vector, of the flow
  std::vector<RadiusAt> radii;  ///< at least two; the first at 0, the last at the pipe's end
  /// Its offset along rack x may be estimated (equations 23 to 26). The first pipe of a rack
  /// defines the frame and has none; nor has one that runs along x.
  bool movable = true;
  /// What images are to tell of it. The first pipe has none.
  ShapeDeviation shape_deviation{};

  [[nodiscard]] double length() const { return radii.back().along; }
  [[nodiscard]] double largest_radius() const;
  [[nodiscard]] double smallest_radius() const;
};

/// A straight section of a pipe between two entries of `radii`: a cylinder or a truncated cone.
struct PipeSection {
  Eigen::Vector3d start;      ///< on the axis
  Eigen::Vector3d direction;  ///< unit vector
  double length = 0;          ///< > 0
  double radius_start = 0;
  double radius_end = 0;
};

/// A beam on which pipes rest, or any other box along the axes of the rack frame.
struct Support {
  std::string name;
  Eigen::Vector3d lowest_corner = Eigen::Vector3d::Zero();
  Eigen::Vector3d highest_corner = Eigen::Vector3d::Zero();
};

/// An invalid rack, with the part that is invalid.
class InvalidRack : public std::invalid_argument {
 public:
  enum class Part : std::uint8_t { kRack, kPipe, kSupport };
  InvalidRack(Part part, std::size_t index, const std::string& message)
      : std::invalid_argument(message), part_(part), index_(index) {}

  [[nodiscard]] Part part() const noexcept { return part_; }
  /// Index of the pipe or support, the later one if two are involved; 0 for the rack as a whole.
  [[nodiscard]] std::size_t index() const noexcept { return index_; }

 private:
  Part part_;
  std::size_t index_;
};

struct RackModel {
  std::vector<Pipe> pipes;  ///< from left to right, looking in the direction of the flow
  std::vector<Support> supports;

  /// Throws InvalidRack naming the pipe or support, the field, the value and the range: no pipe,
  /// empty or repeated names, values that are not finite, directions that are not unit
  /// vectors (to 1e-6), radii that are not positive or not in order along the pipe, pipes that
  /// intersect, supports without extent, more than kMaxPipes pipes, kMaxSections sections in all or
  /// kMaxSupports supports, a first pipe that is movable, a movable one that runs along x,
  /// deviations of a shape that are negative or above kMostHeightDeviation, kMostDirectionDeviation
  /// and the smallest radius over three, those of the first pipe, or a height of a pipe steeper
  /// than 45 degrees. Pipes may touch each other, and supports may touch or contain sections of
  /// pipes, as a saddle does.
  void validate() const;
};

/// Unit vector in the rack frame: y when at least two pipes run along it, to 1.1 degrees; otherwise
/// the direction that most pipes share, and of several such the one with the greatest length of
/// pipes. Pipes steeper than 30 degrees do not count; without others it is y. `model` must be
/// valid.
[[nodiscard]] Eigen::Vector3d main_direction(const RackModel& model);

/// What a pipe is found to differ by from the model, or the standard deviation of that.
struct PipeShape {
  double offset = 0;      ///< m, along rack x
  double height = 0;      ///< m, along rack z
  double turn_aside = 0;  ///< rad, of the axis about its middle: to the right, seen from above
  double turn_up = 0;     ///< rad, the same: upwards
  double radius = 0;      ///< m, of all its radii
};

/// The pipe with this shape.
[[nodiscard]] Pipe shaped(const Pipe& pipe, const PipeShape& shape);

/// One pipe of a row as in the paper: radius and gap to the previous one.
struct RowPipe {
  std::string name;
  std::vector<RadiusAt> radii;  ///< as in Pipe
  double gap = 0.1;             ///< d_i: between its surface and that of the previous pipe, m
};

/// The paper's rack: parallel pipes along y that rest on z = 0 at their widest section; the
/// left-most line of the first one is x = 0, and gaps are measured between largest radii. Throws
/// InvalidRack as RackModel::validate does for one pipe, and for gaps that are negative or not
/// finite; the gap of the first pipe is not used.
[[nodiscard]] std::vector<Pipe> row_of_pipes(std::span<const RowPipe> row);

/// Offsets of all pipes along rack x relative to the model (equation 24: d_bar, minus that of the
/// model). Entry i belongs to pipe i; that of the first pipe is 0. Empty: all 0.
using PipeOffsets = std::span<const double>;

/// The sections of one pipe, moved by its offset. Steps are not sections.
void append_sections(const Pipe& pipe, double offset, std::vector<PipeSection>& sections);

}  // namespace pipescout::rack_vision
