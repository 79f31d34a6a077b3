// SPDX-License-Identifier: Apache-2.0
#include "pose_belief.hpp"

#include <Eigen/Cholesky>

namespace pipescout::rack_vision {
namespace {

constexpr double kUsualSpeed = 0.5;         // m/s: the paper's cruise velocity
constexpr double kUsualAngularSpeed = 0.3;  // rad/s: the paper's 0.2, and gusts

}  // namespace

geometry::Vector6d pose_difference(const geometry::SE3& from, const geometry::SE3& to) noexcept {
  geometry::Vector6d difference;
  difference << to.translation() - from.translation(),
      (to.rotation() * from.rotation().inverse()).log();
  return difference;
}

geometry::SE3 moved_pose(const geometry::SE3& from, const geometry::Vector6d& difference) {
  return {geometry::SO3::exp(difference.tail<3>()) * from.rotation(),
          from.translation() + difference.head<3>()};
}

PoseBelief::PoseBelief(const geometry::SE3& T_rack_camera, const geometry::Matrix6d& covariance)
    : pose_(T_rack_camera) {
  covariance_.setZero();
  covariance_.topLeftCorner<6, 6>() = covariance;
  covariance_.diagonal().segment<3>(6).setConstant(kUsualSpeed * kUsualSpeed);
  covariance_.diagonal().segment<3>(9).setConstant(kUsualAngularSpeed * kUsualAngularSpeed);
}

void PoseBelief::predict(double dt, double acceleration_sigma, double angular_acceleration_sigma) {
  pose_ = moved_pose(pose_, velocity_ * dt);
  // F = [I, dt I; 0, I], applied by blocks.
  covariance_.topRows<6>() += dt * covariance_.bottomRows<6>();
  covariance_.leftCols<6>() += dt * covariance_.rightCols<6>();
  for (int i = 0; i < 6; ++i) {
    const double sigma = i < 3 ? acceleration_sigma : angular_acceleration_sigma;
    const double position = 0.5 * dt * dt * sigma;
    const double velocity = dt * sigma;
    covariance_(i, i) += position * position;
    covariance_(i, i + 6) += position * velocity;
    covariance_(i + 6, i) += position * velocity;
    covariance_(i + 6, i + 6) += velocity * velocity;
  }
}

void PoseBelief::predict(const geometry::SE3& T_previous_current,
                         const geometry::Matrix6d& covariance, double dt) {
  const geometry::SE3 before = pose_;
  pose_ = before * T_previous_current;
  // The turn of the pose before moves the place now by its lever.
  const Eigen::Vector3d lever = pose_.translation() - before.translation();
  geometry::Matrix6d by_before = geometry::Matrix6d::Identity();
  by_before.topRightCorner<3, 3>() = -geometry::skew(lever);
  geometry::Matrix6d to_rack = geometry::Matrix6d::Zero();
  to_rack.topLeftCorner<3, 3>() = pose_.rotation().matrix();
  to_rack.bottomRightCorner<3, 3>() = pose_.rotation().matrix();
  const geometry::Matrix6d motion = to_rack * covariance * to_rack.transpose();
  const geometry::Matrix6d pose =
      by_before * covariance_.topLeftCorner<6, 6>() * by_before.transpose() + motion;
  velocity_ = pose_difference(before, pose_) / dt;
  covariance_.setZero();
  covariance_.topLeftCorner<6, 6>() = pose;
  covariance_.topRightCorner<6, 6>() = motion / dt;
  covariance_.bottomLeftCorner<6, 6>() = motion / dt;
  // Beyond the motion's own error: it is a mean over dt.
  covariance_.bottomRightCorner<6, 6>() = motion / (dt * dt);
  covariance_.diagonal().tail<6>() *= 1.5;
  covariance_.diagonal().tail<6>().array() += 1e-4;
}

void PoseBelief::update(const geometry::SE3& T_rack_camera, const geometry::Matrix6d& covariance) {
  const geometry::Vector6d step = pose_difference(pose_, T_rack_camera);
  const geometry::Matrix6d prior = covariance_.topLeftCorner<6, 6>();
  const geometry::Matrix6d cross = covariance_.bottomLeftCorner<6, 6>();
  // Regression of the velocity on the pose: what is learnt of the one tells about the other.
  const geometry::Matrix6d regression = prior.ldlt().solve(cross.transpose()).transpose();
  velocity_ += regression * step;
  pose_ = T_rack_camera;
  covariance_.bottomRightCorner<6, 6>() -=
      regression * (prior - covariance) * regression.transpose();
  covariance_.topLeftCorner<6, 6>() = covariance;
  covariance_.bottomLeftCorner<6, 6>() = regression * covariance;
  covariance_.topRightCorner<6, 6>() = covariance_.bottomLeftCorner<6, 6>().transpose();
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
}

void PoseBelief::shift_along(double y) {
  pose_ = geometry::SE3(pose_.rotation(), pose_.translation() + y * Eigen::Vector3d::UnitY());
}

void PoseBelief::shift(const geometry::Vector6d& difference) {
  pose_ = moved_pose(pose_, difference);
}

}  // namespace pipescout::rack_vision
