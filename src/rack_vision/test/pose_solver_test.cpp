// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/pose_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "feature_scene.hpp"
#include "heap_guard.hpp"
#include "pipescout/rack_vision/contour.hpp"

namespace pipescout::rack_vision {
namespace {

using geometry::Matrix6d;
using geometry::SE3;
using geometry::Vector6d;
using test::Engine;
using test::Features;
using test::pose_error;
using test::uniform;

const geometry::Camera kCamera;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

PoseSolution solve(PoseSolver& solver, const PoseProblem& problem) {
  PoseSolution solution;
  solver.solve(kCamera, problem, solution);
  return solution;
}

/// Up to 5 cm and 5 deg beside the pose.
SE3 disturbed(const SE3& pose, Engine& engine) {
  Vector6d motion;
  for (int i = 0; i < 6; ++i) {
    motion[i] = uniform(engine, -1, 1) * (i < 3 ? 0.03 : 0.05);
  }
  return moved(pose, motion);
}

struct Statistics {
  int runs = 0;
  double position_square = 0, position_bound = 0, consistency = 0;
};

/// Many images with 2 px of noise; the bound is the covariance of least squares at the truth.
Statistics run_many(const PoseSolverParameters& parameters, double outlier_share, int runs = 150) {
  const RackModel model = test::row_rack(4);
  PoseSolver solver(model, parameters);
  PoseSolver bound_solver(model, {.kernel = statistics::RobustKernel::kNone});
  const SE3 truth = test::above();
  Statistics result;
  for (int seed = 1; seed <= runs; ++seed) {
    Engine engine(static_cast<std::uint64_t>(seed));
    const auto texture = test::texture(model, 8, engine);
    Features exact = test::measure(model, {}, texture, truth, {}, engine);
    for (auto& sample : exact.edges) {
      sample.sigma = 2;
    }
    for (auto& point : exact.points) {
      point.sigma = 2;
    }
    const Features noisy = test::measure(model, {}, texture, truth,
                                         {.sigma = 2, .outlier_share = outlier_share}, engine);
    const PoseSolution solution = solve(solver, noisy.problem(disturbed(truth, engine)));
    EXPECT_EQ(solution.status, PoseStatus::kOk);
    const Vector6d error = pose_error(solution.T_camera_rack, truth);
    const PoseSolution bound = solve(bound_solver, exact.problem(truth));
    ++result.runs;
    result.position_square += error.head<3>().squaredNorm();
    result.position_bound += bound.covariance.topLeftCorner<3, 3>().trace();
    result.consistency += error.dot(solution.covariance.ldlt().solve(error)) / 6;
  }
  return result;
}

TEST(PoseSolver, ExactFeaturesGiveTheExactPose) {
  const RackModel model = test::small_rack();
  PoseSolver solver(model);
  for (int seed = 1; seed <= 30; ++seed) {
    Engine engine(static_cast<std::uint64_t>(seed));
    const SE3 truth = disturbed(test::above(), engine);
    const Features features = test::measure(model, {}, {}, truth, {}, engine);
    const PoseSolution solution = solve(solver, features.problem(disturbed(truth, engine)));
    ASSERT_EQ(solution.status, PoseStatus::kOk);
    EXPECT_LT(pose_error(solution.T_camera_rack, truth).norm(), 1e-6);
    EXPECT_DOUBLE_EQ(solution.inlier_share, 1);
  }
}

TEST(PoseSolver, NearTheCramerRaoBoundWhenClean) {
  const Statistics s = run_many({}, 0);
  EXPECT_LT(std::sqrt(s.position_square / s.position_bound), 1.2);
  // Six degrees of freedom, 150 runs: a standard deviation of 0.047.
  EXPECT_NEAR(s.consistency / s.runs, 1, 0.19);
}

TEST(PoseSolver, HoldsAgainstThirtyPercentOfOutliers) {
  const Statistics clean = run_many({}, 0);
  const Statistics dirty = run_many({}, 0.3);
  EXPECT_LT(std::sqrt(dirty.position_square / clean.position_square), 1.6);
  EXPECT_LT(dirty.consistency / dirty.runs, 1.5);
  const Statistics plain = run_many({.kernel = statistics::RobustKernel::kNone}, 0.3);
  EXPECT_GT(plain.position_square, 4 * dirty.position_square) << "which least squares does not";
}

TEST(PoseSolver, HoldsToTheSigmasWhereMostEdgeSamplesAreOutliers) {
  const RackModel model = test::row_rack(4);
  PoseSolver widening(model, {.saliency_first = false});
  PoseSolver holding(model, {.saliency_first = false, .largest_edge_widening = 1});
  const SE3 truth = test::above();
  double widening_square = 0, holding_square = 0, clean_square = 0;
  for (int seed = 1; seed <= 50; ++seed) {
    Engine engine(static_cast<std::uint64_t>(seed));
    const auto texture = test::texture(model, 4, engine);
    Features clean = test::measure(model, {}, texture, truth, {.sigma = 0.5}, engine);
    Features most = clean;
    most.edges =
        test::measure(model, {}, {}, truth, {.sigma = 0.5, .outlier_share = 0.65}, engine).edges;
    const SE3 near = moved(truth, 0.02 * (disturbed(truth, engine) * truth.inverse()).log());
    const auto square = [&](PoseSolver& solver, const Features& features) {
      return pose_error(solve(solver, features.problem(near)).T_camera_rack, truth)
          .head<3>()
          .squaredNorm();
    };
    clean_square += square(holding, clean);
    holding_square += square(holding, most);
    widening_square += square(widening, most);
  }
  // A third of the samples is left.
  EXPECT_LT(std::sqrt(holding_square / clean_square), 2.5);
  EXPECT_GT(std::sqrt(widening_square / clean_square), 4);
}

TEST(PoseSolver, EdgesThatSpreadFartherThanTheirSigmasCountAsLittleAsThatAgainstAPrior) {
  constexpr double kSpread = 2.0;  // px, four times what the samples state
  const RackModel model = test::row_rack(4);
  PoseSolver weakened(model, {.spread_weakens_edges = true});
  PoseSolver plain(model, {});
  const SE3 truth = test::above();
  double weakened_off = 0, plain_off = 0;
  for (int seed = 1; seed <= 20; ++seed) {
    Engine engine(static_cast<std::uint64_t>(seed));
    const Features honest = test::measure(model, {}, {}, truth, {.sigma = kSpread}, engine);
    Features stated = honest;
    for (EdgeSample& sample : stated.edges) {
      sample.sigma = kSpread / 4;
    }
    PosePrior prior{.T_camera_rack = moved(truth, 0.02 * Vector6d::Unit(0))};
    prior.information = (1 / (0.01 * 0.01)) * geometry::Matrix6d::Identity();
    const auto found = [&](PoseSolver& solver, const Features& features) {
      PoseProblem problem = features.problem(truth);
      problem.pose_prior = prior;
      return solve(solver, problem);
    };
    const PoseSolution right = found(plain, honest);
    const PoseSolution by_spread = found(weakened, stated);
    const PoseSolution by_sigma = found(plain, stated);
    weakened_off += pose_error(by_spread.T_camera_rack, right.T_camera_rack).head<3>().norm();
    plain_off += pose_error(by_sigma.T_camera_rack, right.T_camera_rack).head<3>().norm();
    const Vector6d deviation = right.covariance.diagonal().cwiseSqrt();
    const Vector6d said = by_spread.covariance.diagonal().cwiseSqrt();
    EXPECT_LT((said - deviation).cwiseQuotient(deviation).cwiseAbs().maxCoeff(), 0.3) << seed;
  }
  EXPECT_LT(weakened_off, 0.2 * plain_off);
}

TEST(PoseSolver, PaperMethodsTakeOneStep) {
  const RackModel model = test::row_rack(4);
  Engine engine(3);
  const SE3 truth = test::above();
  const auto texture = test::texture(model, 8, engine);
  const Features features = test::measure(model, {}, texture, truth, {}, engine);
  const SE3 near = disturbed(truth, engine);
  for (const auto method :
       {SolverMethod::kLippielloLeastSquares, SolverMethod::kLippielloSaliency}) {
    PoseSolver solver(model, {.method = method});
    const PoseSolution solution = solve(solver, features.problem(near));
    EXPECT_EQ(solution.iterations, 1);
    EXPECT_LT(pose_error(solution.T_camera_rack, truth).norm(),
              0.3 * pose_error(near, truth).norm());
    EXPECT_GT(pose_error(solution.T_camera_rack, truth).norm(), 1e-9);
  }
}

TEST(PoseSolver, EdgesAloneDoNotSayWhereAlongThePipes) {
  RackModel model = test::row_rack(4);
  model.pipes[0].radii = {{0, 0.15}, {10, 0.15}};  // a reducer would say it
  PoseSolver solver(model);
  Engine engine(4);
  const SE3 truth = test::above();
  const Features features = test::measure(model, {}, {}, truth, {.sigma = 1}, engine);
  PoseProblem problem = features.problem(truth);
  const PoseSolution alone = solve(solver, problem);
  EXPECT_EQ(alone.status, PoseStatus::kOk);
  EXPECT_EQ(alone.unobserved_directions, 1);
  EXPECT_GT(std::abs(alone.weakest_direction.y()), 0.999);
  EXPECT_NEAR(alone.weakest_deviation, solver.parameters().largest_position_deviation, 1);
  EXPECT_LT(alone.covariance(0, 0), 0.1);

  PosePrior prior{.T_camera_rack = moved(truth, 0.2 * Vector6d::Unit(1))};
  prior.information(1, 1) = 1 / (0.5 * 0.5);
  problem.pose_prior = prior;
  const PoseSolution with_prior = solve(solver, problem);
  EXPECT_NEAR(pose_error(with_prior.T_camera_rack, truth)[1], 0.2, 0.01);
  EXPECT_NEAR(with_prior.weakest_deviation, 0.5, 0.01);
}

TEST(PoseSolver, OffsetsAreFoundJointly) {
  const RackModel model = test::row_rack(4);
  PoseSolver solver(model);
  Engine engine(5);
  const SE3 truth = test::above();
  const std::vector<double> offsets{0, 0.05, -0.03, 0.08};
  const auto texture = test::texture(model, 8, engine);
  const Features features = test::measure(model, offsets, texture, truth, {}, engine);
  PoseProblem problem = features.problem(disturbed(truth, engine));
  for (int i = 1; i < 4; ++i) {
    problem.offsets.covariance(i, i) = 1;
  }
  const PoseSolution solution = solve(solver, problem);
  ASSERT_EQ(solution.status, PoseStatus::kOk);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(solution.offsets.mean[i], offsets[i], 1e-4) << i;
    EXPECT_EQ(solution.offset_observed[i], i > 0);
  }
  EXPECT_FALSE(solution.offset_moved.any());
}

TEST(PoseSolver, APipeOutOfViewKeepsItsBelief) {
  const RackModel model = test::row_rack(4);
  PoseSolver solver(model);
  Engine engine(6);
  const SE3 truth = test::above();
  const auto texture = test::texture(model, 8, engine);
  Features features = test::measure(model, {}, texture, truth, {.sigma = 1}, engine);
  std::erase_if(features.edges, [](const EdgeSample& s) { return s.edge.body == 3; });
  std::erase_if(features.points, [](const PointObservation& p) { return p.pipe == 3; });
  PoseProblem problem = features.problem(truth);
  for (int i = 1; i < 4; ++i) {
    problem.offsets.covariance(i, i) = 0.01 * 0.01;
  }
  problem.offsets.mean[3] = 0.004;
  const PoseSolution solution = solve(solver, problem);
  EXPECT_EQ(solution.status, PoseStatus::kOk);
  EXPECT_FALSE(solution.offset_observed[3]);
  EXPECT_NEAR(solution.offsets.mean[3], 0.004, 1e-9);
  EXPECT_NEAR(solution.offsets.covariance(3, 3), 0.01 * 0.01, 1e-9);
}

TEST(PoseSolver, APipeThatMovedIsSaidAndDoesNotPullThePose) {
  const RackModel model = test::row_rack(4);
  PoseSolver solver(model);
  Engine engine(7);
  const SE3 truth = test::above();
  const auto texture = test::texture(model, 10, engine);
  const Features features =
      test::measure(model, {{0, 0, 0.06, 0}}, texture, truth, {.sigma = 0.5}, engine);
  PoseProblem problem = features.problem(truth);
  for (int i = 1; i < 4; ++i) {
    problem.offsets.covariance(i, i) = 1e-6;
  }
  const PoseSolution solution = solve(solver, problem);
  EXPECT_EQ(solution.offset_moved.to_ulong(), 1UL << 2);
  EXPECT_NEAR(solution.offsets.mean[2], 0.06, 0.01);
  const Vector6d error = pose_error(solution.T_camera_rack, truth);
  EXPECT_LT(error.dot(solution.covariance.ldlt().solve(error)), 30);
}

TEST(PoseSolver, TakesTheNearestCandidate) {
  const RackModel model = test::row_rack(4);
  PoseSolver solver(model);
  Engine engine(8);
  const SE3 truth = test::above();
  const auto texture = test::texture(model, 8, engine);
  Features features = test::measure(model, {}, texture, truth, {}, engine);
  for (EdgeSample& sample : features.edges) {
    sample.candidate_count = 3;
    sample.candidates[2] = sample.candidates[0];
    sample.candidates[0].x() += uniform(engine, 15, 30);
    sample.candidates[1] = sample.candidates[2] - Eigen::Vector2d(uniform(engine, 15, 30), 0);
  }
  const PoseSolution solution =
      solve(solver, features.problem(moved(truth, 0.005 * Vector6d::Ones())));
  EXPECT_LT(pose_error(solution.T_camera_rack, truth).norm(), 1e-6);
}

TEST(PoseSolver, IntrinsicsOnLine) {
  const RackModel model = test::small_rack();
  PoseSolver solver(model, {.iterations = 40});
  Engine engine(9);
  const SE3 truth = test::above();
  const Features features = test::measure(model, {}, {}, truth, {}, engine);
  PoseProblem problem = features.problem(truth);
  problem.intrinsics = IntrinsicsBelief{.mean = {640, 355, 244}};
  problem.intrinsics->covariance = Eigen::Vector3d(400, 100, 100).asDiagonal();
  const PoseSolution solution = solve(solver, problem);
  ASSERT_TRUE(solution.intrinsics);
  // The belief pulls a little; the error is within what is said.
  const Eigen::Vector3d error = solution.intrinsics->mean - Eigen::Vector3d(630, 360, 240);
  EXPECT_LT(error.dot(solution.intrinsics->covariance.ldlt().solve(error)), 9);
  EXPECT_LT(std::abs(error[0]), 5);
  EXPECT_LT(solution.intrinsics->covariance(0, 0), 400);
}

TEST(PoseSolver, ASharedErrorOfEdgesBoundsWhatManySamplesSay) {
  const RackModel model = test::row_rack(4);
  Engine engine(10);
  const SE3 truth = test::above();
  const auto texture = test::texture(model, 8, engine);
  PoseSolver without(model), with(model, {.edge_bias_sigma = 1});
  const Features features = test::measure(model, {}, texture, truth, {.sigma = 0.1}, engine, 200);
  const auto first = solve(without, features.problem(truth)).covariance;
  const auto second = solve(with, features.problem(truth)).covariance;
  EXPECT_GT(second(0, 0), 10 * first(0, 0));
}

TEST(PoseSolver, WhatTheEdgesSayHasNothingOfThePriorButTheOffsets) {
  const RackModel model = test::row_rack(4);
  PoseSolver solver(model);
  Engine engine(11);
  const SE3 truth = test::above();
  const auto texture = test::texture(model, 8, engine);
  const Features features = test::measure(model, {}, texture, truth, {.sigma = 1}, engine);
  PoseProblem problem = features.problem(truth);
  problem.points = {};
  const PoseSolution alone = solve(solver, problem);
  PosePrior prior{.T_camera_rack = truth};
  prior.information.diagonal().setConstant(1e8);
  problem.pose_prior = prior;
  problem.points = features.points;
  const PoseSolution with_others = solve(solver, problem);
  const Matrix6d& said = alone.edge_information;
  EXPECT_LT((with_others.edge_information - said).norm(), 0.05 * said.norm());
  Matrix6d with_along = said;
  with_along(1, 1) += 1;  // of which the edges say nothing
  EXPECT_NEAR(alone.covariance(2, 2) / with_along.inverse()(2, 2), 1, 0.2);
  for (int i = 1; i < 4; ++i) {
    problem.offsets.covariance(i, i) = 0.1 * 0.1;
  }
  const PoseSolution anywhere = solve(solver, problem);
  EXPECT_LT(anywhere.edge_information(0, 0), 0.6 * said(0, 0));
  EXPECT_GT(anywhere.edge_information(0, 0), 0.0);
}

TEST(PoseSolver, BadInputIsAStatus) {
  const RackModel model = test::row_rack(3);
  PoseSolver solver(model);
  Engine engine(11);
  const SE3 truth = test::above();
  const auto texture = test::texture(model, 4, engine);
  Features features = test::measure(model, {}, texture, truth, {.sigma = 1}, engine);

  EXPECT_EQ(solve(solver, PoseProblem{.T_camera_rack = truth}).status, PoseStatus::kNoFeatures);

  PoseProblem no_covariance = features.problem(truth);
  no_covariance.offsets.covariance(1, 1) = -1;
  EXPECT_EQ(solve(solver, no_covariance).status, PoseStatus::kBadInput);
  no_covariance.offsets.covariance(1, 1) = kNaN;
  EXPECT_EQ(solve(solver, no_covariance).status, PoseStatus::kBadInput);
  PoseProblem no_prior = features.problem(truth);
  no_prior.pose_prior = PosePrior{.T_camera_rack = truth};
  no_prior.pose_prior->information(2, 2) = kNaN;
  EXPECT_EQ(solve(solver, no_prior).status, PoseStatus::kBadInput);

  features.edges[0].candidates[0].x() = kNaN;
  features.edges[1].sigma = 0;
  features.edges[2].edge.body = 77;
  features.edges[3].candidate_count = 0;
  features.points[0].pixel.y() = std::numeric_limits<double>::infinity();
  features.points[1].pipe = 9;
  const PoseSolution rest = solve(solver, features.problem(truth));
  EXPECT_EQ(rest.refused, 6U);
  EXPECT_EQ(rest.status, PoseStatus::kOk);
  EXPECT_TRUE(rest.covariance.allFinite());
}

TEST(PoseSolver, OneEdgeIsNotEnoughAndSaidSo) {
  const RackModel model = test::row_rack(3);
  PoseSolver solver(model);
  Engine engine(12);
  const SE3 truth = test::above();
  Features features = test::measure(model, {}, {}, truth, {.sigma = 1}, engine);
  const EdgeId first = features.edges.front().edge;
  std::erase_if(features.edges, [&](const EdgeSample& s) { return !(s.edge == first); });
  const PoseSolution solution = solve(solver, features.problem(truth));
  EXPECT_EQ(solution.status, PoseStatus::kUnobserved);
  EXPECT_GE(solution.unobserved_directions, 3);
  EXPECT_TRUE(solution.covariance.allFinite());
  EXPECT_TRUE(solution.T_camera_rack.translation().allFinite());
}

TEST(PoseSolver, SameProblemSameBitsAndNoAllocation) {
  const RackModel model = test::row_rack(5);
  PoseSolver solver(model);
  Engine engine(13);
  const SE3 truth = test::above();
  const auto texture = test::texture(model, 10, engine);
  const Features features =
      test::measure(model, {}, texture, truth, {.sigma = 2, .outlier_share = 0.2}, engine);
  PoseProblem problem = features.problem(disturbed(truth, engine));
  for (int i = 1; i < 5; ++i) {
    problem.offsets.covariance(i, i) = 1e-4;
  }
  PoseSolution first, again;
  solver.solve(kCamera, problem, first);
  again = first;
  std::size_t allocations = 0;
  {
    const pipescout::test::HeapGuard guard;
    solver.solve(kCamera, problem, again);
    allocations = guard.allocations();
  }
  EXPECT_EQ(allocations, 0U);
  EXPECT_EQ(first.T_camera_rack.matrix(), again.T_camera_rack.matrix());
  EXPECT_EQ(first.covariance, again.covariance);
}

TEST(PoseSolverParameters, AreValidated) {
  const RackModel model = test::row_rack(2);
  const auto bad = [&](auto change) {
    PoseSolverParameters parameters;
    change(parameters);
    EXPECT_THROW(PoseSolver(model, parameters), std::invalid_argument);
  };
  bad([](auto& p) { p.kernel_width = 0; });
  bad([](auto& p) { p.saliency_nu = kNaN; });
  bad([](auto& p) { p.iterations = 0; });
  bad([](auto& p) { p.largest_edge_widening = 0.9; });
  bad([](auto& p) { p.gate = -1; });
  bad([](auto& p) { p.edge_bias_sigma = -0.1; });
  bad([](auto& p) { p.kernel = static_cast<statistics::RobustKernel>(99); });
}

}  // namespace
}  // namespace pipescout::rack_vision
