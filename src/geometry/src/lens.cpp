// SPDX-License-Identifier: Apache-2.0
#include "lens.hpp"

#include <Eigen/LU>
#include <cmath>

namespace pipescout::geometry {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

/// Where the radial distortion rises by less than this, it is about to turn back.
constexpr double kLeastSlope = 0.05;

struct ValueAndSlope {
  double value = 0;
  double slope = 0;
};

/// The radial factor and its derivative with respect to the squared radius: a quotient of
/// polynomials, whose denominator is 1 for plumb_bob.
ValueAndSlope rational_factor(const CameraParameters& c, double q) {
  const double over = 1 + q * (c.k1 + q * (c.k2 + q * c.k3));
  const double over_slope = c.k1 + q * (2 * c.k2 + q * 3 * c.k3);
  const double under = 1 + q * (c.k4 + q * (c.k5 + q * c.k6));
  const double under_slope = c.k4 + q * (2 * c.k5 + q * 3 * c.k6);
  return {over / under, (over_slope * under - over * under_slope) / (under * under)};
}

/// theta_d and its derivative with respect to theta.
ValueAndSlope equidistant_angle(const CameraParameters& c, double theta) {
  const double t = theta * theta;
  return {theta * (1 + t * (c.k1 + t * (c.k2 + t * (c.k3 + t * c.k4)))),
          1 + t * (3 * c.k1 + t * (5 * c.k2 + t * (7 * c.k3 + t * 9 * c.k4)))};
}

/// theta_d / r and its derivative with respect to r^2.
ValueAndSlope equidistant_factor(const CameraParameters& c, double q) {
  // Below, the terms of higher order are less than rounding.
  constexpr double kNearAxis = 1e-8;
  if (q < kNearAxis) {
    const double slope = c.k1 - 1.0 / 3;
    return {1 + q * slope, slope};
  }
  const double r = std::sqrt(q);
  const ValueAndSlope angle = equidistant_angle(c, std::atan(r));
  return {angle.value / r, (angle.slope / (1 + q) - angle.value / r) / (2 * q)};
}

bool is_equidistant(const CameraParameters& c) {
  return c.lens == LensModel::kEquidistant;
}

bool is_rational(const CameraParameters& c) {
  return !is_equidistant(c) && (c.k4 != 0 || c.k5 != 0 || c.k6 != 0);
}

/// Slope of the distorted radius over the radius, or for an equidistant lens over the angle.
double radial_slope(const CameraParameters& c, double q) {
  if (is_equidistant(c)) {
    return equidistant_angle(c, std::atan(std::sqrt(q))).slope;
  }
  const ValueAndSlope factor = rational_factor(c, q);
  return factor.value + 2 * q * factor.slope;
}

/// The argument in [0, largest] at which a rising function has this value: Newton's method, with
/// bisection where it leaves the bracket. Nothing beyond the value at `largest`.
template <class Function>
std::optional<double> invert(const Function& function, double value, double largest) {
  constexpr int kMostSteps = 100;
  constexpr double kRounding = 1e-15;
  if (!(value <= function(largest).value)) {
    return std::nullopt;
  }
  double low = 0;
  double high = largest;
  double x = std::min(value, largest);
  for (int i = 0; i < kMostSteps; ++i) {
    const ValueAndSlope at = function(x);
    double next = x - (at.value - value) / at.slope;
    if (std::abs(next - x) <= kRounding * largest) {
      return next;
    }
    (at.value < value ? low : high) = x;
    if (!(next > low && next < high)) {
      next = low + (high - low) / 2;
    }
    x = next;
  }
  return x;
}

/// Newton's method from `p`, kept within the limit; nothing when it does not converge there.
std::optional<Vector2d> refine(const CameraParameters& c, Vector2d p, const Vector2d& distorted,
                               double squared_limit) {
  constexpr double kConverged = 1e-14;  // on the plane z = 1: 1e-11 pixels
  constexpr double kAccepted = 1e-10;   // rounding may keep wide angles from the former
  double error = 0;
  for (int i = 0; i < 20; ++i) {
    Matrix2d derivative;
    const Vector2d difference = distort_plane(c, p, &derivative) - distorted;
    error = difference.norm();
    if (error < kConverged) {
      break;
    }
    p -= derivative.inverse() * difference;
    const double squared_radius = p.squaredNorm();
    if (squared_radius > squared_limit) {
      p *= std::sqrt(squared_limit / squared_radius);
    }
  }
  // Written so that NaN fails too.
  if (!(error <= kAccepted)) {
    return std::nullopt;
  }
  return p;
}

}  // namespace

double largest_squared_radius(const CameraParameters& camera) {
  constexpr double kWidest = 9;  // 71 degrees off the axis: beyond any lens of the Brown model
  constexpr int kSteps = 3600;
  const double tangent = std::tan(kWidestEquidistantAngle);
  const double widest = is_equidistant(camera) ? tangent * tangent : kWidest;
  for (int i = 1; i <= kSteps; ++i) {
    const double q = widest * i / kSteps;
    const bool valid = is_equidistant(camera) ||
                       1 + q * (camera.k4 + q * (camera.k5 + q * camera.k6)) > kLeastSlope;
    // Written so that NaN fails too.
    if (!(valid && radial_slope(camera, q) > kLeastSlope)) {
      return widest * (i - 1) / kSteps;
    }
  }
  return widest;
}

Vector2d distort_plane(const CameraParameters& camera, const Vector2d& point,
                       Matrix2d* derivative) {
  const CameraParameters& c = camera;
  const double x = point.x();
  const double y = point.y();
  const double q = x * x + y * y;
  if (is_equidistant(c)) {
    const ValueAndSlope factor = equidistant_factor(c, q);
    if (derivative != nullptr) {
      *derivative =
          factor.value * Matrix2d::Identity() + 2 * factor.slope * point * point.transpose();
    }
    return factor.value * point;
  }
  const ValueAndSlope factor = rational_factor(c, q);
  const double radial = factor.value;
  if (derivative != nullptr) {
    const double slope = factor.slope;
    const double across = 2 * x * y * slope + 2 * c.p1 * x + 2 * c.p2 * y;
    *derivative << radial + 2 * x * x * slope + 2 * c.p1 * y + 6 * c.p2 * x, across, across,
        radial + 2 * y * y * slope + 6 * c.p1 * y + 2 * c.p2 * x;
  }
  return {x * radial + 2 * c.p1 * x * y + c.p2 * (q + 2 * x * x),
          y * radial + c.p1 * (q + 2 * y * y) + 2 * c.p2 * x * y};
}

std::optional<Vector2d> undistort_plane(const CameraParameters& camera, const Vector2d& distorted,
                                        double squared_limit) {
  if (is_equidistant(camera)) {
    const double radius = distorted.norm();
    const auto theta = invert([&](double angle) { return equidistant_angle(camera, angle); },
                              radius, std::atan(std::sqrt(squared_limit)));
    if (!theta) {
      return std::nullopt;
    }
    return Vector2d(radius > 0 ? std::tan(*theta) / radius * distorted : distorted);
  }
  if (!is_rational(camera)) {
    return refine(camera, distorted, distorted, squared_limit);
  }
  // Wide lenses are too far from linear to begin at the distorted point: without the tangential
  // part there is one unknown.
  const double radius = distorted.norm();
  const double largest = std::sqrt(squared_limit);
  const auto radial = [&](double r) {
    const ValueAndSlope factor = rational_factor(camera, r * r);
    return ValueAndSlope{r * factor.value, factor.value + 2 * r * r * factor.slope};
  };
  const double start = invert(radial, radius, largest).value_or(largest);
  return refine(camera, radius > 0 ? Vector2d(start / radius * distorted) : distorted, distorted,
                squared_limit);
}

}  // namespace pipescout::geometry
