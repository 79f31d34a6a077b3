// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/offset_run.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "pipescout/rack_study/paper_flight.hpp"
#include "pipescout/simulation/rack_features.hpp"

namespace pipescout::rack_study {
namespace {

constexpr std::size_t kPipes = 4;
constexpr std::size_t kPointsPerPipe = 25;
constexpr double kPush = 0.03;     // m
constexpr double kCreep = 0.0002;  // m/s
/// What the model says too much: summed distances 15, 35, 50 cm instead of 10, 20, 30.
constexpr std::array<double, kPipes> kWrongBy{0, 0.05, 0.15, 0.20};

std::array<double, kPipes> true_offsets(OffsetScenario scenario, std::size_t frame) {
  std::array<double, kPipes> offsets{};
  if (scenario == OffsetScenario::kMovingPipes && frame >= kPushedAtFrame) {
    offsets[2] = kPush;
    offsets[3] = kCreep * kFramePeriod * static_cast<double>(frame - kPushedAtFrame);
  }
  return offsets;
}

}  // namespace

std::vector<OffsetFrame> run_offsets(const OffsetRunSettings& settings, std::uint64_t seed) {
  const auto model = parallel_rack(kPipes);
  const auto flight = paper_flight(model, {}, seed);
  const auto texture =
      simulation::random_texture_points(model, kPipes * kPointsPerPipe, seed, std::acos(0.0));
  const geometry::Camera camera;
  simulation::RackFeatureParameters measured;
  if (settings.noise) {
    measured.noise = 2;
    measured.quantised = true;
  }
  simulation::RackFeatureCamera eye(measured, camera, seed);
  const bool wrong_model = settings.scenario == OffsetScenario::kWrongModel;
  rack_vision::OffsetFilter filter(model, {.initial_deviation = wrong_model ? 0.2 : 0.002});
  if (wrong_model) {
    filter.reset(kWrongBy);
  }
  rack_vision::PoseSolver solver(model);
  rack_vision::PoseSolution solution;
  simulation::RackFeatures features;
  std::vector<OffsetFrame> run;
  geometry::SE3 last = flight.front();
  for (std::size_t frame = 0; frame < std::min(settings.frames, flight.size()); ++frame) {
    const auto truth = true_offsets(settings.scenario, frame);
    eye.look(model, truth, flight[frame], texture, features);
    filter.predict(frame > 0 ? kFramePeriod : 0);
    rack_vision::PoseProblem problem;
    problem.T_camera_rack = last;
    problem.edges = features.edges;
    problem.points = features.points;
    problem.offsets = filter.belief();
    solver.solve(camera, problem, solution);
    filter.update(solution);
    last = solution.T_camera_rack;

    Eigen::Vector3d error;
    Eigen::Matrix3d covariance;
    for (int i = 0; i < 3; ++i) {
      const auto pipe = static_cast<std::size_t>(i + 1);
      error[i] = filter.offsets()[pipe] - truth[pipe];
      covariance.row(i) = filter.belief().covariance.block<1, 3>(i + 1, 1);
    }
    run.push_back({.largest_error = error.cwiseAbs().maxCoeff(),
                   .step_error = std::abs(error[1]),
                   .consistency = error.dot(covariance.ldlt().solve(error))});
  }
  return run;
}

std::size_t frames_until(const std::vector<OffsetFrame>& run, double OffsetFrame::*error,
                         double limit, std::size_t from) {
  std::size_t last_above = from;
  for (std::size_t i = from; i < run.size(); ++i) {
    if (!(run[i].*error <= limit)) {
      last_above = i + 1;
    }
  }
  // The first image counts as one frame.
  return last_above < run.size() ? last_above - from + 1 : run.size();
}

}  // namespace pipescout::rack_study
