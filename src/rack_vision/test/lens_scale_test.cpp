// SPDX-License-Identifier: Apache-2.0
#include "lens_scale.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace pipescout::rack_vision {
namespace {

geometry::Camera camera(geometry::LensModel lens) {
  geometry::CameraParameters parameters;
  parameters.focal_length = 400;
  parameters.lens = lens;
  return geometry::Camera(parameters);
}

TEST(LensScale, IsOneWithoutDistortion) {
  const geometry::Camera pinhole = camera(geometry::LensModel::kBrown);
  EXPECT_EQ(ideal_per_pixel(pinhole, {10, 20}), 1);
  EXPECT_EQ(ideal_per_pixel(pinhole, {10, 20}, Eigen::Vector2d::UnitX()), 1);
}

TEST(LensScale, IsThatOfTheTangentForAnEquidistantLens) {
  const geometry::Camera fisheye = camera(geometry::LensModel::kEquidistant);
  const double angle = 0.7;  // rad off the axis
  const Eigen::Vector2d ideal(fisheye.parameters().centre_u + 400 * std::tan(angle),
                              fisheye.parameters().centre_v);
  const double away = 1 / std::pow(std::cos(angle), 2);  // d tan(angle) / d angle
  const double around = std::tan(angle) / angle;
  EXPECT_NEAR(ideal_per_pixel(fisheye, ideal, Eigen::Vector2d::UnitX()), away, 0.01);
  EXPECT_NEAR(ideal_per_pixel(fisheye, ideal, Eigen::Vector2d::UnitY()), around, 0.01);
  EXPECT_NEAR(ideal_per_pixel(fisheye, ideal), std::sqrt(away * around), 0.01);
}

}  // namespace
}  // namespace pipescout::rack_vision
