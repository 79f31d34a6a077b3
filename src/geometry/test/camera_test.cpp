// SPDX-License-Identifier: Apache-2.0
#include "pipescout/geometry/camera.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace pipescout::geometry {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Ideal; skewed; a usual lens; strong barrel (19 % at the corners); pincushion; all at once; a
/// wide rational one (62 degrees off the axis in the corners); equidistant ones, the last of a view
/// of 158 degrees.
std::vector<CameraParameters> cameras() {
  return {
      {},
      {.focal_length = 600, .aspect_ratio = 1.1, .skew = 2, .centre_u = 350.5, .centre_v = 247.25},
      {.k1 = -0.12, .k2 = 0.05, .k3 = -0.01, .p1 = 0.001, .p2 = -0.0007},
      {.focal_length = 480, .k1 = -0.34, .k2 = 0.12, .k3 = -0.015},
      {.k1 = 0.3, .k2 = 0.1},
      {.width = 1280,
       .height = 720,
       .focal_length = 800,
       .aspect_ratio = 0.95,
       .skew = -3,
       .centre_u = 655,
       .centre_v = 348,
       .k1 = -0.25,
       .k2 = 0.09,
       .p1 = -0.002,
       .p2 = 0.0015},
      {.focal_length = 380,
       .skew = 0.5,
       .k1 = 0.35,
       .k2 = 0.02,
       .k3 = 0.001,
       .p1 = 0.0005,
       .p2 = -0.0004,
       .k4 = 0.6,
       .k5 = 0.08,
       .k6 = 0.003},
      {.focal_length = 420, .lens = LensModel::kEquidistant},
      {.focal_length = 330,
       .aspect_ratio = 1.02,
       .skew = -1,
       .centre_u = 352,
       .k1 = -0.03,
       .k2 = 0.012,
       .k3 = -0.006,
       .k4 = 0.001,
       .lens = LensModel::kEquidistant},
  };
}

TEST(Camera, ProjectsAsEquationOne) {
  const Camera camera(CameraParameters{.focal_length = 600, .aspect_ratio = 1.1, .skew = 2});
  const auto pixel = camera.project({0.5, -0.25, 2});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), 600 * 0.25 + 2 * -0.125 + 360, 1e-12);
  EXPECT_NEAR(pixel->y(), 1.1 * 600 * -0.125 + 240, 1e-12);
}

TEST(Camera, DistortsAsBrown) {
  const CameraParameters p{
      .focal_length = 500, .k1 = -0.2, .k2 = 0.06, .k3 = -0.004, .p1 = 0.003, .p2 = -0.002};
  const double x = 0.3;
  const double y = -0.2;
  const double q = x * x + y * y;
  const double radial = 1 + p.k1 * q + p.k2 * q * q + p.k3 * q * q * q;
  const auto pixel = Camera(p).project(4 * Vector3d(x, y, 1));
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), 360 + 500 * (x * radial + 2 * p.p1 * x * y + p.p2 * (q + 2 * x * x)),
              1e-12);
  EXPECT_NEAR(pixel->y(), 240 + 500 * (y * radial + p.p1 * (q + 2 * y * y) + 2 * p.p2 * x * y),
              1e-12);
}

TEST(Camera, InverseMatrixIsTheInverse) {
  for (const CameraParameters& parameters : cameras()) {
    const Camera camera(parameters);
    EXPECT_TRUE((camera.matrix() * camera.inverse_matrix()).isIdentity(1e-13));
  }
}

TEST(Camera, DerivativesAreTheNumericOnes) {
  std::mt19937_64 engine(11);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const CameraParameters& parameters : cameras()) {
    const Camera camera(parameters);
    for (int i = 0; i < 200; ++i) {
      const double depth = 3 + 2 * uniform(engine);
      const Vector3d point = depth * Vector3d(0.55 * uniform(engine), 0.35 * uniform(engine), 1);
      Matrix23d derivative;
      const auto pixel = camera.project(point, derivative);
      ASSERT_TRUE(pixel);
      EXPECT_EQ(*pixel, *camera.project(point));
      constexpr double kStep = 1e-5;
      for (int k = 0; k < 3; ++k) {
        const Vector3d d = kStep * Vector3d::Unit(k);
        const Vector2d numeric =
            (*camera.project(point + d) - *camera.project(point - d)) / (2 * kStep);
        EXPECT_LT((derivative.col(k) - numeric).norm(), 1e-5);
      }
      const Matrix23d intrinsics = camera.derivative_to_intrinsics(*pixel);
      for (int k = 0; k < 3; ++k) {
        const auto moved = [&](double step) {
          CameraParameters other = parameters;
          (k == 0 ? other.focal_length : k == 1 ? other.centre_u : other.centre_v) += step;
          return *Camera(other).project(point);
        };
        EXPECT_LT((intrinsics.col(k) - (moved(0.01) - moved(-0.01)) / 0.02).norm(), 1e-9);
      }
    }
  }
}

TEST(Camera, DistortionIsUndoneOverTheWholeImage) {
  for (const CameraParameters& parameters : cameras()) {
    const Camera camera(parameters);
    for (int u = 0; u < parameters.width; u += 7) {
      for (int v = 0; v < parameters.height; v += 7) {
        const Vector2d pixel(u, v);
        const auto ideal = camera.undistort(pixel);
        ASSERT_TRUE(ideal) << u << ' ' << v;
        const auto back = camera.distort(*ideal);
        ASSERT_TRUE(back);
        EXPECT_LT((*back - pixel).norm(), 1e-9);
        const auto ray = camera.ray(pixel);
        ASSERT_TRUE(ray);
        EXPECT_EQ(ray->z(), 1);
        const auto seen = camera.project(7.5 * *ray);
        ASSERT_TRUE(seen);
        EXPECT_LT((*seen - pixel).norm(), 1e-9);
        EXPECT_LT(((camera.matrix() * *ray).head<2>() - *ideal).norm(), 1e-9);
      }
    }
  }
}

TEST(Camera, BarrelDistortionMovesTheCornersFar) {
  const Camera camera(cameras()[3]);
  const Vector2d corner(0, 0);
  EXPECT_GT((*camera.undistort(corner) - corner).norm(), 60);
}

TEST(Camera, AnEquidistantLensShowsAnglesAsRadii) {
  const CameraParameters p{.focal_length = 200,
                           .k1 = 0.02,
                           .k2 = -0.01,
                           .k3 = 0.004,
                           .k4 = -0.0005,
                           .lens = LensModel::kEquidistant};
  const Camera camera(p);
  for (const double theta : {0.0, 1e-9, 1e-5, 1e-3, 0.1, 0.7, 1.2, 1.39}) {
    const double t = theta * theta;
    const double radius =
        theta * (1 + p.k1 * t + p.k2 * t * t + p.k3 * t * t * t + p.k4 * t * t * t * t);
    const Vector3d point(0.6 * std::sin(theta), -0.8 * std::sin(theta), std::cos(theta));
    const auto pixel = camera.project(3 * point);
    ASSERT_TRUE(pixel) << theta;
    EXPECT_NEAR(pixel->x(), 360 + 200 * 0.6 * radius, 1e-10);
    EXPECT_NEAR(pixel->y(), 240 - 200 * 0.8 * radius, 1e-10);
    const auto ray = camera.ray(*pixel);
    ASSERT_TRUE(ray) << theta;
    EXPECT_LT((ray->normalized() - point).norm(), 1e-12) << theta;
  }
}

TEST(Camera, DerivativesHoldNearTheAxisAndFarOffIt) {
  for (const CameraParameters& parameters : {cameras()[6], cameras()[7], cameras()[8]}) {
    const Camera camera(parameters);
    for (const double r : {0.0, 1e-7, 1e-5, 9.9e-5, 1.01e-4, 1e-3, 0.5, 1.3}) {
      const Vector3d point(0.8 * r, 0.6 * r, 1);
      Matrix23d derivative;
      ASSERT_TRUE(camera.project(point, derivative)) << r;
      constexpr double kStep = 1e-6;
      for (int k = 0; k < 3; ++k) {
        const Vector3d d = kStep * Vector3d::Unit(k);
        const Vector2d numeric =
            (*camera.project(point + d) - *camera.project(point - d)) / (2 * kStep);
        EXPECT_LT((derivative.col(k) - numeric).norm(), 1e-5) << r;
      }
    }
  }
}

TEST(Camera, AnEquidistantImageMayShowMoreThanIsUsed) {
  // The corners are 124 degrees off the axis.
  const Camera camera(CameraParameters{.focal_length = 200, .lens = LensModel::kEquidistant});
  EXPECT_FALSE(camera.ray({0, 0}));
  EXPECT_TRUE(camera.ray({360, 0}));
  EXPECT_FALSE(camera.ray({10, 240}));
  EXPECT_TRUE(camera.ray({360 - 200 * 1.39, 240}));
  EXPECT_FALSE(camera.project({-6, 0, 1}));
  EXPECT_TRUE(camera.project({-5, 0, 1}));
  EXPECT_NEAR(camera.largest_radius(), std::tan(kWidestEquidistantAngle), 1e-9);
}

TEST(Camera, SeesNothingBehindItNorAtItsCentre) {
  const Camera camera(cameras()[2]);
  Matrix23d derivative;
  for (const Vector3d& point :
       {Vector3d(0, 0, 0), Vector3d(0, 0, -1), Vector3d(0.1, 0, 0), Vector3d(0, 0, 1e-9),
        Vector3d(kNaN, 0, 1), Vector3d(0, kNaN, 1), Vector3d(0, 0, kNaN), Vector3d(kInfinity, 0, 1),
        Vector3d(1, 0, -kInfinity)}) {
    EXPECT_FALSE(camera.project(point)) << point.transpose();
    EXPECT_FALSE(camera.project(point, derivative));
    EXPECT_FALSE(Camera().project(point)) << point.transpose();
  }
  EXPECT_TRUE(camera.project({0, 0, 1e-3}));
}

TEST(Camera, SaysNothingWhereItsDistortionNoLongerHolds) {
  // r - 0.34 r^3 ... turns back: without a bound, points far outside would be seen inside.
  const Camera camera(cameras()[3]);
  for (double x = 0; x < 100; x += 0.01) {
    const auto pixel = camera.project({x, 0, 1});
    if (x > 1.0) {  // the right border is at 0.97
      EXPECT_TRUE(!pixel || !camera.contains(*pixel)) << x;
    } else if (x < 0.7) {
      EXPECT_TRUE(pixel) << x;
    }
  }
  EXPECT_FALSE(camera.ray({5000, 240}));
  EXPECT_FALSE(camera.undistort({-1e9, 240}));
  EXPECT_FALSE(camera.distort({1e6, 1e6}));
}

TEST(Camera, PixelsThatAreNotNumbersGiveNothing) {
  for (const CameraParameters& parameters : {cameras()[0], cameras()[3]}) {
    const Camera camera(parameters);
    for (const double bad : {kNaN, kInfinity, -kInfinity}) {
      EXPECT_FALSE(camera.ray({bad, 1}));
      EXPECT_FALSE(camera.ray({1, bad}));
      EXPECT_FALSE(camera.undistort({bad, 1}));
      EXPECT_FALSE(camera.distort({1, bad}));
      EXPECT_FALSE(camera.contains({bad, 1}));
      EXPECT_FALSE(camera.contains({1, bad}));
    }
  }
}

TEST(Camera, ContainsLeavesTheMargin) {
  const Camera camera;
  EXPECT_TRUE(camera.contains({0, 0}));
  EXPECT_TRUE(camera.contains({719, 479}));
  EXPECT_FALSE(camera.contains({719.01, 479}));
  EXPECT_FALSE(camera.contains({-0.01, 0}));
  EXPECT_FALSE(camera.contains({9.99, 240}, 10));
  EXPECT_TRUE(camera.contains({10, 469}, 10));
  EXPECT_FALSE(camera.contains({10, 469.5}, 10));
}

struct BadField {
  const char* name;
  double CameraParameters::*field;
  std::vector<double> values;
};

TEST(CameraParameters, EachBadFieldIsNamed) {
  const std::vector<BadField> fields{
      {"focal_length", &CameraParameters::focal_length, {0, -600, kNaN, kInfinity}},
      {"aspect_ratio", &CameraParameters::aspect_ratio, {0, -1, kNaN, kInfinity}},
      {"skew", &CameraParameters::skew, {kNaN, -kInfinity}},
      {"centre_u", &CameraParameters::centre_u, {kNaN, kInfinity}},
      {"centre_v", &CameraParameters::centre_v, {kNaN, kInfinity}},
      {"k1", &CameraParameters::k1, {kNaN, kInfinity}},
      {"k2", &CameraParameters::k2, {kNaN, kInfinity}},
      {"k3", &CameraParameters::k3, {kNaN, kInfinity}},
      {"p1", &CameraParameters::p1, {kNaN, kInfinity}},
      {"p2", &CameraParameters::p2, {kNaN, kInfinity}},
      {"k4", &CameraParameters::k4, {kNaN, kInfinity}},
      {"k5", &CameraParameters::k5, {kNaN, kInfinity}},
      {"k6", &CameraParameters::k6, {kNaN, kInfinity}},
  };
  for (const BadField& field : fields) {
    for (const double value : field.values) {
      CameraParameters parameters;
      parameters.*field.field = value;
      try {
        const Camera camera(parameters);
        ADD_FAILURE() << field.name << ' ' << value;
      } catch (const std::invalid_argument& error) {
        EXPECT_THAT(error.what(), HasSubstr(std::string("CameraParameters.") + field.name + ": "));
      }
    }
  }
  for (const int size : {0, -480}) {
    CameraParameters parameters;
    parameters.width = size;
    EXPECT_THROW(parameters.validate(), std::invalid_argument);
    parameters = {};
    parameters.height = size;
    EXPECT_THROW(parameters.validate(), std::invalid_argument);
  }
}

TEST(CameraParameters, DistortionMustBeInvertibleInTheImage) {
  const CameraParameters folded{.k1 = -0.9};
  EXPECT_THROW(folded.validate(), std::invalid_argument);
  EXPECT_NO_THROW(cameras()[3].validate());
  const CameraParameters turned_back{.k4 = 4};  // turns back at r = 0.5
  EXPECT_THROW(turned_back.validate(), std::invalid_argument);
  const CameraParameters turning{.focal_length = 900, .k1 = -0.5, .lens = LensModel::kEquidistant};
  EXPECT_NO_THROW(turning.validate());  // at 0.8 rad, outside the image
  const CameraParameters folded_fisheye{
      .focal_length = 250, .k1 = -0.5, .lens = LensModel::kEquidistant};
  EXPECT_THROW(folded_fisheye.validate(), std::invalid_argument);
}

TEST(CameraParameters, AnEquidistantLensHasFourCoefficients) {
  for (const auto field : {&CameraParameters::p1, &CameraParameters::p2, &CameraParameters::k5,
                           &CameraParameters::k6}) {
    CameraParameters parameters{.lens = LensModel::kEquidistant};
    parameters.*field = 1e-3;
    EXPECT_THROW(parameters.validate(), std::invalid_argument);
  }
}

}  // namespace
}  // namespace pipescout::geometry
