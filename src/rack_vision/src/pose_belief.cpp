// SPDX-License-Identifier: Apache-2.0
#include "pose_belief.hpp"

#include "pipescout/linear_algebra/cholesky.hpp"
#include "pipescout/linear_algebra/products.hpp"
#include "pipescout/linear_algebra/semidefinite.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr double kUsualSpeed = 0.5;         // m/s: the paper's cruise velocity
constexpr double kUsualAngularSpeed = 0.3;  // rad/s: the paper's 0.2, and gusts
// What makes points of other places and times wrong otherwise, per root of a second.
constexpr double kMapDrift = 0.002;      // m
constexpr double kMapTurn = 0.0005;      // rad
constexpr double kTinyVariance = 1e-12;  // m^2

constexpr int kY = 1;
constexpr int kVelocity = 6;
constexpr int kMap = 12;

using Matrix12d = Eigen::Matrix<double, 12, 12>;

}  // namespace

bool is_covariance(const geometry::Matrix6d& matrix) {
  return matrix.allFinite() &&
         (matrix - matrix.transpose()).cwiseAbs().maxCoeff() <=
             1e-6 * matrix.cwiseAbs().maxCoeff() &&
         linear_algebra::Cholesky<6>(matrix).succeeded();
}

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

PoseBelief::PoseBelief(const geometry::SE3& T_rack_camera, const geometry::Matrix6d& covariance) {
  restart(T_rack_camera, covariance);
}

void PoseBelief::restart(const geometry::SE3& T_rack_camera, const geometry::Matrix6d& covariance) {
  pose_ = T_rack_camera;
  velocity_.setZero();
  const geometry::Matrix6d map = covariance_.block<6, 6>(kMap, kMap);
  covariance_.setZero();
  covariance_.topLeftCorner<6, 6>() = covariance;
  covariance_.diagonal().segment<3>(6).setConstant(kUsualSpeed * kUsualSpeed);
  covariance_.diagonal().segment<3>(9).setConstant(kUsualAngularSpeed * kUsualAngularSpeed);
  covariance_.block<6, 6>(kMap, kMap) = map;
}

void PoseBelief::drift_map(double dt) {
  if (!map().exists()) {
    return;
  }
  auto map = covariance_.diagonal().segment<6>(kMap);
  map.head<3>().array() += kMapDrift * kMapDrift * dt;
  map.tail<3>().array() += kMapTurn * kMapTurn * dt;
  map(kY) = 0;
}

void PoseBelief::predict(double dt, double acceleration_sigma, double angular_acceleration_sigma) {
  pose_ = moved_pose(pose_, velocity_ * dt);
  // F = [I, dt I; 0, I], applied by blocks.
  covariance_.topRows<6>() += dt * covariance_.middleRows<6>(kVelocity);
  covariance_.leftCols<6>() += dt * covariance_.middleCols<6>(kVelocity);
  for (int i = 0; i < 6; ++i) {
    const double sigma = i < 3 ? acceleration_sigma : angular_acceleration_sigma;
    const double position = 0.5 * dt * dt * sigma;
    const double velocity = dt * sigma;
    covariance_(i, i) += position * position;
    covariance_(i, i + kVelocity) += position * velocity;
    covariance_(i + kVelocity, i) += position * velocity;
    covariance_(i + kVelocity, i + kVelocity) += velocity * velocity;
  }
  drift_map(dt);
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
  const geometry::Matrix6d motion = linear_algebra::propagate(to_rack, covariance);
  const geometry::Matrix6d pose =
      linear_algebra::propagate<6, 6>(by_before, covariance_.topLeftCorner<6, 6>()) + motion;
  const MapErrorBelief map = this->map();
  velocity_ = pose_difference(before, pose_) / dt;
  covariance_.setZero();
  covariance_.topLeftCorner<6, 6>() = pose;
  covariance_.block<6, 6>(0, kVelocity) = motion / dt;
  covariance_.block<6, 6>(kVelocity, 0) = motion / dt;
  // Beyond the motion's own error: it is a mean over dt.
  auto velocity = covariance_.block<6, 6>(kVelocity, kVelocity);
  velocity = motion / (dt * dt);
  velocity.diagonal() *= 1.5;
  velocity.diagonal().array() += 1e-4;
  set_map({map.covariance, by_before * map.with_pose});
  drift_map(dt);
}

template <int N>
Eigen::Matrix<double, 6, N> PoseBelief::learn_velocity(
    const Eigen::Matrix<double, N, N>& prior, const Eigen::Matrix<double, N, N>& posterior,
    const Eigen::Matrix<double, 6, N>& of_velocity, const Eigen::Matrix<double, N, 1>& step) {
  // Its regression on what was measured: what is learnt of the one tells about the other.
  const Eigen::Matrix<double, 6, N> regression =
      linear_algebra::solve_semidefinite<N, 6>(prior, of_velocity.transpose()).transpose();
  velocity_ += regression * step;
  covariance_.block<6, 6>(kVelocity, kVelocity) -=
      regression * (prior - posterior) * regression.transpose();
  return regression * posterior;
}

void PoseBelief::update(const geometry::SE3& T_rack_camera, const geometry::Matrix6d& covariance,
                        const std::optional<MapErrorSolution>& map) {
  const geometry::Vector6d step = pose_difference(pose_, T_rack_camera);
  pose_ = T_rack_camera;
  Eigen::Matrix<double, 6, 12> of_velocity = Eigen::Matrix<double, 6, 12>::Zero();
  MapErrorBelief now = this->map();
  if (map) {
    Matrix12d prior, posterior;
    prior << covariance_.topLeftCorner<6, 6>(), now.with_pose, now.with_pose.transpose(),
        now.covariance;
    // The map has no error along y: see the anchor.
    prior(6 + kY, 6 + kY) += kTinyVariance;
    posterior << covariance, map->with_pose, map->with_pose.transpose(), map->covariance;
    of_velocity << covariance_.block<6, 6>(kVelocity, 0), covariance_.block<6, 6>(kVelocity, kMap);
    Eigen::Matrix<double, 12, 1> steps;
    steps << step, map->mean;
    of_velocity = learn_velocity<12>(prior, posterior, of_velocity, steps);
    now = {map->covariance, map->with_pose};
  } else {
    of_velocity.leftCols<6>() = learn_velocity<6>(covariance_.topLeftCorner<6, 6>(), covariance,
                                                  covariance_.block<6, 6>(kVelocity, 0), step);
    now.with_pose.setZero();
  }
  covariance_.topLeftCorner<6, 6>() = covariance;
  set_map(now);
  covariance_.block<6, 6>(kVelocity, 0) = of_velocity.leftCols<6>();
  covariance_.block<6, 6>(0, kVelocity) = of_velocity.leftCols<6>().transpose();
  covariance_.block<6, 6>(kVelocity, kMap) = of_velocity.rightCols<6>();
  covariance_.block<6, 6>(kMap, kVelocity) = of_velocity.rightCols<6>().transpose();
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
}

void PoseBelief::begin_map() {
  covariance_.middleRows<6>(kMap) = covariance_.topRows<6>();
  covariance_.middleCols<6>(kMap) = covariance_.leftCols<6>();
  covariance_.row(kMap + kY).setZero();
  covariance_.col(kMap + kY).setZero();
}

void PoseBelief::set_map(const MapErrorBelief& map) {
  covariance_.middleRows<6>(kMap).setZero();
  covariance_.middleCols<6>(kMap).setZero();
  covariance_.block<6, 6>(kMap, kMap) = map.covariance;
  covariance_.block<6, 6>(0, kMap) = map.with_pose;
  covariance_.block<6, 6>(kMap, 0) = map.with_pose.transpose();
}

MapErrorBelief PoseBelief::map() const {
  return {covariance_.block<6, 6>(kMap, kMap), covariance_.block<6, 6>(0, kMap)};
}

geometry::Matrix6d PoseBelief::relative_covariance() const {
  const geometry::Matrix6d shared = covariance_.block<6, 6>(0, kMap);
  return covariance_.topLeftCorner<6, 6>() - shared - shared.transpose() +
         covariance_.block<6, 6>(kMap, kMap);
}

void PoseBelief::shift_along(double y) {
  pose_ = geometry::SE3(pose_.rotation(), pose_.translation() + y * Eigen::Vector3d::UnitY());
}

void PoseBelief::shift(const geometry::Vector6d& difference) {
  pose_ = moved_pose(pose_, difference);
}

}  // namespace pipescout::rack_vision
