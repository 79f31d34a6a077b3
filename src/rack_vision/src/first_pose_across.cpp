// SPDX-License-Identifier: Apache-2.0
#include "first_pose_across.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "pipescout/rack_vision/rack_model.hpp"

namespace pipescout::rack_vision::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::array<std::size_t, LineProfile::kReach.size()> kKept{4000, 3000, 2000, 1000};
// Steps of the first grid: about twice the profile's first reach for the
// outermost contours.
constexpr double kAcrossStep = 16;     // pixels
constexpr double kHeightStep = 0.028;  // of the height
constexpr double kRollStep = 0.05;     // rad
constexpr double kNeighbours = 6;      // pixels
constexpr double kAlike = 4;           // pixels
constexpr double kLeastPrior = -8;     // nats

/// The tangents of one pipe, as slopes of a camera without roll.
struct Tangents {
  double left = 0, right = 0;
  bool left_seen = false, right_seen = false;
  double squared_distance = 0;
};

/// The rack as one place above it sees it, whatever the roll.
class AcrossView {
 public:
  explicit AcrossView(std::span<const PipeCircle> circles) : circles_(circles) {}

  /// False from within a pipe, and when one is not below.
  bool look(double x, double z) {
    count_ = 0;
    for (const PipeCircle& circle : circles_) {
      const Vector2d d = circle.centre - Vector2d(x, z);
      const double squared = d.squaredNorm();
      const double tangent = squared - circle.radius * circle.radius;
      if (!(tangent > 0) || !(d.y() < 0)) {
        return false;
      }
      // Normals of the tangents; their slope is that of the ray at right
      // angles.
      const Vector2d across = std::sqrt(tangent) * Vector2d(d.y(), -d.x());
      const Vector2d left = across - circle.radius * d;
      const Vector2d right = across + circle.radius * d;
      tangents_[count_++] = {left.y() / left.x(), right.y() / right.x(), left.x() < 0,
                             right.x() < 0, squared};
    }
    for (std::size_t i = 0; i < count_; ++i) {
      for (std::size_t k = 0; k < count_; ++k) {
        if (circles_[i].rank != circles_[k].rank &&
            tangents_[k].squared_distance < tangents_[i].squared_distance) {
          hide(tangents_[i].left, tangents_[k], tangents_[i].left_seen);
          hide(tangents_[i].right, tangents_[k], tangents_[i].right_seen);
        }
      }
    }
    return true;
  }

  /// Nats: of the sections of one pipe the best counts. `roll`: tangent of it.
  [[nodiscard]] double value(const LineProfile& profile, double roll, std::size_t level) const {
    return best_of_pipes(roll, [&](const Tangents& t, double left, double right) {
      const double contours =
          (t.left_seen ? static_cast<double>(profile.evidence(left, level)) : 0.0) +
          (t.right_seen ? static_cast<double>(profile.evidence(right, level)) : 0.0);
      return contours + (level > 0 ? profile.evidence_on_pipe(left, right) : 0.0);
    });
  }
  [[nodiscard]] double on_pipes(const LineProfile& profile, double roll) const {
    return best_of_pipes(roll, [&](const Tangents&, double left, double right) {
      return profile.evidence_on_pipe(left, right);
    });
  }

 private:
  template <typename Value>
  [[nodiscard]] double best_of_pipes(double roll, const Value& value_of) const {
    constexpr double kSmallestCosine = 0.2;  // relative: beyond, nothing is seen
    double sum = 0;
    for (std::size_t i = 0; i < count_;) {
      const std::size_t rank = circles_[i].rank;
      const std::size_t first = i;
      double best = 0;
      for (; i < count_ && circles_[i].rank == rank; ++i) {
        const Tangents& t = tangents_[i];
        const double left = 1 + t.left * roll;
        const double right = 1 + t.right * roll;
        const bool seen = left > kSmallestCosine && right > kSmallestCosine;
        const double value =
            seen ? value_of(t, (t.left - roll) / left, (t.right - roll) / right) : 0;
        best = i == first ? value : std::max(best, value);
      }
      sum += best;
    }
    return sum;
  }
  static void hide(double bearing, const Tangents& in_front, bool& seen) {
    seen = seen && !(bearing > in_front.left && bearing < in_front.right);
  }

  std::span<const PipeCircle> circles_;
  std::array<Tangents, kMaxSections> tangents_{};
  std::size_t count_ = 0;
};

struct Cell {
  AcrossPose pose{};
  double x_step = 0, z_step = 0, roll_step = 0;
  std::array<int, 3> neighbourhood{};
};

void keep_best(std::vector<Cell>& cells, std::size_t most) {
  const auto better = [](const Cell& a, const Cell& b) { return a.pose.value > b.pose.value; };
  if (cells.size() > most) {
    std::ranges::nth_element(cells, cells.begin() + static_cast<std::ptrdiff_t>(most), better);
    cells.resize(most);
  }
}

/// The best of each neighbourhood: a broad maximum shall not crowd out the
/// others.
void keep_best_of_each(std::vector<Cell>& cells, double floor, double focal_length) {
  constexpr double kHeights = 0.03;  // relative
  for (Cell& cell : cells) {
    const AcrossPose& pose = cell.pose;
    const double height = pose.z - floor;
    cell.neighbourhood = {
        static_cast<int>(std::lround((pose.x / height + pose.roll) * focal_length / kNeighbours)),
        static_cast<int>(std::lround(std::log(height) / kHeights)),
        static_cast<int>(std::lround(pose.roll / kRollStep))};
  }
  std::ranges::sort(cells, [](const Cell& a, const Cell& b) {
    return a.neighbourhood != b.neighbourhood ? a.neighbourhood < b.neighbourhood
                                              : a.pose.value > b.pose.value;
  });
  const auto rest = std::ranges::unique(cells, {}, &Cell::neighbourhood);
  cells.erase(rest.begin(), rest.end());
}

/// Bearings that two poses give to what is below move apart by less than about
/// `pixels`.
bool alike(const AcrossPose& a, const AcrossPose& b, double floor, double pixels) {
  const double height = a.z - floor;
  return std::abs((b.x - a.x) / height + (b.roll - a.roll)) < pixels &&
         std::abs(b.z - a.z) / height < 2 * pixels && std::abs(b.roll - a.roll) < 8 * pixels;
}

}  // namespace

double evidence_on_pipes(const LineProfile& profile, std::span<const PipeCircle> circles,
                         const AcrossPose& pose) {
  AcrossView view(circles);
  return view.look(pose.x, pose.z) ? view.on_pipes(profile, std::tan(pose.roll)) : 0;
}

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
        "FirstPoseFinder: the rack has fewer than two pipes along its main direction: "
        "initialisation "
        "from an image alone is impossible; give a pose");
  }
  return circles;
}

geometry::SO3 nominal_rotation(const Vector3d& flow) {
  const Vector3d up = (-Vector3d::UnitZ() + flow.z() * flow).normalized();
  Eigen::Matrix3d r;
  r << flow.cross(up), flow, up;
  return geometry::SO3::from_matrix(r);
}

double log_prior(const std::optional<FirstPoseHint::Value>& hint, double value) {
  const double off = hint ? (value - hint->value) / hint->standard_deviation : 0;
  return -0.5 * off * off;
}

std::vector<AcrossPose> search_across(const LineProfile& profile,
                                      std::span<const PipeCircle> circles,
                                      const geometry::Camera& camera, const AcrossLimits& limits,
                                      const FirstPoseHint& hint, std::size_t most) {
  AcrossView view(circles);
  const auto prior = [&](double x, double z) {
    return log_prior(hint.x, x) + log_prior(hint.z, z);
  };
  const auto roll_prior = [&limits](double roll) {
    return -0.5 * roll * roll / (limits.typical_roll * limits.typical_roll);
  };
  double floor = circles.front().centre.y();
  for (const PipeCircle& circle : circles) {
    floor = std::max(floor, circle.centre.y());
  }
  std::vector<Cell> cells;
  double worst = 0;  // of those that are kept
  const auto rolls = static_cast<int>(limits.largest_roll / kRollStep);
  for (double z = limits.z_low; z <= limits.z_high;) {
    const double z_step = kHeightStep * (z - floor);
    const double x_step = kAcrossStep / camera.parameters().focal_length * (z - floor);
    for (double x = limits.x_low; x <= limits.x_high; x += x_step) {
      const double likely = prior(x, z);
      if (likely < kLeastPrior || !view.look(x, z)) {
        continue;
      }
      for (int i = -rolls; i <= rolls; ++i) {
        const double roll = i * kRollStep;
        const double value = view.value(profile, std::tan(roll), 0) + likely + roll_prior(roll);
        if (value > worst) {
          cells.push_back({{x, z, roll, value}, x_step, z_step, kRollStep, {}});
        }
      }
    }
    z += z_step;
    if (cells.size() > 4 * kKept[0]) {
      keep_best(cells, kKept[0]);
      worst = std::ranges::min(cells, {}, [](const Cell& c) { return c.pose.value; }).pose.value;
    }
  }
  keep_best(cells, kKept[0]);
  for (std::size_t level = 1; level < LineProfile::kReach.size(); ++level) {
    std::vector<Cell> divided;
    divided.reserve(8 * cells.size());
    for (const Cell& cell : cells) {
      for (const double dz : {-0.25, 0.25}) {
        for (const double dx : {-0.25, 0.25}) {
          const double x = cell.pose.x + dx * cell.x_step;
          const double z = cell.pose.z + dz * cell.z_step;
          if (!view.look(x, z)) {
            continue;
          }
          for (const double droll : {-0.25, 0.25}) {
            const double roll = cell.pose.roll + droll * cell.roll_step;
            divided.push_back(
                {{x, z, roll,
                  view.value(profile, std::tan(roll), level) + prior(x, z) + roll_prior(roll)},
                 0.5 * cell.x_step,
                 0.5 * cell.z_step,
                 0.5 * cell.roll_step,
                 {}});
          }
        }
      }
    }
    cells = std::move(divided);
    keep_best_of_each(cells, floor, camera.parameters().focal_length);
    keep_best(cells, kKept[level]);
  }
  std::ranges::stable_sort(cells, std::greater<>{}, [](const Cell& c) { return c.pose.value; });
  std::vector<AcrossPose> kept;
  for (const Cell& cell : cells) {
    const bool known = std::ranges::any_of(kept, [&](const AcrossPose& other) {
      return alike(other, cell.pose, floor, kAlike / camera.parameters().focal_length);
    });
    if (!known) {
      kept.push_back(cell.pose);
    }
    if (kept.size() == most) {
      break;
    }
  }
  return kept;
}

}  // namespace pipescout::rack_vision::internal
