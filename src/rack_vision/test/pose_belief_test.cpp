// SPDX-License-Identifier: Apache-2.0
#include "pose_belief.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <optional>

namespace pipescout::rack_vision {
namespace {

using geometry::Matrix6d;
using geometry::SE3;
using geometry::SO3;
using geometry::Vector6d;

constexpr double kStep = 0.04;  // s
constexpr int kY = 1;

const SE3 kPlace(SO3::exp({3.0, 0.1, -0.05}), {0.9, 4.0, 2.6});

Matrix6d start_covariance() {
  Vector6d deviations;
  deviations << 0.01, 0.001, 0.02, 0.004, 0.005, 0.003;
  return deviations.cwiseAbs2().asDiagonal();
}

/// What an image says of the difference between pose and map, to `sigma` in all directions.
MapErrorSolution seen_against_the_map(const PoseBelief& belief, double sigma, Matrix6d& pose) {
  const MapErrorBelief map = belief.map();
  Eigen::Matrix<double, 12, 12> prior;
  prior << belief.covariance(), map.with_pose, map.with_pose.transpose(), map.covariance;
  prior(6 + kY, 6 + kY) += 1e-10;
  Eigen::Matrix<double, 6, 12> by;
  by << Matrix6d::Identity(), -Matrix6d::Identity();
  const Eigen::Matrix<double, 12, 12> information =
      prior.inverse() + by.transpose() * by / (sigma * sigma);
  const Eigen::Matrix<double, 12, 12> posterior = information.inverse();
  pose = posterior.topLeftCorner<6, 6>();
  return {.mean = Vector6d::Zero(),
          .covariance = posterior.bottomRightCorner<6, 6>(),
          .with_pose = posterior.topRightCorner<6, 6>()};
}

double smallest_eigenvalue(const Matrix6d& matrix) {
  return Eigen::SelfAdjointEigenSolver<Matrix6d>(matrix).eigenvalues().minCoeff();
}

TEST(PoseBelief, AMapThatIsBegunSharesTheErrorOfThePose) {
  PoseBelief belief(kPlace, start_covariance());
  EXPECT_FALSE(belief.map().exists());
  belief.begin_map();
  ASSERT_TRUE(belief.map().exists());
  Matrix6d relative = belief.relative_covariance();
  EXPECT_NEAR(relative(kY, kY), start_covariance()(kY, kY), 1e-15);  // the anchor's business
  relative(kY, kY) = 0;
  EXPECT_LT(relative.norm(), 1e-15);
}

TEST(PoseBelief, PointsThatAreFoundAgainKeepThePoseAsGoodAsItWas) {
  PoseBelief belief(kPlace, start_covariance());
  belief.begin_map();
  for (int i = 0; i < 100; ++i) {
    belief.predict(kStep, 1, 1);
    Matrix6d pose;
    const MapErrorSolution map = seen_against_the_map(belief, 1e-4, pose);
    belief.update(belief.pose(), pose, map);
    EXPECT_GT(smallest_eigenvalue(belief.covariance()), 0);
    EXPECT_GT(smallest_eigenvalue(belief.relative_covariance()), -1e-12);
  }
  // Four seconds of the map's own drift, and no more.
  EXPECT_LT(belief.covariance()(0, 0), 1.5 * start_covariance()(0, 0));
  EXPECT_LT(belief.relative_covariance()(0, 0), 1e-6);
}

TEST(PoseBelief, WhatPoseAndMapAreWrongByTogetherIsNoSpeed) {
  PoseBelief belief(kPlace, start_covariance());
  belief.begin_map();
  for (int i = 0; i < 20; ++i) {
    belief.predict(kStep, 1, 1);
    Matrix6d pose;
    const MapErrorSolution map = seen_against_the_map(belief, 1e-4, pose);
    belief.update(belief.pose(), pose, map);
  }
  belief.predict(kStep, 1, 1);
  Vector6d found = Vector6d::Zero();
  found(0) = 0.008;
  Matrix6d pose;
  MapErrorSolution map = seen_against_the_map(belief, 1e-4, pose);
  map.mean = found;
  PoseBelief together = belief;
  together.update(moved_pose(belief.pose(), found), pose, map);
  EXPECT_LT(together.velocity().head<3>().norm(), 0.01);
  // The pose alone would have moved at 0.2 m/s.
  map.mean.setZero();
  belief.update(moved_pose(belief.pose(), found), pose, map);
  EXPECT_GT(belief.velocity()(0), 0.05);
}

TEST(PoseBelief, ARestartKeepsTheMapAndForgetsHowItHangsTogetherWithThePose) {
  PoseBelief belief(kPlace, start_covariance());
  belief.begin_map();
  const Matrix6d map = belief.map().covariance;
  belief.restart(kPlace, 4 * start_covariance());
  EXPECT_EQ(belief.map().covariance, map);
  EXPECT_EQ(belief.map().with_pose, Matrix6d::Zero());
  EXPECT_EQ(belief.covariance(), 4 * start_covariance());
  EXPECT_EQ(belief.velocity(), Vector6d::Zero());
}

TEST(PoseBelief, WithoutTheMapAnUpdateMovesTheVelocityAsBefore) {
  PoseBelief belief(kPlace, start_covariance());
  for (int i = 0; i < 50; ++i) {
    const SE3 seen = moved_pose(belief.pose(), Vector6d::Zero());
    belief.predict(kStep, 1, 1);
    Vector6d step = Vector6d::Zero();
    step(2) = 0.3 * kStep;
    belief.update(moved_pose(seen, step), 1e-8 * Matrix6d::Identity(), std::nullopt);
  }
  EXPECT_NEAR(belief.velocity()(2), 0.3, 0.01);
}

}  // namespace
}  // namespace pipescout::rack_vision
