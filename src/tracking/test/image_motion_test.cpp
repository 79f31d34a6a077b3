// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking/image_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "pipescout/tracking/shapes.hpp"

namespace pipescout::tracking {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using geometry::SE3;
using geometry::Vector6d;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

geometry::Camera camera() {
  return geometry::Camera({.width = 320,
                           .height = 240,
                           .focal_length = 721,
                           .aspect_ratio = 1.02,
                           .centre_u = 161,
                           .centre_v = 118});
}

Vector6d some_velocity() {
  Vector6d velocity;
  velocity << 5.5, -0.3, 0.4, 0.12, -0.25, 0.31;
  return velocity;
}

/// Where a point that stands still is seen after the camera has moved for `dt`.
Vector2d seen_after(const Vector3d& point, double dt) {
  const SE3 T_before_after = SE3::exp(dt * some_velocity());
  return *camera().project(T_before_after.inverse() * point);
}

TEST(ImageMotion, IsThatOfPointsOfAPlaneParallelToThePicture) {
  constexpr double kDepth = 9;
  constexpr double kDt = 1e-5;
  const Vector2d at(90, 170);
  const auto motion = image_motion(camera(), at, kDepth, some_velocity());
  ASSERT_TRUE(motion);
  for (const Vector2d& away : {Vector2d(0, 0), Vector2d(0.5, 0), Vector2d(0, 0.5)}) {
    const Vector3d point = kDepth * *camera().ray(at + away);
    const Vector2d expected = (seen_after(point, kDt) - seen_after(point, -kDt)) / (2 * kDt);
    // Linear about `at`.
    EXPECT_LT((motion->of(at + away) - expected).norm(), 1e-3) << away.transpose();
  }
}

TEST(ImageMotion, ClosedForms) {
  const Vector2d centre(161, 118);
  Vector6d velocity = Vector6d::Zero();
  velocity[0] = 5;
  const auto sideways = image_motion(camera(), centre, 10, velocity);
  EXPECT_NEAR(sideways->velocity.x(), -721 * 5.0 / 10, 1e-9);
  EXPECT_NEAR(sideways->velocity.y(), 0, 1e-9);
  EXPECT_LT(sideways->gradient.norm(), 1e-12);
  velocity.setZero();
  velocity[2] = 2;  // towards it: all grows by v / depth
  EXPECT_LT(
      (image_motion(camera(), centre, 10, velocity)->gradient - 0.2 * Eigen::Matrix2d::Identity())
          .norm(),
      1e-12);
  velocity.setZero();
  velocity[5] = 0.3;  // about the axis of view: the picture turns the other way
  const auto turning = image_motion(camera(), centre, 10, velocity);
  const PipeShape::State level(161, 118, 100, 0);
  EXPECT_NEAR(PipeShape::moved_by(level, *turning)[PipeShape::kAngle], -0.3 * 1.02, 1e-9);
}

TEST(ImageMotion, OfACameraOnABody) {
  const SE3 T_body_camera(geometry::SO3::about_z(0.7) * geometry::SO3::about_x(-1.4),
                          {0.2, 0.4, 1.2});
  const Vector6d body = some_velocity();
  const Vector6d velocity = camera_velocity(T_body_camera, body);
  const Eigen::Matrix3d R_camera_body = T_body_camera.rotation().matrix().transpose();
  const Vector3d of_point =
      body.head<3>() + body.tail<3>().cross(Vector3d(T_body_camera.translation()));
  EXPECT_LT((velocity.head<3>() - R_camera_body * of_point).norm(), 1e-12);
  EXPECT_LT((velocity.tail<3>() - R_camera_body * body.tail<3>()).norm(), 1e-12);
}

TEST(ImageMotion, NothingForBadInput) {
  EXPECT_FALSE(image_motion(camera(), {0, 0}, 0, some_velocity()));
  EXPECT_FALSE(image_motion(camera(), {0, 0}, kNan, some_velocity()));
  EXPECT_FALSE(image_motion(camera(), {kNan, 0}, 1, some_velocity()));
  Vector6d bad = some_velocity();
  bad[4] = kNan;
  EXPECT_FALSE(image_motion(camera(), {0, 0}, 1, bad));
}

/// A shape that the field carries along for a moment.
template <class Model, class Points>
void expect_moved(const typename Model::State& state, const Points& shape_of_points) {
  const auto motion = image_motion(camera(), state.template head<2>(), 9, some_velocity());
  constexpr double kDt = 1e-6;
  const typename Model::State after = shape_of_points(state, *motion, kDt);
  const typename Model::State rate = (after - state) / kDt;
  EXPECT_LT((Model::moved_by(state, *motion) - rate).cwiseAbs().maxCoeff(), 1e-2)
      << rate.transpose();
}

TEST(ImageMotion, CarriesShapesAlong) {
  expect_moved<PipeShape>({100, 90, 140, 0.4}, [](const auto& s, const ImageMotion& m, double dt) {
    const Vector2d half = s[2] / 2 * Vector2d(std::cos(s[3]), std::sin(s[3]));
    const Vector2d a = s.template head<2>() - half;
    const Vector2d b = s.template head<2>() + half;
    return PipeShape::state_of({.start = a + dt * m.of(a), .end = b + dt * m.of(b)});
  });
  expect_moved<ValveShape>({100, 90, 20}, [](const auto& s, const ImageMotion& m, double dt) {
    // The circle of the same area as the ellipse that it becomes.
    const Eigen::Matrix2d grown = Eigen::Matrix2d::Identity() + dt * m.gradient;
    const Vector2d c = s.template head<2>() + dt * m.velocity;
    return ValveShape::State(c.x(), c.y(), s[2] * std::sqrt(grown.determinant()));
  });
  VesselShape::State vessel;
  vessel << 100, 90, 80, 30, 0.4;
  expect_moved<VesselShape>(vessel, [](const auto& s, const ImageMotion& m, double dt) {
    const Eigen::Matrix2d grown = Eigen::Matrix2d::Identity() + dt * m.gradient;
    const Vector2d u(std::cos(s[4]), std::sin(s[4]));
    const Vector2d n(-u.y(), u.x());
    const Vector2d axis = grown * u;
    const Vector2d c = s.template head<2>() + dt * m.velocity;
    VesselShape::State result;
    result << c.x(), c.y(), s[2] * axis.norm(), s[3] * n.dot(grown * n),
        std::atan2(axis.y(), axis.x());
    return result;
  });
}

}  // namespace
}  // namespace pipescout::tracking
