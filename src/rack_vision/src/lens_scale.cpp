// SPDX-License-Identifier: Apache-2.0
#include "lens_scale.hpp"

#include <Eigen/LU>
#include <cmath>
#include <optional>

namespace pipescout::rack_vision {

double ideal_per_pixel(const geometry::Camera& camera, const Eigen::Vector2d& ideal,
                       const Eigen::Vector2d& direction) {
  if (!camera.has_distortion()) {
    return 1;
  }
  const std::optional<Eigen::Vector2d> seen = camera.distort(ideal);
  const std::optional<Eigen::Vector2d> beside = camera.distort(ideal + direction);
  return seen && beside ? 1 / (*beside - *seen).norm() : 1.0;
}

double ideal_per_pixel(const geometry::Camera& camera, const Eigen::Vector2d& ideal) {
  if (!camera.has_distortion()) {
    return 1;
  }
  const std::optional<Eigen::Vector2d> seen = camera.distort(ideal);
  const std::optional<Eigen::Vector2d> right = camera.distort(ideal + Eigen::Vector2d::UnitX());
  const std::optional<Eigen::Vector2d> below = camera.distort(ideal + Eigen::Vector2d::UnitY());
  if (!seen || !right || !below) {
    return 1;
  }
  Eigen::Matrix2d seen_by_ideal;
  seen_by_ideal << *right - *seen, *below - *seen;
  return 1 / std::sqrt(std::abs(seen_by_ideal.determinant()));
}

}  // namespace pipescout::rack_vision
