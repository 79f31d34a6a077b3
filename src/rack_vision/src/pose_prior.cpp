// SPDX-License-Identifier: Apache-2.0
#include "pose_prior.hpp"

namespace pipescout::rack_vision {

using geometry::Matrix6d;
using geometry::Vector6d;

void add_pose_prior(const PoseProblem& problem, const SolverState& state,
                    const UnknownLayout& layout, SystemMatrix& information, SystemVector& gradient,
                    double& cost) {
  Vector6d expected_map_error = Vector6d::Zero();
  Matrix6d expected_by_pose = Matrix6d::Zero();
  if (problem.pose_prior) {
    const PosePrior& prior = *problem.pose_prior;
    const geometry::SE3 T_rack_camera = state.T_camera_rack.inverse();
    const geometry::SE3 T_rack_prior = prior.T_camera_rack.inverse();
    Vector6d difference;
    difference << T_rack_camera.translation() - T_rack_prior.translation(),
        (T_rack_camera.rotation() * T_rack_prior.rotation().inverse()).log();
    Matrix6d derivative = Matrix6d::Identity();
    derivative.bottomRightCorner<3, 3>() =
        geometry::SO3::left_jacobian_inverse(difference.tail<3>());
    const Matrix6d weighted = derivative.transpose() * prior.information;
    information.topLeftCorner<6, 6>() += weighted * derivative;
    gradient.head<6>() += weighted * difference;
    cost += 0.5 * difference.dot(prior.information * difference);
    if (problem.map_error) {
      expected_map_error = problem.map_error->by_pose * difference;
      expected_by_pose = problem.map_error->by_pose * derivative;
    }
  }
  if (layout.map_error < 0) {
    return;
  }
  const int k = layout.map_error;
  const Matrix6d& known = problem.map_error->information;
  const Vector6d difference = state.map_error - expected_map_error;
  const Vector6d weighted = known * difference;
  const Matrix6d coupling = known * expected_by_pose;
  information.block<6, 6>(k, k) += known;
  information.block<6, 6>(k, 0) -= coupling;
  information.block<6, 6>(0, k) -= coupling.transpose();
  information.topLeftCorner<6, 6>() += expected_by_pose.transpose() * coupling;
  gradient.segment<6>(k) += weighted;
  gradient.head<6>() -= expected_by_pose.transpose() * weighted;
  cost += 0.5 * difference.dot(weighted);
}

}  // namespace pipescout::rack_vision
