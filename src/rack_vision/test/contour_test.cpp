// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/contour.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "rack_scenes.hpp"

namespace pipescout::rack_vision {
namespace {

using geometry::SE3;
using geometry::Vector6d;
using test::Engine;
using test::uniform;

const geometry::Camera kCamera(geometry::CameraParameters{.aspect_ratio = 1.1, .skew = 2});

std::optional<ImageLine> line_of(const PipeSection& section, int side, const SE3& T_camera_rack,
                                 const geometry::Camera& camera = kCamera) {
  const CameraView view(camera, T_camera_rack);
  ContourLine both[2];
  ImageLine line;
  if (!contour_lines(section, view.centre, both) || !image_line(view, both[side], line)) {
    return {};
  }
  return line;
}

std::optional<ImageLine> line_of(const SupportEdge& edge, const SE3& T_camera_rack) {
  const CameraView view(kCamera, T_camera_rack);
  ContourLine contour;
  ImageLine line;
  if (!support_line(edge, view.centre, contour) || !image_line(view, contour, line)) {
    return {};
  }
  return line;
}

/// Central differences of the line with respect to the motion of the camera.
template <typename Function>
Matrix36d numeric_derivative(const Function& line_at, const SE3& T_camera_rack) {
  constexpr double kStep = 1e-5;
  Matrix36d result;
  for (int i = 0; i < 6; ++i) {
    const Vector6d step = kStep * Vector6d::Unit(i);
    result.col(i) =
        (line_at(moved(T_camera_rack, step))->line - line_at(moved(T_camera_rack, -step))->line) /
        (2 * kStep);
  }
  return result;
}

double scale_of(const Matrix36d& derivative) {
  return std::max(1.0, derivative.cwiseAbs().maxCoeff());
}

PipeSection random_section(Engine& engine) {
  const bool cone = uniform(engine, 0, 1) < 0.5;
  const double radius = uniform(engine, 0.1, 0.3);
  return {{uniform(engine, -1, 1), uniform(engine, -1, 1), uniform(engine, -1, 1)},
          Eigen::Vector3d(uniform(engine, -1, 1), uniform(engine, -1, 1), uniform(engine, -1, 1))
              .normalized(),
          uniform(engine, 0.5, 3),
          radius,
          cone ? uniform(engine, 0.1, 0.3) : radius};
}

/// About 3 m from the origin, which it sees.
SE3 random_pose(Engine& engine) {
  const Eigen::Vector3d away(uniform(engine, -1, 1), uniform(engine, -1, 1),
                             uniform(engine, 0.5, 1));
  return test::looking_at(3 * away.normalized(), {uniform(engine, -0.5, 0.5), 0, 0},
                          uniform(engine, -3, 3));
}

TEST(ImageLine, HoldsTheImageOfTheContour) {
  Engine engine(1);
  for (int i = 0; i < 200; ++i) {
    const PipeSection section = random_section(engine);
    const SE3 pose = random_pose(engine);
    ContourLine both[2];
    ASSERT_TRUE(contour_lines(section, test::eye_of(pose), both));
    for (int side = 0; side < 2; ++side) {
      const auto line = line_of(section, side, pose);
      ASSERT_TRUE(line);
      EXPECT_NEAR(line->line.head<2>().norm(), 1, 1e-12);
      for (const Eigen::Vector3d& point : {both[side].start, both[side].end}) {
        const Eigen::Vector3d in_camera = pose * point;
        const Eigen::Vector3d pixel = kCamera.matrix() * in_camera / in_camera.z();
        EXPECT_NEAR(line->line.dot(pixel), 0, 1e-8 * pixel.norm());
      }
      const Eigen::Vector3d axis =
          pose * (section.start + 0.5 * section.length * section.direction);
      EXPECT_LT(line->line.dot(kCamera.matrix() * axis / axis.z()), 0) << "positive is outside";
    }
  }
}

TEST(ImageLine, DerivativeIsThatOfTheLine) {
  Engine engine(2);
  for (int i = 0; i < 300; ++i) {
    const PipeSection section = random_section(engine);
    const SE3 pose = random_pose(engine);
    for (int side = 0; side < 2; ++side) {
      const auto line = line_of(section, side, pose);
      ASSERT_TRUE(line);
      const Matrix36d numeric =
          numeric_derivative([&](const SE3& at) { return line_of(section, side, at); }, pose);
      EXPECT_LT((line->derivative - numeric).cwiseAbs().maxCoeff(), 1e-6 * scale_of(numeric));
    }
  }
}

TEST(ImageLine, DerivativeOfSupportsIsThatOfTheLine) {
  Engine engine(3);
  const Support support{"beam", {-0.3, -0.2, -0.1}, {0.4, 0.1, 0.2}};
  for (int i = 0; i < 50; ++i) {
    const SE3 pose = random_pose(engine);
    for (std::uint16_t part = 0; part < 12; ++part) {
      const SupportEdge edge = support_edge(support, part);
      const auto line = line_of(edge, pose);
      ASSERT_TRUE(line);
      const Matrix36d numeric =
          numeric_derivative([&](const SE3& at) { return line_of(edge, at); }, pose);
      EXPECT_LT((line->derivative - numeric).cwiseAbs().maxCoeff(), 1e-6 * scale_of(numeric));
    }
  }
}

TEST(ImageLine, OffsetOfThePipeIsTheOppositeMotionOfTheCamera) {
  Engine engine(4);
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 50; ++i) {
    const PipeSection section = random_section(engine);
    const SE3 pose = random_pose(engine);
    PipeSection right = section, left = section;
    right.start.x() += kStep;
    left.start.x() -= kStep;
    const auto line = line_of(section, 0, pose);
    ASSERT_TRUE(line);
    const Eigen::Vector3d numeric =
        (line_of(right, 0, pose)->line - line_of(left, 0, pose)->line) / (2 * kStep);
    EXPECT_LT((line->derivative.col(0) + numeric).cwiseAbs().maxCoeff(),
              1e-6 * scale_of(line->derivative));
  }
}

TEST(ImageLine, ClosedFormAboveAPipe) {
  // Camera on the z axis at height h over a pipe of radius r along y: tan of the angle of the
  // contour is r / sqrt(h^2 - r^2).
  const double h = 3, r = 0.2;
  const PipeSection section{{0, -5, 0}, Eigen::Vector3d::UnitY(), 10, r, r};
  const SE3 pose = SE3(geometry::SO3::about_x(std::acos(-1.0)), {0, 0, h}).inverse();
  const geometry::Camera camera;
  const auto left = line_of(section, 0, pose, camera);
  const auto right = line_of(section, 1, pose, camera);
  ASSERT_TRUE(left && right);
  const double pixels = 630 * r / std::sqrt(h * h - r * r);
  EXPECT_TRUE(left->line.isApprox(Eigen::Vector3d(-1, 0, 360 - pixels), 1e-12));
  EXPECT_TRUE(right->line.isApprox(Eigen::Vector3d(1, 0, -360 - pixels), 1e-12));
  // Along the pipe nothing changes.
  EXPECT_LT(left->derivative.col(1).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(ImageLine, AsWellConditionedFarFromTheOrigin) {
  Engine engine(5);
  const Eigen::Vector3d far(500, 1000, 20);
  for (int i = 0; i < 50; ++i) {
    const PipeSection section = random_section(engine);
    PipeSection there = section;
    there.start += far;
    const SE3 pose = random_pose(engine);
    const SE3 pose_there = pose * SE3(geometry::SO3(), -far);
    const auto line = line_of(section, 0, pose);
    const auto line_there = line_of(there, 0, pose_there);
    ASSERT_TRUE(line && line_there);
    EXPECT_LT((line->derivative - line_there->derivative).cwiseAbs().maxCoeff(),
              1e-9 * scale_of(line->derivative));
  }
}

TEST(ImageLine, NoneInTheFocalPlaneOrAtTheCamera) {
  const SE3 pose = test::looking_at({0, 0, 0}, {0, 0, -1});
  const CameraView view(kCamera, pose);
  ImageLine line;
  EXPECT_FALSE(image_line(view, {{1, 0, 0}, {1, 1, 0}, Eigen::Vector3d::UnitZ()}, line));
  EXPECT_FALSE(image_line(view, {{0, 0, 0}, {0, 1, 0}, Eigen::Vector3d::UnitX()}, line));
  ContourLine contour;
  EXPECT_FALSE(support_line({{-1, 0, 0}, {1, 0, 0}}, Eigen::Vector3d::Zero(), contour));
}

TEST(Motion, IsEquationFiveAboutTheCamera) {
  Engine engine(6);
  for (int i = 0; i < 100; ++i) {
    const SE3 pose = random_pose(engine);
    Vector6d motion;
    for (double& value : motion) {
      value = uniform(engine, -0.5, 0.5);
    }
    const SE3 by_equation = pose * SE3::exp(rack_motion(test::eye_of(pose), motion));
    EXPECT_LT((by_equation.matrix() - moved(pose, motion).matrix()).norm(), 1e-12);
  }
}

TEST(Motion, MovesAndTurnsTheCameraAlongTheAxesOfTheRack) {
  const SE3 pose = test::looking_at({1, 2, 3}, {1.5, 2.5, 0}, 0.3);
  const SE3 T_rack_camera = pose.inverse();
  Vector6d motion = Vector6d::Zero();
  motion.head<3>() << 0.1, -0.2, 0.3;
  const SE3 shifted = moved(pose, motion).inverse();
  EXPECT_TRUE(shifted.translation().isApprox(Eigen::Vector3d(1.1, 1.8, 3.3), 1e-12));
  motion << 0, 0, 0, 0.1, 0.2, -0.3;
  const SE3 turned = moved(pose, motion).inverse();
  EXPECT_TRUE(turned.translation().isApprox(T_rack_camera.translation(), 1e-12));
  const geometry::SO3 turn = turned.rotation() * T_rack_camera.rotation().inverse();
  EXPECT_TRUE(turn.log().isApprox(motion.tail<3>(), 1e-9));
}

}  // namespace
}  // namespace pipescout::rack_vision
