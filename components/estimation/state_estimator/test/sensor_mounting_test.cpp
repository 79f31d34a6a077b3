// SPDX-License-Identifier: Apache-2.0
#include "sensor_mounting.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

namespace pipescout {
namespace {

using estimation::GlobalStates;
using estimation::NavState;
using estimation::StateMatrix;
using estimation::StateVector;
using geometry::Matrix6d;
using geometry::SE3;
using geometry::SO3;
using geometry::Vector6d;

constexpr double kStep = 1e-6;

const SensorMounting kMounting{
    .imu = {0.3, -0.1, 0.2},
    .T_base_camera = SE3(SO3::from_roll_pitch_yaw({2.9, 0.1, -1.4}), {0.2, 0.05, -0.1})};

Matrix6d some_covariance() {
  Matrix6d root;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      root(i, j) = std::sin(1 + i + 3 * j) + (i == j ? 2 : 0);
    }
  }
  return 1e-4 * root * root.transpose();
}

/// As geometry_msgs/PoseWithCovariance: position, then rotation about fixed axes.
SE3 moved(const SE3& pose, const Vector6d& d) {
  return {SO3::exp(d.tail<3>()) * pose.rotation(), pose.translation() + d.head<3>()};
}
Vector6d difference(const SE3& from, const SE3& to) {
  Vector6d result;
  result << to.translation() - from.translation(),
      (to.rotation() * from.rotation().inverse()).log();
  return result;
}

NavState some_state() {
  NavState state;
  state.R_map_body = SO3::from_roll_pitch_yaw({0.2, -0.3, 1.1});
  state.position = {4, -2, 1};
  state.velocity = {1.5, 0.4, -0.2};
  return state;
}

GlobalStates some_globals() {
  GlobalStates globals;
  globals.rack_position = {2, 1, -0.5};
  globals.R_map_rack = SO3::from_roll_pitch_yaw({0.02, -0.03, 0.7});
  return globals;
}

TEST(SensorMounting, VisualPoseIsThatOfTheBody) {
  const SE3 T_rack_base(SO3::from_roll_pitch_yaw({0.1, 0.2, 0.3}), {1, 2, 3});
  const auto measured =
      kMounting.visual_pose(7, T_rack_base * kMounting.T_base_camera, some_covariance());
  EXPECT_EQ(measured.time, 7);
  EXPECT_LT(difference(T_rack_base * SE3(SO3(), kMounting.imu), measured.T_rack_body).norm(),
            1e-12);
  EXPECT_LT((measured.camera - Eigen::Vector3d(-0.1, 0.15, -0.3)).norm(), 1e-12);
}

TEST(SensorMounting, VisualPoseCarriesItsCovariance) {
  const SE3 T_rack_camera(SO3::from_roll_pitch_yaw({3.0, 0.2, 0.3}), {1, 2, 3});
  const auto measured = kMounting.visual_pose(0, T_rack_camera, some_covariance());
  Matrix6d numeric;
  for (int i = 0; i < 6; ++i) {
    const auto other = kMounting.visual_pose(0, moved(T_rack_camera, kStep * Vector6d::Unit(i)),
                                             some_covariance());
    numeric.col(i) << other.T_rack_body.translation() - measured.T_rack_body.translation(),
        (measured.T_rack_body.rotation().inverse() * other.T_rack_body.rotation()).log();
  }
  numeric /= kStep;
  const Matrix6d expected = numeric * some_covariance() * numeric.transpose();
  EXPECT_LT((measured.covariance - expected).norm(), 1e-5 * expected.norm());
  EXPECT_EQ(measured.covariance, measured.covariance.transpose());
}

TEST(SensorMounting, CameraPoseUndoesTheVisualPose) {
  const NavState state = some_state();
  const GlobalStates globals = some_globals();
  const auto camera = kMounting.camera_pose(state, some_covariance(), globals, Matrix6d::Zero());
  const auto measured = kMounting.visual_pose(0, camera.T_rack_camera, camera.covariance);
  const SE3 T_rack_body =
      SE3(globals.R_map_rack, globals.rack_position).inverse() * state.T_map_body();
  EXPECT_LT(difference(T_rack_body, measured.T_rack_body).norm(), 1e-12);
  // Position in the map, rotation in the body, as the state has them.
  Matrix6d to_rack = Matrix6d::Identity();
  to_rack.topLeftCorner<3, 3>() = globals.R_map_rack.matrix().transpose();
  const Matrix6d expected = to_rack * some_covariance() * to_rack.transpose();
  EXPECT_LT((measured.covariance - expected).norm(), 1e-9 * expected.norm());
}

TEST(SensorMounting, CameraPoseIsAsUncertainAsTheRack) {
  const NavState state = some_state();
  const GlobalStates globals = some_globals();
  const auto camera = kMounting.camera_pose(state, Matrix6d::Zero(), globals, some_covariance());
  Matrix6d numeric;
  for (int i = 0; i < 6; ++i) {
    estimation::GlobalVector d = estimation::GlobalVector::Zero();
    d(estimation::kRackPosition + i) = kStep;
    const auto other =
        kMounting.camera_pose(state, Matrix6d::Zero(), globals.retract(d), some_covariance());
    numeric.col(i) = difference(camera.T_rack_camera, other.T_rack_camera) / kStep;
  }
  const Matrix6d expected = numeric * some_covariance() * numeric.transpose();
  EXPECT_LT((camera.covariance - expected).norm(), 1e-5 * expected.norm());
}

TEST(SensorMounting, BaseMotionIsThatOfARigidBody) {
  const SensorMounting mounting{.imu = {1, 0, 0}, .T_base_camera = {}};
  estimation::Estimate estimate;
  estimate.angular_rate = {0, 0, 2};
  // The IMU goes round the base, which stands.
  estimate.state.velocity = {0, 2, 0};
  estimate.state.position = {1, 0, 0};
  const auto motion = mounting.base_motion(estimate, StateMatrix::Identity(), 0);
  EXPECT_LT(motion.T_map_base.translation().norm(), 1e-12);
  EXPECT_LT(motion.twist.head<3>().norm(), 1e-12);
  EXPECT_EQ(motion.twist.tail<3>(), estimate.angular_rate);
}

TEST(SensorMounting, BaseMotionCarriesItsCovariance) {
  StateMatrix root = StateMatrix::Identity();
  for (int i = 0; i < estimation::kStateSize; ++i) {
    for (int j = 0; j < estimation::kStateSize; ++j) {
      root(i, j) += 0.3 * std::sin(2 + 3 * i + j);
    }
  }
  const StateMatrix covariance = 1e-4 * root * root.transpose();
  estimation::Estimate estimate;
  estimate.state = some_state();
  estimate.angular_rate = {0.1, -0.4, 0.7};
  const auto motion = kMounting.base_motion(estimate, covariance, 0);
  Eigen::Matrix<double, 12, estimation::kStateSize> numeric;
  for (int i = 0; i < estimation::kStateSize; ++i) {
    estimation::Estimate other = estimate;
    const StateVector d = kStep * StateVector::Unit(i);
    other.state = estimate.state.retract(d);
    other.angular_rate -= d.segment<3>(estimation::kGyroBias);
    const auto there = kMounting.base_motion(other, covariance, 0);
    numeric.col(i) << difference(motion.T_map_base, there.T_map_base), there.twist - motion.twist;
  }
  numeric /= kStep;
  const Eigen::Matrix<double, 12, 12> expected = numeric * covariance * numeric.transpose();
  EXPECT_LT((motion.pose_covariance - expected.topLeftCorner<6, 6>()).norm(),
            1e-5 * expected.norm());
  EXPECT_LT((motion.twist_covariance - expected.bottomRightCorner<6, 6>()).norm(),
            1e-5 * expected.norm());
}

TEST(SensorMounting, NoiseOfTheGyroIsInTheTwist) {
  const auto motion = kMounting.base_motion(estimation::Estimate{}, StateMatrix::Zero(), 0.01);
  EXPECT_NEAR(motion.twist_covariance(3, 3), 0.01, 1e-15);
  // Turning about z moves the base along y by the x of the IMU.
  EXPECT_NEAR(motion.twist_covariance(1, 1), 0.01 * (0.3 * 0.3 + 0.2 * 0.2), 1e-15);
}

}  // namespace
}  // namespace pipescout
