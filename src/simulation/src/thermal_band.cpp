// SPDX-License-Identifier: Apache-2.0
#include "thermal_band.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace pipescout::simulation::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNear = 0.05;  // m: nearer to the camera nothing is seen
constexpr std::size_t kMostSamples = 4096;
/// Of the density 6 t (1 - t) on [0, 1], whose integral is the soft edge: variance 1 / 20.
constexpr double kSoftnessPerDeviation = 4.47213595499958;

Vector3d homogeneous(const Vector2d& pixel) {
  return {pixel.x(), pixel.y(), 1};
}

/// Cuts [from, to] to where a + b u >= 0.
void cut(double a, double b, double& from, double& to) {
  if (b > 0) {
    from = std::max(from, -a / b);
  } else if (b < 0) {
    to = std::min(to, -a / b);
  } else if (a < 0) {
    to = from - 1;
  }
}

}  // namespace

ImageLine image_line(const Eigen::Matrix3d& K_inverse, const Vector3d& normal) {
  const Vector3d line = K_inverse.transpose() * normal;
  return line / line.head<2>().norm();
}

double CylinderView::place_at(const Vector2d& pixel) const noexcept {
  const Vector3d m = homogeneous(pixel);
  return shift + numerator.dot(m) / denominator.dot(m);
}

double CylinderView::width_at(const Vector2d& pixel) const noexcept {
  // Along the axis's normal n, which the outlines' normals differ from a little.
  const Vector2d n = axis.head<2>();
  const Vector3d m = homogeneous(pixel);
  double width = 0;
  for (const ImageLine& line : outlines) {
    width += line.dot(m) / std::abs(line.head<2>().dot(n));
  }
  return width;
}

std::optional<CylinderView> view_cylinder(const ThermalEye& eye, const Vector3d& point,
                                          const Vector3d& direction, double radius) {
  const Vector3d P = eye.T_camera_row * point;
  const Vector3d D = eye.T_camera_row.rotation() * direction;
  const double middle = -P.dot(D);  // the place nearest to the camera
  const Vector3d C = P + middle * D;
  const double h = C.norm();
  if (!(h > radius)) {
    return std::nullopt;
  }
  const Vector3d e = C / h;
  const Vector3d across = D.cross(e);
  const double sine = radius / h;
  const double cosine = std::sqrt(1 - sine * sine);
  CylinderView view;
  view.outlines = {image_line(eye.K_inverse, sine * e + cosine * across),
                   image_line(eye.K_inverse, sine * e - cosine * across)};
  view.axis = image_line(eye.K_inverse, across);
  view.numerator = h * (eye.K_inverse.transpose() * D);
  view.denominator = eye.K_inverse.transpose() * e;
  view.shift = middle;
  return view;
}

std::optional<AxisInImage> axis_in_image(const ThermalEye& eye, const Vector3d& point,
                                         const Vector3d& direction, double from_place,
                                         double to_place) {
  const Vector3d P = eye.T_camera_row * point;
  const Vector3d D = eye.T_camera_row.rotation() * direction;
  // Before the camera, then within each border: x = u z, so all are linear in the place.
  double from = from_place;
  double to = to_place;
  cut(P.z() - kNear, D.z(), from, to);
  const Vector3d p = eye.K * P;
  const Vector3d d = eye.K * D;
  cut(p.x(), d.x(), from, to);
  cut(p.y(), d.y(), from, to);
  cut((eye.width - 1) * p.z() - p.x(), (eye.width - 1) * d.z() - d.x(), from, to);
  cut((eye.height - 1) * p.z() - p.y(), (eye.height - 1) * d.z() - d.y(), from, to);
  if (!(from < to)) {
    return std::nullopt;
  }
  return AxisInImage{.from = (p + from * d).hnormalized(),
                     .to = (p + to * d).hnormalized(),
                     .whole = from == from_place && to == to_place};
}

BandBlur band_blur(const ThermalEye& eye, const CylinderView& view, const Vector3d& point,
                   const Vector3d& direction, double place) {
  const Vector3d D = eye.T_camera_row.rotation() * direction;
  const Vector3d X = eye.T_camera_row * point + place * D;
  const Vector3d C = X - X.dot(D) * D;
  // How the ray of a pixel moves over the pipe, whose plane through the axis it stays on.
  const Vector3d moved = eye.velocity.head<3>() + eye.velocity.tail<3>().cross(X);
  BandBlur blur;
  blur.along = eye.exposure * std::abs(moved.dot(D) - moved.dot(C) * X.dot(D) / C.squaredNorm());
  const Vector3d p = eye.K * X;
  const Vector3d rate = -(eye.K * moved);
  const Vector2d pixel_rate = (rate.head<2>() - p.head<2>() / p.z() * rate.z()) / p.z();
  blur.across = eye.exposure * std::abs(view.axis.head<2>().dot(pixel_rate));
  return blur;
}

BandPainter::BandPainter(int height)
    : runs_(static_cast<std::size_t>(height)), samples_(kMostSamples) {}

bool BandPainter::see(const ThermalEye& eye, const CylinderView& view, double across) {
  view_ = view;
  const double variance = eye.lens_blur * eye.lens_blur + (1 + across * across) / 12;
  softness_ = kSoftnessPerDeviation * std::sqrt(variance);
  least_ = std::numeric_limits<double>::infinity();
  most_ = -least_;
  for (int y = 0; y < eye.height; ++y) {
    double from = 0;
    double to = eye.width - 1;
    for (const ImageLine& line : view.outlines) {
      cut(line.y() * y + line.z() + softness_ / 2, line.x(), from, to);
    }
    // Places without end are where the denominator is 0.
    constexpr double kLeastDenominator = 1e-3;
    cut(view.denominator.y() * y + view.denominator.z() - kLeastDenominator, view.denominator.x(),
        from, to);
    Run& run = runs_[static_cast<std::size_t>(y)];
    run = {};
    if (from <= to) {
      run = {.from = static_cast<int>(std::ceil(from)), .to = static_cast<int>(std::floor(to)) + 1};
    }
    if (run.from < run.to) {
      const double first = view.place_at(Vector2d(run.from, y));
      const double last = view.place_at(Vector2d(run.to - 1, y));
      least_ = std::min({least_, first, last});
      most_ = std::max({most_, first, last});
    }
  }
  return least_ <= most_;
}

std::span<BandSample> BandPainter::samples(std::size_t count) noexcept {
  count_ = std::clamp<std::size_t>(count, 2, kMostSamples);
  return std::span(samples_).first(count_);
}

void BandPainter::paint(CountPlane& plane) const noexcept {
  const auto steps = static_cast<float>(count_ - 1);
  const float per_place = most_ > least_ ? static_cast<float>(steps / (most_ - least_)) : 0.0F;
  const float last = steps * (1 - 1e-6F);
  const auto begin = static_cast<float>(view_.shift - least_);
  const auto inverse = static_cast<float>(1 / softness_);
  for (int y = 0; y < plane.height; ++y) {
    const Run run = runs_[static_cast<std::size_t>(y)];
    if (run.from >= run.to) {
      continue;
    }
    std::array<float, 2> slope{};
    std::array<float, 2> offset{};
    for (std::size_t i = 0; i < 2; ++i) {
      const ImageLine& line = view_.outlines[i];
      slope[i] = inverse * static_cast<float>(line.x());
      offset[i] = inverse * static_cast<float>(line.y() * y + line.z()) + 0.5F;
    }
    const auto top = static_cast<float>(view_.numerator.y() * y + view_.numerator.z());
    const auto top_slope = static_cast<float>(view_.numerator.x());
    const auto bottom = static_cast<float>(view_.denominator.y() * y + view_.denominator.z());
    const auto bottom_slope = static_cast<float>(view_.denominator.x());
    float* out = plane.row(y);
    for (int x = run.from; x < run.to; ++x) {
      const auto u = static_cast<float>(x);
      float cover = -1;
      for (std::size_t i = 0; i < 2; ++i) {
        const float t = std::clamp(offset[i] + slope[i] * u, 0.0F, 1.0F);
        cover += t * t * (3 - 2 * t);
      }
      const float place = begin + (top + top_slope * u) / (bottom + bottom_slope * u);
      const float step = std::clamp(place * per_place, 0.0F, last);
      const auto i = static_cast<std::size_t>(step);
      const float part = step - static_cast<float>(i);
      const BandSample& a = samples_[i];
      const BandSample& b = samples_[i + 1];
      const float counts = a.counts + part * (b.counts - a.counts);
      const float share = std::max(cover, 0.0F) * (a.cover + part * (b.cover - a.cover));
      out[x] += share * (counts - out[x]);
    }
  }
}

}  // namespace pipescout::simulation::internal
