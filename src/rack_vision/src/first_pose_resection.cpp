// SPDX-License-Identifier: Apache-2.0
#include "first_pose_resection.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <stdexcept>

namespace pipescout::rack_vision::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

double cross(const Vector2d& a, const Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// A line of the pencil in the plane across the flow.
struct Bearing {
  Vector2d normal;   ///< x and z of the frame without roll, unit, x < 0
  double slope = 0;  ///< tangent of its angle against straight down; grows to the right
  double length = 0;
};

std::vector<Bearing> bearings_of(std::span<const PencilLine> lines, const geometry::SO3& R_nominal,
                                 std::size_t most) {
  std::vector<Bearing> bearings;
  for (const PencilLine& line : lines.first(std::min(lines.size(), most))) {
    const Vector3d turned = R_nominal.inverse() * line.normal;
    Vector2d normal = Vector2d(turned.x(), turned.z()).normalized();
    if (normal.x() > 0) {
      normal = -normal;
    }
    // Level bearings are not of something below the camera.
    if (normal.x() < -0.1) {
      bearings.push_back({normal, normal.y() / normal.x(), line.length});
    }
  }
  std::ranges::stable_sort(bearings, {}, &Bearing::slope);
  return bearings;
}

/// Length within the image of the line with the normal `normal` (camera frame), pixels.
double chord(const geometry::Camera& camera, const Vector3d& normal) {
  const Vector3d line = image_line_of_plane(camera, normal);
  const Vector2d along(-line.y(), line.x());
  const Vector2d foot = -line.z() * line.head<2>();
  const Vector2d size(camera.parameters().width - 1, camera.parameters().height - 1);
  double low = -1e9;
  double high = 1e9;
  for (int i = 0; i < 2; ++i) {
    if (std::abs(along(i)) < 1e-12) {
      if (foot(i) < 0 || foot(i) > size(i)) {
        return 0;
      }
      continue;
    }
    const double a = -foot(i) / along(i);
    const double b = (size(i) - foot(i)) / along(i);
    low = std::max(low, std::min(a, b));
    high = std::min(high, std::max(a, b));
  }
  return std::max(0.0, high - low);
}

/// What a contour at some slope would find, looked up instead of computed a million times.
class SlopeTable {
 public:
  struct Entry {
    double hit = 0;          ///< pixels of line
    double missing = 0;      ///< pixels of the image that the contour would cross without a line
    std::uint64_t line = 0;  ///< the line's bit, 0: none
  };

  SlopeTable(std::span<const PencilLine> lines, const geometry::SO3& R_nominal,
             const geometry::Camera& camera, double tolerance)
      : bins_per_slope_(camera.parameters().focal_length) {
    entries_.resize(2 * static_cast<std::size_t>(kWidest * bins_per_slope_) + 1);
    lengths_.resize(entries_.size() + 1);
    std::uint64_t bit = 1;
    for (const Bearing& bearing : bearings_of(lines, R_nominal, kMostLines)) {
      const double middle = position(bearing.slope);
      if (middle >= 0 && middle < static_cast<double>(entries_.size())) {
        lengths_[static_cast<std::size_t>(middle) + 1] += bearing.length;
      }
      const auto low = static_cast<std::ptrdiff_t>(std::ceil(middle - tolerance));
      const auto high = static_cast<std::ptrdiff_t>(std::floor(middle + tolerance));
      for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(low, 0);
           i <= high && i < std::ssize(entries_); ++i) {
        const double off = (static_cast<double>(i) - middle) / tolerance;
        const double hit = bearing.length * (1 - off * off);
        Entry& entry = entries_[static_cast<std::size_t>(i)];
        if (hit > entry.hit) {
          entry.hit = hit;
          entry.line = bit;
        }
      }
      bit <<= 1;
    }
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      const double slope = static_cast<double>(i) / bins_per_slope_ - kWidest;
      const double seen = chord(camera, R_nominal * Vector3d(-1, 0, -slope));
      entries_[i].hit = std::min(entries_[i].hit, seen);
      entries_[i].missing = seen - entries_[i].hit;
    }
    std::partial_sum(lengths_.begin(), lengths_.end(), lengths_.begin());
  }

  /// Pixels of lines between two slopes, without those within kMargin of them.
  [[nodiscard]] double between(double left, double right) const {
    const double most = static_cast<double>(entries_.size());
    const double low = std::clamp(position(left) + kMargin, 0.0, most);
    const double high = std::clamp(position(right) - kMargin, 0.0, most);
    // Written so that NaN is nothing too.
    return low < high
               ? lengths_[static_cast<std::size_t>(high)] - lengths_[static_cast<std::size_t>(low)]
               : 0.0;
  }

  [[nodiscard]] Entry operator()(double slope) const {
    const double at = position(slope) + 0.5;
    // Written so that NaN is out of range too.
    return at >= 0 && at < static_cast<double>(entries_.size())
               ? entries_[static_cast<std::size_t>(at)]
               : Entry{};
  }

 private:
  static constexpr double kMargin = 6;           // pixels: shading ends next to a contour
  static constexpr double kWidest = 2.5;         // 68 degrees off straight down
  static constexpr std::size_t kMostLines = 64;  // bits

  [[nodiscard]] double position(double slope) const { return (slope + kWidest) * bins_per_slope_; }

  double bins_per_slope_;
  std::vector<Entry> entries_;
  std::vector<double> lengths_;  ///< of lines, summed up to each entry
};

struct Tangent {
  const PipeCircle* circle;
  double side;       ///< t: 1 left, -1 right
  std::size_t rank;  ///< order from left to right
};

/// Pixels of lines on contours, less half of those that are missing: a hidden contour looks like a
/// missing one. Of the circles of one pipe the best counts. No line counts twice. Lines on a pipe
/// count against it: what runs along the flow on the ground is not seen through pipes.
double score(const SlopeTable& table, std::span<const PipeCircle> circles, const Resection& r) {
  constexpr double kMissing = 0.5;
  constexpr double kOnPipe = 0.5;
  const double cosine = std::cos(r.roll);
  const double sine = std::sin(r.roll);
  std::uint64_t used = 0;
  double sum = 0;
  for (std::size_t i = 0; i < circles.size();) {
    std::array<SlopeTable::Entry, 2> best;
    std::array<double, 2> best_value{};
    std::array<double, 2> slopes{};
    bool first = true;
    const std::size_t rank = circles[i].rank;
    for (; i < circles.size() && circles[i].rank == rank; ++i) {
      const PipeCircle& circle = circles[i];
      const Vector2d d = circle.centre - Vector2d(r.x, r.z);
      const double squared = d.squaredNorm() - circle.radius * circle.radius;
      if (squared <= 0) {
        return 0;
      }
      const Vector2d across = std::sqrt(squared) * Vector2d(d.y(), -d.x());
      for (std::size_t side = 0; side < 2; ++side) {
        const Vector2d n = across - (side == 0 ? 1.0 : -1.0) * circle.radius * d;
        const double slope = (cosine * n.y() - sine * n.x()) / (cosine * n.x() + sine * n.y());
        SlopeTable::Entry entry = table(slope);
        if ((entry.line & used) != 0) {
          entry = {.hit = 0, .missing = entry.hit + entry.missing, .line = 0};
        }
        const double value = entry.hit - kMissing * entry.missing;
        if (first || value > best_value[side]) {
          best[side] = entry;
          best_value[side] = value;
          slopes[side] = slope;
        }
      }
      first = false;
    }
    if (best[0].line == best[1].line && best[0].line != 0) {
      best_value[1] = -kMissing * (best[1].hit + best[1].missing);
    }
    used |= best[0].line | best[1].line;
    sum += best_value[0] + best_value[1] - kOnPipe * table.between(slopes[0], slopes[1]);
  }
  return sum;
}

bool within(const ResectionLimits& limits, const Resection& r) {
  return std::abs(r.roll) <= limits.largest_roll && r.x >= limits.x_low && r.x <= limits.x_high &&
         r.z >= limits.z_low && r.z <= limits.z_high;
}

/// Both solutions of the equation above for three bearings and the tangents that they are taken
/// for.
template <typename Accept>
void solve(const Bearing* const (&bearings)[3], const Tangent* const (&tangents)[3],
           const Accept& accept) {
  double a = 0;
  double b = 0;
  double c = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector2d& n = bearings[i]->normal;
    const double weight = cross(bearings[(i + 1) % 3]->normal, bearings[(i + 2) % 3]->normal);
    a += weight * n.dot(tangents[i]->circle->centre);
    b += weight * cross(n, tangents[i]->circle->centre);
    c -= weight * tangents[i]->side * tangents[i]->circle->radius;
  }
  const double amplitude = std::hypot(a, b);
  if (!(amplitude > 1e-12) || std::abs(c) > amplitude) {
    return;
  }
  const double middle = std::atan2(b, a);
  const double half = std::acos(c / amplitude);
  for (const double roll : {middle - half, middle + half}) {
    const double wrapped = std::remainder(roll, 2 * std::numbers::pi);
    const double cosine = std::cos(wrapped);
    const double sine = std::sin(wrapped);
    // The outer two bearings meet at the widest angle.
    Eigen::Matrix2d normals;
    Vector2d offsets;
    for (Eigen::Index row = 0; row < 2; ++row) {
      const auto i = static_cast<std::size_t>(2 * row);
      const Vector2d& n = bearings[i]->normal;
      normals.row(row) << cosine * n.x() - sine * n.y(), sine * n.x() + cosine * n.y();
      offsets(row) = normals.row(row).dot(tangents[i]->circle->centre) +
                     tangents[i]->side * tangents[i]->circle->radius;
    }
    const Vector2d place = normals.inverse() * offsets;
    accept(Resection{.x = place.x(), .z = place.y(), .roll = wrapped});
  }
}

/// Best first, without those that are nearly the same as a better one.
std::vector<Resection> distinct(std::vector<Resection> all, std::size_t most) {
  std::ranges::stable_sort(all, std::greater<>{}, &Resection::score);
  std::vector<Resection> kept;
  for (const Resection& r : all) {
    if (kept.size() == most) {
      break;
    }
    const bool known = std::ranges::any_of(kept, [&](const Resection& other) {
      return std::abs(other.x - r.x) < 0.12 && std::abs(other.z - r.z) < 0.12 &&
             std::abs(other.roll - r.roll) < 0.05;
    });
    if (!known) {
      kept.push_back(r);
    }
  }
  return kept;
}

}  // namespace

std::vector<PipeCircle> pipe_circles(const RackOutline& rack) {
  std::vector<PipeCircle> circles;
  std::vector<std::size_t> pipes;
  for (std::size_t i = 0; i < rack.sections.size(); ++i) {
    if (rack.along_flow[i]) {
      pipes.push_back(i);
    }
  }
  std::ranges::stable_sort(pipes, {}, [&](std::size_t i) { return rack.sections[i][0].start.x(); });
  for (std::size_t rank = 0; rank < pipes.size(); ++rank) {
    const std::size_t first = circles.size();
    for (const PipeSection& section : rack.sections[pipes[rank]]) {
      const Vector3d middle = section.start + 0.5 * section.length * section.direction;
      const PipeCircle circle{.centre = {middle.x(), middle.z()},
                              .radius = 0.5 * (section.radius_start + section.radius_end),
                              .rank = rank};
      const bool known = std::any_of(
          circles.begin() + static_cast<std::ptrdiff_t>(first), circles.end(),
          [&](const PipeCircle& other) { return std::abs(other.radius - circle.radius) < 2e-3; });
      if (!known) {
        circles.push_back(circle);
      }
    }
  }
  if (pipes.size() < 2) {
    throw std::invalid_argument(
        "FirstPoseFinder: the rack has fewer than two pipes along y: nothing to start from");
  }
  return circles;
}

geometry::SO3 nominal_rotation(const Vector3d& flow) {
  const Vector3d up = (-Vector3d::UnitZ() + flow.z() * flow).normalized();
  Eigen::Matrix3d r;
  r << flow.cross(up), flow, up;
  return geometry::SO3::from_matrix(r);
}

std::vector<Resection> resections(std::span<const PencilLine> lines, const geometry::SO3& R_nominal,
                                  std::span<const PipeCircle> circles,
                                  const geometry::Camera& camera, const ResectionLimits& limits,
                                  double tolerance, std::size_t most_lines, std::size_t most) {
  constexpr std::size_t kMostKept = 4096;
  constexpr double kMostOnPipe = 0.6;  // of the length of its contours
  constexpr double kFarthest = 2;      // 60 degrees off straight down
  const std::vector<Bearing> bearings = bearings_of(lines, R_nominal, most_lines);
  std::vector<Tangent> tangents;
  for (const PipeCircle& circle : circles) {
    tangents.push_back({&circle, 1.0, 2 * circle.rank});
    tangents.push_back({&circle, -1.0, 2 * circle.rank + 1});
  }
  const SlopeTable table(lines, R_nominal, camera, tolerance);
  std::vector<Resection> found;
  double worst_kept = 0;
  const auto accept = [&](Resection r) {
    if (!within(limits, r)) {
      return;
    }
    r.score = score(table, circles, r);
    if (r.score <= worst_kept) {
      return;
    }
    found.push_back(r);
    if (found.size() == 2 * kMostKept) {
      std::ranges::nth_element(found, found.begin() + kMostKept, std::greater<>{},
                               &Resection::score);
      worst_kept = found[kMostKept].score;
      found.resize(kMostKept);
    }
  };
  const auto try_third = [&](std::size_t left, std::size_t right, const Tangent& left_tangent,
                             const Tangent& right_tangent) {
    for (std::size_t k = 0; k < bearings.size(); ++k) {
      for (const Tangent& third : tangents) {
        if (k < left && third.rank < left_tangent.rank) {
          solve({&bearings[k], &bearings[left], &bearings[right]},
                {&third, &left_tangent, &right_tangent}, accept);
        } else if (k > right && third.rank > right_tangent.rank) {
          solve({&bearings[left], &bearings[right], &bearings[k]},
                {&left_tangent, &right_tangent, &third}, accept);
        }
      }
    }
  };
  for (std::size_t i = 0; i < bearings.size(); ++i) {
    for (std::size_t j = i + 1; j < bearings.size(); ++j) {
      if (table.between(bearings[i].slope, bearings[j].slope) >
          kMostOnPipe * (bearings[i].length + bearings[j].length)) {
        continue;
      }
      const double width = std::atan(bearings[j].slope) - std::atan(bearings[i].slope);
      for (std::size_t k = 0; k < tangents.size(); k += 2) {
        // The angle that a circle is wide says how far it is.
        const PipeCircle& circle = *tangents[k].circle;
        const double distance = circle.radius / std::sin(0.5 * width);
        if (distance > limits.z_low - circle.centre.y() &&
            distance < kFarthest * (limits.z_high - circle.centre.y())) {
          try_third(i, j, tangents[k], tangents[k + 1]);
        }
      }
    }
  }
  return distinct(std::move(found), most);
}

}  // namespace pipescout::rack_vision::internal
