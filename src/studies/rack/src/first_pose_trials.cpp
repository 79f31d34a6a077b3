// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/first_pose_trials.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "pipescout/rack_study/paper_flight.hpp"
#include "pipescout/rack_study/pose_run.hpp"
#include "pipescout/rack_vision/contour.hpp"
#include "pipescout/statistics/draw.hpp"

namespace pipescout::rack_study {
FirstPoseScore& FirstPoseScore::operator+=(const FirstPoseScore& other) noexcept {
  trials += other.trials;
  converged += other.converged;
  refused += other.refused;
  silent_wrong += other.silent_wrong;
  return *this;
}

FirstPoseScore try_first_poses(const FirstPoseSettings& settings, std::size_t trials,
                               std::uint64_t seed) {
  const auto model = paper_rack();
  const auto flight = paper_flight(model, {}, seed);
  const auto texture =
      simulation::random_texture_points(model, 25 * model.pipes.size(), seed, std::acos(0.0));
  const geometry::Camera camera;
  constexpr double kReach = 30;  // px
  simulation::RackFeatureCamera eye({.noise = 2,
                                     .quantised = true,
                                     .outlier_share = settings.outlier_share,
                                     .outlier_reach = kReach},
                                    camera, seed);
  rack_vision::PoseSolver solver(model);
  rack_vision::PoseSolution solution;
  simulation::RackFeatures features;
  statistics::Draw draw{statistics::Engine(seed)};
  FirstPoseScore score;
  for (std::size_t i = 0; i < trials; ++i) {
    const geometry::SE3& truth = flight[draw.index(flight.size())];
    geometry::Vector6d wrong;
    wrong << settings.position_error * draw.direction(),
        settings.orientation_error * draw.direction();
    eye.look(model, {}, truth, texture, features);
    rack_vision::PoseProblem problem;
    problem.T_camera_rack = rack_vision::moved(truth, wrong);
    problem.edges = features.edges;
    problem.points = features.points;
    solver.solve(camera, problem, solution);
    ++score.trials;
    if (solution.status != rack_vision::PoseStatus::kOk &&
        solution.status != rack_vision::PoseStatus::kUnobserved) {
      ++score.refused;
      continue;
    }
    constexpr double kFar = 7;  // standard deviations, for all six together
    const geometry::Vector6d error = pose_error(solution.T_camera_rack, truth);
    const bool good = error.dot(solution.covariance.ldlt().solve(error)) < kFar * kFar;
    ++(good ? score.converged : score.silent_wrong);
  }
  return score;
}

}  // namespace pipescout::rack_study
