// SPDX-License-Identifier: Apache-2.0
#include "section_overlap.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>

namespace pipescout::rack_vision {
namespace {

using Eigen::Vector3d;

/// Bodies are made smaller by this (m) on all sides, so that those that touch are apart.
constexpr double kSkin = 1e-6;

PipeSection shrunk(PipeSection section) {
  section.start += kSkin * section.direction;
  section.length -= 2 * kSkin;
  section.radius_start -= kSkin;
  section.radius_end -= kSkin;
  return section;
}

/// The point of the section that is farthest along `d`.
Vector3d farthest(const PipeSection& section, const Vector3d& d) {
  const double along = section.direction.dot(d);
  const Vector3d across = d - along * section.direction;
  const double norm = across.norm();
  const Vector3d radial = norm > 0 ? Vector3d(across / norm) : Vector3d::Zero();
  const double at_start = section.radius_start * norm;
  const double at_end = section.length * along + section.radius_end * norm;
  return at_start >= at_end ? Vector3d(section.start + section.radius_start * radial)
                            : Vector3d(section.start + section.length * section.direction +
                                       section.radius_end * radial);
}

/// Up to four points with their weights in a convex combination.
struct Simplex {
  std::array<Vector3d, 4> points;
  std::array<double, 4> weights{};
  int size = 0;

  [[nodiscard]] Vector3d combination() const {
    Vector3d sum = Vector3d::Zero();
    for (int i = 0; i < size; ++i) {
      sum += weights[static_cast<std::size_t>(i)] * points[static_cast<std::size_t>(i)];
    }
    return sum;
  }
  void remove(int index) {
    --size;
    std::swap(points[static_cast<std::size_t>(index)], points[static_cast<std::size_t>(size)]);
    std::swap(weights[static_cast<std::size_t>(index)], weights[static_cast<std::size_t>(size)]);
  }
  /// Weights (their sum is 1) of the point nearest to 0 in the affine hull. False when the points
  /// are not affinely independent.
  bool affine_minimum(std::array<double, 4>& result) const {
    Eigen::Matrix<double, 5, 5> system = Eigen::Matrix<double, 5, 5>::Identity();
    Eigen::Matrix<double, 5, 1> right = Eigen::Matrix<double, 5, 1>::Zero();
    for (int i = 0; i < size; ++i) {
      for (int j = 0; j < size; ++j) {
        system(i, j) = points[static_cast<std::size_t>(i)].dot(points[static_cast<std::size_t>(j)]);
      }
      system(i, 4) = system(4, i) = 1;
    }
    system(4, 4) = 0;
    right(4) = 1;
    const Eigen::FullPivLU<Eigen::Matrix<double, 5, 5>> lu(system);
    if (!lu.isInvertible()) {
      return false;
    }
    const Eigen::Matrix<double, 5, 1> solution = lu.solve(right);
    for (int i = 0; i < size; ++i) {
      result[static_cast<std::size_t>(i)] = solution(i);
    }
    return solution.allFinite();
  }
};

/// Moves the weights to the point of the simplex nearest to 0, and drops the points that it does
/// not need: the inner loop of Wolfe, "Finding the nearest point in a polytope", 1976.
void minimise(Simplex& simplex) {
  while (simplex.size > 1) {
    std::array<double, 4> target{};
    if (!simplex.affine_minimum(target)) {
      const auto end = simplex.weights.begin() + simplex.size;
      simplex.remove(static_cast<int>(std::min_element(simplex.weights.begin(), end) -
                                      simplex.weights.begin()));
      double sum = 0;
      for (int i = 0; i < simplex.size; ++i) {
        sum += simplex.weights[static_cast<std::size_t>(i)];
      }
      for (int i = 0; i < simplex.size; ++i) {
        simplex.weights[static_cast<std::size_t>(i)] /= sum;
      }
      continue;
    }
    double step = 1;
    int leaving = -1;
    for (int i = 0; i < simplex.size; ++i) {
      const double from = simplex.weights[static_cast<std::size_t>(i)];
      const double to = target[static_cast<std::size_t>(i)];
      if (to <= 0 && from - to > 0 && from / (from - to) < step) {
        step = from / (from - to);
        leaving = i;
      }
    }
    for (int i = 0; i < simplex.size; ++i) {
      double& weight = simplex.weights[static_cast<std::size_t>(i)];
      weight += step * (target[static_cast<std::size_t>(i)] - weight);
    }
    if (leaving < 0) {
      return;
    }
    simplex.remove(leaving);
  }
  simplex.weights[0] = 1;
}

}  // namespace

bool sections_overlap(const PipeSection& first, const PipeSection& second) {
  const PipeSection a = shrunk(first);
  const PipeSection b = shrunk(second);
  if (a.length <= 0 || b.length <= 0 || std::min(a.radius_start, a.radius_end) <= 0 ||
      std::min(b.radius_start, b.radius_end) <= 0) {
    return false;
  }
  // Distance of 0 from the set of all differences of a point of `a` and one of `b`, by its nearest
  // point `v`; they are apart as soon as the plane at right angles to `v` shows it.
  Simplex simplex;
  Vector3d v = a.start - b.start;
  constexpr int kMostSteps = 1000;
  constexpr double kSame = 1e-9;  // m
  for (int step = 0; step < kMostSteps; ++step) {
    const Vector3d w = farthest(a, -v) - farthest(b, v);
    if (v.dot(w) > 0) {
      return false;
    }
    auto& next = simplex.points[static_cast<std::size_t>(simplex.size)];
    next = w;
    simplex.weights[static_cast<std::size_t>(simplex.size)] = simplex.size == 0 ? 1 : 0;
    ++simplex.size;
    minimise(simplex);
    v = simplex.combination();
    if (v.norm() < kSame || simplex.size == 4) {
      return true;  // 0 is within the simplex
    }
  }
  return true;  // so near to touching that no plane was found: within the skin
}

}  // namespace pipescout::rack_vision
