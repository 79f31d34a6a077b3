// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/pose_run.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <random>

#include "pipescout/rack_study/pose_bound.hpp"
#include "pipescout/statistics/draw.hpp"

namespace pipescout::rack_study {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

double mean(double sum, std::size_t count) {
  return sum / static_cast<double>(count);
}

}  // namespace

PoseErrors& PoseErrors::operator+=(const PoseErrors& other) noexcept {
  frames += other.frames;
  position_square += other.position_square;
  orientation_square += other.orientation_square;
  position_norm += other.position_norm;
  orientation_norm += other.orientation_norm;
  position_bound += other.position_bound;
  orientation_bound += other.orientation_bound;
  consistency += other.consistency;
  not_ok += other.not_ok;
  without_points += other.without_points;
  return *this;
}

double PoseErrors::position_rms() const noexcept {
  return std::sqrt(mean(position_square, frames));
}

double PoseErrors::orientation_rms_degrees() const noexcept {
  return std::sqrt(mean(orientation_square, frames)) * kDegrees;
}

double PoseErrors::position_mean() const noexcept {
  return mean(position_norm, frames);
}

double PoseErrors::orientation_mean_degrees() const noexcept {
  return mean(orientation_norm, frames) * kDegrees;
}

double PoseErrors::position_ratio() const noexcept {
  return std::sqrt(position_square / position_bound);
}

double PoseErrors::orientation_ratio() const noexcept {
  return std::sqrt(orientation_square / orientation_bound);
}

geometry::Vector6d pose_error(const geometry::SE3& T_camera_rack, const geometry::SE3& truth) {
  const geometry::SE3 estimate = T_camera_rack.inverse();
  const geometry::SE3 reference = truth.inverse();
  geometry::Vector6d error;
  error << estimate.translation() - reference.translation(),
      (estimate.rotation() * reference.rotation().inverse()).log();
  return error;
}

PoseErrors run_poses(const rack_vision::RackModel& model, std::span<const geometry::SE3> flight,
                     const PoseRunSettings& settings, std::uint64_t seed) {
  const geometry::Camera camera;
  const auto texture =
      simulation::random_texture_points(model, settings.points, seed, settings.points_within);
  simulation::RackFeatureCamera eye(settings.camera, camera, seed);
  rack_vision::PoseSolver solver(model, settings.solver);
  simulation::RackFeatures features;
  rack_vision::PoseSolution solution;
  statistics::Engine engine(seed);
  PoseErrors errors;
  geometry::SE3 last = flight.front();
  for (const geometry::SE3& truth : flight) {
    eye.look(model, {}, truth, texture, features);
    rack_vision::PoseProblem problem;
    problem.T_camera_rack = last;
    problem.edges = features.edges;
    problem.points = features.points;
    geometry::Matrix6d along = geometry::Matrix6d::Zero();
    if (settings.along_deviation > 0) {
      geometry::Vector6d shift = geometry::Vector6d::Zero();
      shift[1] = settings.along_deviation * statistics::normal(engine);
      along(1, 1) = 1 / (settings.along_deviation * settings.along_deviation);
      problem.pose_prior = {rack_vision::moved(truth, shift), along};
    }
    solver.solve(camera, problem, solution);
    last = solution.T_camera_rack;
    const geometry::Vector6d error = pose_error(last, truth);
    ++errors.frames;
    errors.position_square += error.head<3>().squaredNorm();
    errors.orientation_square += error.tail<3>().squaredNorm();
    errors.position_norm += error.head<3>().norm();
    errors.orientation_norm += error.tail<3>().norm();
    errors.consistency += error.dot(solution.covariance.ldlt().solve(error));
    errors.not_ok += solution.status != rack_vision::PoseStatus::kOk &&
                             solution.status != rack_vision::PoseStatus::kUnobserved
                         ? 1
                         : 0;
    errors.without_points += features.points.empty() ? 1 : 0;
    if (settings.with_bound) {
      const geometry::Matrix6d bound = pose_bound(model, camera, truth, features, along);
      errors.position_bound += bound.topLeftCorner<3, 3>().trace();
      errors.orientation_bound += bound.bottomRightCorner<3, 3>().trace();
    }
  }
  return errors;
}

}  // namespace pipescout::rack_study
