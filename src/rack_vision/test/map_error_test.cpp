// SPDX-License-Identifier: Apache-2.0
// The solver's unknown that all texture points share: see MapErrorPrior.
#include <gtest/gtest.h>

#include <limits>

#include "feature_scene.hpp"
#include "pipescout/rack_vision/contour.hpp"
#include "pipescout/rack_vision/pose_solver.hpp"

namespace pipescout::rack_vision {
namespace {

using geometry::Matrix6d;
using geometry::SE3;
using geometry::Vector6d;
using test::Engine;
using test::Features;
using test::pose_error;

PoseSolution solve(PoseSolver& solver, const PoseProblem& problem) {
  PoseSolution solution;
  solver.solve(geometry::Camera(), problem, solution);
  return solution;
}

SE3 disturbed(const SE3& pose) {
  Vector6d motion;
  motion << 0.02, -0.03, 0.01, 0.02, -0.03, 0.04;
  return moved(pose, motion);
}

/// Points on the pipes' upper side, mapped from a pose that was wrong by `map_error`.
std::vector<PointObservation> wrongly_mapped(std::vector<PointObservation> points, const SE3& from,
                                             const Vector6d& map_error) {
  for (PointObservation& point : points) {
    point.pipe = PointObservation::kOnNoPipe;
    const Eigen::Vector3d ray = point.place - from.inverse().translation();
    point.place_by_map_error.leftCols<3>().setIdentity();
    point.place_by_map_error.rightCols<3>() = -geometry::skew(ray);
    // The place slides along its ray back to the height where the surface is.
    point.place_by_map_error -= (ray * point.place_by_map_error.row(2) / ray.z()).eval();
    point.place -= point.place_by_map_error * map_error;
  }
  return points;
}

TEST(MapError, FindsWhatAllPointsAreWrongByTogether) {
  const RackModel model = test::row_rack(4);
  Engine engine(3);
  const SE3 mapped_from = test::above(0.6, 4.9, 2.6, 0.05);
  const SE3 truth = test::above();
  Features features =
      test::measure(model, {}, test::texture(model, 8, engine), truth, {.sigma = 0}, engine);
  Vector6d map_error;
  map_error << 0.008, 0, -0.006, 0.002, -0.003, 0.001;
  features.points = wrongly_mapped(features.points, mapped_from, map_error);
  PoseSolver solver(model);
  PoseProblem problem = features.problem(disturbed(truth));
  problem.map_error.emplace();
  problem.map_error->information = 1e2 * Matrix6d::Identity();
  problem.map_error->information(1, 1) = 1e12;
  const PoseSolution found = solve(solver, problem);
  ASSERT_EQ(found.status, PoseStatus::kOk);
  ASSERT_TRUE(found.map_error);
  EXPECT_LT(pose_error(found.T_camera_rack, truth).norm(), 1e-3);
  EXPECT_LT((found.map_error->mean - map_error).norm(), 1e-3);
  // Points tie the two together.
  EXPECT_GT(found.map_error->with_pose(0, 0), 0.5 * found.covariance(0, 0));

  // Without that unknown the points draw the pose with them.
  problem.map_error.reset();
  EXPECT_GT(pose_error(solve(solver, problem).T_camera_rack, truth).norm(), 3e-3);
}

TEST(MapError, ThePriorTiesTheMapErrorToThePose) {
  const RackModel model = test::row_rack(4);
  Engine engine(4);
  const SE3 truth = test::above();
  const Features features =
      test::measure(model, {}, {}, truth, {.sigma = 0}, engine);  // no points: the prior alone
  PoseProblem problem = features.problem(truth);
  Vector6d off;
  off << 0.01, 0, 0.004, 0, 0, 0.002;
  const SE3 T_rack_camera = truth.inverse();
  const SE3 prior(geometry::SO3::exp(-off.tail<3>()) * T_rack_camera.rotation(),
                  T_rack_camera.translation() - off.head<3>());
  problem.pose_prior = PosePrior{prior.inverse(), 1e-2 * Matrix6d::Identity()};
  const Matrix6d by_pose = 0.7 * Matrix6d::Identity();
  problem.map_error = MapErrorPrior{by_pose, 1e4 * Matrix6d::Identity()};
  PoseSolver solver(model);
  const PoseSolution found = solve(solver, problem);
  ASSERT_TRUE(found.map_error);
  const Vector6d moved = pose_error(found.T_camera_rack, prior.inverse());
  EXPECT_LT((found.map_error->mean - by_pose * moved).norm(), 1e-6);
  EXPECT_LT((found.map_error->with_pose - found.covariance * by_pose.transpose()).norm(),
            1e-3 * found.covariance.norm());

  problem.map_error->information(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(solve(solver, problem).status, PoseStatus::kBadInput);
}

}  // namespace
}  // namespace pipescout::rack_vision
