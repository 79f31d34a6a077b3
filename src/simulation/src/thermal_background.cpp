// SPDX-License-Identifier: Apache-2.0
#include "thermal_background.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/statistics/draw.hpp"

namespace pipescout::simulation::internal {
namespace {

using Eigen::Vector3d;

constexpr int kGrainRows = 128;
constexpr int kGrainColumns = 512;
constexpr int kGrainReach = 3;         // pixels, of its smoothing
constexpr double kGrainDistance = 10;  // m
constexpr float kMirrorGrain = 0.3F;   // of that of the ground
constexpr float kSkyGrain = 0.1F;
constexpr double kSkyWarming = 0.5;  // towards the ground's temperature, at the horizon
constexpr double kSkyHeight = 0.5;   // rad, over which the sky gets as cold as it is

/// Smoothed by a box, both ways, and repeating both ways; standard deviation 1.
std::vector<float> periodic_noise(std::mt19937_64& engine) {
  std::vector<double> values(std::size_t{kGrainRows} * kGrainColumns);
  std::ranges::generate(values, [&engine] { return statistics::normal(engine); });
  const auto smooth = [&values](int along, int count_along, int across, int count_across) {
    std::vector<double> result(values.size());
    for (int j = 0; j < count_across; ++j) {
      for (int i = 0; i < count_along; ++i) {
        double sum = 0;
        for (int k = -kGrainReach; k <= kGrainReach; ++k) {
          const int at = (i + k + count_along) % count_along;
          sum += values[static_cast<std::size_t>(at * along + j * across)];
        }
        result[static_cast<std::size_t>(i * along + j * across)] = sum;
      }
    }
    values = result;
  };
  smooth(1, kGrainColumns, kGrainColumns, kGrainRows);
  smooth(kGrainColumns, kGrainRows, 1, kGrainColumns);
  const double deviation = 2 * kGrainReach + 1;  // of a sum over a square of so many squared
  std::vector<float> result(values.size());
  std::ranges::transform(values, result.begin(), [deviation](double value) {
    return static_cast<float>(value / deviation);
  });
  return result;
}

/// How an expression that is linear over the image goes along a row.
struct RowTerm {
  float begin;
  float step;
};
RowTerm on_row(const Vector3d& line, int y, double scale, double shift) {
  return {.begin = static_cast<float>(scale * (line.y() * y + line.z()) + shift),
          .step = static_cast<float>(scale * line.x())};
}

float unit(float value) {
  const float above = value > 0 ? value : 0.0F;
  return above < 1 ? above : 1.0F;
}

}  // namespace

ThermalBackground::ThermalBackground(const ThermalSceneParameters& scene,
                                     const ThermalRadiation& radiation, int width)
    : tube_height_(scene.tube_height), grain_columns_(kGrainColumns) {
  const auto counts = [&radiation](double temperature) {
    return static_cast<float>(radiation.black_body(temperature));
  };
  sky_ = counts(scene.sky_temperature);
  horizon_ = sky_ + static_cast<float>(kSkyWarming) * (counts(scene.ground_temperature) - sky_);
  ground_ = counts(scene.ground_temperature);
  mirror_ = counts(scene.mirror_temperature);
  mirror_change_ =
      static_cast<float>(radiation.slope(scene.mirror_temperature) * scene.mirror_change);
  const auto amplitude =
      static_cast<float>(radiation.slope(scene.ground_temperature) * scene.ground_grain);
  std::mt19937_64 engine = statistics::make_engine(scene.seed, 0x7b);
  const std::vector<float> noise = periodic_noise(engine);
  const auto stride = static_cast<std::size_t>(kGrainColumns + width);
  grain_.resize(stride * kGrainRows);
  for (std::size_t row = 0; row < kGrainRows; ++row) {
    for (std::size_t column = 0; column < stride; ++column) {
      grain_[row * stride + column] =
          amplitude * noise[row * kGrainColumns + column % kGrainColumns];
    }
  }
}

void ThermalBackground::paint(const ThermalEye& eye, CountPlane& plane) const noexcept {
  const geometry::SO3& R = eye.T_camera_row.rotation();
  const Vector3d up = R * Vector3d::UnitZ();
  const Vector3d along = R * Vector3d::UnitX();
  const Vector3d place = eye.T_camera_row.inverse().translation();
  // Lines of the image: the horizon, and both rims of the mirrors. Seen along the mirrors there are
  // none; from behind they are as they are from before.
  const Vector3d horizon = eye.K_inverse.transpose() * up;
  const double per_pixel = horizon.head<2>().norm();  // about 1 / focal length
  const Vector3d lower_rim =
      eye.T_camera_row * Vector3d(0, kMirrorBehind, tube_height_ - kMirrorHalfHeight);
  const Vector3d upper_rim =
      eye.T_camera_row * Vector3d(0, kMirrorBehind, tube_height_ + kMirrorHalfHeight);
  const double side = place.y() < kMirrorBehind ? 1 : -1;
  const Vector3d lower = eye.K_inverse.transpose() * (side * along.cross(-lower_rim));
  const Vector3d upper = eye.K_inverse.transpose() * (side * along.cross(upper_rim));
  const double lower_scale = 1 / std::max(lower.head<2>().norm(), 1e-9);
  const double upper_scale = 1 / std::max(upper.head<2>().norm(), 1e-9);
  // A soft edge of this many pixels has the variance of lens and pixel.
  const double softness = std::sqrt(12 * eye.lens_blur * eye.lens_blur + 1);

  const double focal_length = eye.K(0, 0);
  // What is 10 m away moves to the left when the camera goes, or turns, to the right.
  const Vector3d forward = R.inverse() * Vector3d::UnitZ();
  const auto shift = std::lround(
      focal_length * (place.x() / kGrainDistance + std::atan2(forward.x(), forward.y())));
  const auto column =
      static_cast<std::size_t>(((shift % grain_columns_) + grain_columns_) % grain_columns_);
  const auto rise = std::lround(
      focal_length * (place.z() / kGrainDistance + std::asin(std::clamp(forward.z(), -1.0, 1.0))));
  const auto stride = static_cast<std::size_t>(grain_columns_ + plane.width);

  for (int y = 0; y < plane.height; ++y) {
    const RowTerm sky = on_row(horizon, y, 1 / (per_pixel * softness), 0.5);
    const RowTerm warmth = on_row(horizon, y, 1 / kSkyHeight, 0);
    const RowTerm above = on_row(lower, y, lower_scale / softness, 0.5);
    const RowTerm below = on_row(upper, y, upper_scale / softness, 0.5);
    const auto row =
        static_cast<std::size_t>((((y - rise) % kGrainRows) + kGrainRows) % kGrainRows);
    const float* grain = grain_.data() + row * stride + column;
    float* out = plane.row(y);
    for (int x = 0; x < plane.width; ++x) {
      const auto u = static_cast<float>(x);
      const float is_sky = unit(sky.begin + sky.step * u);
      const float cold = unit(warmth.begin + warmth.step * u);
      const float from_lower = above.begin + above.step * u;
      const float from_upper = below.begin + below.step * u;
      const float is_mirror = unit(from_lower) * unit(from_upper);
      // From -1 at the upper rim to 1 at the lower: it reflects sky above and ground below.
      const float down = (from_upper - from_lower) / (std::abs(from_upper + from_lower) + 1e-3F);
      const float far = ground_ + is_sky * (horizon_ + cold * (sky_ - horizon_) - ground_);
      const float rough = 1 - is_sky * (1 - kSkyGrain);
      const float mirror = mirror_ + mirror_change_ * down;
      out[x] = far + is_mirror * (mirror - far) +
               grain[x] * (rough + is_mirror * (kMirrorGrain - rough));
    }
  }
}

}  // namespace pipescout::simulation::internal
