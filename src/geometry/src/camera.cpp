// SPDX-License-Identifier: Apache-2.0
#include "pipescout/geometry/camera.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "lens.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::geometry {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

/// Nearer points than this (m) are not in front of the camera.
constexpr double kNearestDepth = 1e-6;

}  // namespace

std::string_view to_string(LensModel lens) noexcept {
  switch (lens) {
    case LensModel::kBrown:
      return "brown";
    case LensModel::kEquidistant:
      return "equidistant";
  }
  return "unknown";
}

void CameraParameters::validate() const {
  const auto require = [](const char* field, double value, bool in_range, const char* range) {
    validation::require({"CameraParameters.", field}, value, in_range, range);
  };
  require("width", width, width >= 1, "[1, inf)");
  require("height", height, height >= 1, "[1, inf)");
  require("focal_length", focal_length, focal_length > 0, "(0, inf)");
  require("aspect_ratio", aspect_ratio, aspect_ratio > 0, "(0, inf)");
  require("skew", skew, true, "(-inf, inf)");
  require("centre_u", centre_u, true, "(-inf, inf)");
  require("centre_v", centre_v, true, "(-inf, inf)");
  require("k1", k1, true, "(-inf, inf)");
  require("k2", k2, true, "(-inf, inf)");
  require("k3", k3, true, "(-inf, inf)");
  require("k4", k4, true, "(-inf, inf)");
  const bool equidistant = lens == LensModel::kEquidistant;
  const char* const unused = equidistant ? "0 with the equidistant lens" : "(-inf, inf)";
  require("p1", p1, !equidistant || p1 == 0, unused);
  require("p2", p2, !equidistant || p2 == 0, unused);
  require("k5", k5, !equidistant || k5 == 0, unused);
  require("k6", k6, !equidistant || k6 == 0, unused);
  const Camera camera(*this, Camera::Unchecked{});
  // With a margin for rounding.
  if (equidistant && camera.largest_radius() > 0.999 * std::tan(kWidestEquidistantAngle)) {
    return;  // the image may show more than the model is used for
  }
  for (const double u : {0.0, width - 1.0}) {
    for (const double v : {0.0, height - 1.0}) {
      if (!camera.ray({u, v})) {
        throw std::invalid_argument(
            "CameraParameters.k1 to k6, p1, p2: the distortion cannot be inverted in the corner of "
            "the image");
      }
    }
  }
}

Camera::Camera(const CameraParameters& parameters) : Camera(parameters, Unchecked{}) {
  parameters.validate();
}

Camera::Camera(const CameraParameters& parameters, Unchecked /*unchecked*/)
    : parameters_(parameters) {
  const CameraParameters& c = parameters_;
  matrix_ << c.focal_length, c.skew, c.centre_u, 0, c.aspect_ratio * c.focal_length, c.centre_v, 0,
      0, 1;
  const double f_u = c.focal_length;
  const double f_v = c.aspect_ratio * c.focal_length;
  inverse_matrix_ << 1 / f_u, -c.skew / (f_u * f_v), (c.skew * c.centre_v / f_v - c.centre_u) / f_u,
      0, 1 / f_v, -c.centre_v / f_v, 0, 0, 1;
  has_distortion_ = c.lens == LensModel::kEquidistant || c.k1 != 0 || c.k2 != 0 || c.k3 != 0 ||
                    c.p1 != 0 || c.p2 != 0 || c.k4 != 0 || c.k5 != 0 || c.k6 != 0;
  largest_squared_radius_ =
      has_distortion_ ? largest_squared_radius(c) : std::numeric_limits<double>::max();
}

double Camera::largest_radius() const noexcept {
  return std::sqrt(largest_squared_radius_);
}

std::optional<Vector2d> Camera::plane_point(const Eigen::Vector3d& point) const noexcept {
  const Vector2d plane = point.head<2>() / point.z();
  // Written so that NaN fails too.
  if (!(point.z() > kNearestDepth && plane.squaredNorm() <= largest_squared_radius_)) {
    return std::nullopt;
  }
  return plane;
}

std::optional<Vector2d> Camera::project(const Eigen::Vector3d& point) const noexcept {
  const std::optional<Vector2d> plane = plane_point(point);
  if (!plane) {
    return std::nullopt;
  }
  return to_pixel(has_distortion_ ? distort_plane(parameters_, *plane, nullptr) : *plane);
}

std::optional<Vector2d> Camera::project(const Eigen::Vector3d& point,
                                        Matrix23d& derivative) const noexcept {
  const std::optional<Vector2d> plane = plane_point(point);
  if (!plane) {
    return std::nullopt;
  }
  const double inverse_depth = 1 / point.z();
  Matrix23d to_plane;
  to_plane << inverse_depth, 0, -plane->x() * inverse_depth, 0, inverse_depth,
      -plane->y() * inverse_depth;
  if (!has_distortion_) {
    derivative = matrix_.topLeftCorner<2, 2>() * to_plane;
    return to_pixel(*plane);
  }
  Matrix2d distortion;
  const Vector2d seen = distort_plane(parameters_, *plane, &distortion);
  derivative = matrix_.topLeftCorner<2, 2>() * distortion * to_plane;
  return to_pixel(seen);
}

Matrix23d Camera::derivative_to_intrinsics(const Vector2d& pixel) const noexcept {
  const double y = (pixel.y() - parameters_.centre_v) / matrix_(1, 1);
  const double x = (pixel.x() - parameters_.centre_u - parameters_.skew * y) / matrix_(0, 0);
  return (Matrix23d() << x, 1, 0, parameters_.aspect_ratio * y, 0, 1).finished();
}

std::optional<Eigen::Vector3d> Camera::ray(const Vector2d& pixel) const noexcept {
  if (!pixel.allFinite()) {
    return std::nullopt;
  }
  const Vector2d seen =
      inverse_matrix_.topLeftCorner<2, 2>() * pixel + inverse_matrix_.topRightCorner<2, 1>();
  if (!has_distortion_) {
    return Eigen::Vector3d(seen.x(), seen.y(), 1);
  }
  const std::optional<Vector2d> plane = undistort_plane(parameters_, seen, largest_squared_radius_);
  if (!plane) {
    return std::nullopt;
  }
  return Eigen::Vector3d(plane->x(), plane->y(), 1);
}

Vector2d Camera::to_pixel(const Vector2d& plane) const noexcept {
  return matrix_.topLeftCorner<2, 2>() * plane + matrix_.topRightCorner<2, 1>();
}

std::optional<Vector2d> Camera::undistort(const Vector2d& pixel) const noexcept {
  const std::optional<Eigen::Vector3d> r = ray(pixel);
  if (!r) {
    return std::nullopt;
  }
  if (!has_distortion_) {
    return pixel;
  }
  return Vector2d((matrix_ * *r).head<2>());
}

std::optional<Vector2d> Camera::distort(const Vector2d& ideal_pixel) const noexcept {
  if (!has_distortion_ && ideal_pixel.allFinite()) {
    return ideal_pixel;
  }
  return project(inverse_matrix_ * ideal_pixel.homogeneous());
}

bool Camera::contains(const Vector2d& pixel, double margin) const noexcept {
  return pixel.x() >= margin && pixel.y() >= margin &&
         pixel.x() <= parameters_.width - 1 - margin &&
         pixel.y() <= parameters_.height - 1 - margin;
}

}  // namespace pipescout::geometry
