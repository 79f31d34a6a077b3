// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/offset_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "feature_scene.hpp"

namespace pipescout::rack_vision {
namespace {

PoseSolution solution_with(const OffsetBelief& belief, double mean, double variance) {
  PoseSolution solution;
  solution.status = PoseStatus::kOk;
  solution.offsets = belief;
  solution.offsets.mean[1] = mean;
  solution.offsets.covariance(1, 1) = variance;
  return solution;
}

TEST(OffsetFilter, BeginsAtTheModelAndCreeps) {
  OffsetFilter filter(test::row_rack(3), {.initial_deviation = 0.02, .creep = 0.001});
  EXPECT_EQ(filter.offsets().size(), 3U);
  EXPECT_EQ(filter.belief().covariance(0, 0), 0) << "the first pipe is the frame";
  EXPECT_DOUBLE_EQ(filter.belief().covariance(1, 1), 0.02 * 0.02);
  filter.predict(4);
  EXPECT_DOUBLE_EQ(filter.belief().covariance(1, 1), 0.02 * 0.02 + 4e-6);
  filter.predict(-1);
  filter.predict(std::numeric_limits<double>::quiet_NaN());
  EXPECT_DOUBLE_EQ(filter.belief().covariance(1, 1), 0.02 * 0.02 + 4e-6);
}

TEST(OffsetFilter, TakesOverThePosteriorOfGoodSolutionsOnly) {
  OffsetFilter filter(test::row_rack(3));
  auto solution = solution_with(filter.belief(), 0.01, 1e-6);
  solution.status = PoseStatus::kNotConverged;
  filter.update(solution);
  EXPECT_EQ(filter.offsets()[1], 0);
  solution.status = PoseStatus::kOk;
  filter.update(solution);
  EXPECT_EQ(filter.offsets()[1], 0.01);
  EXPECT_EQ(filter.belief().covariance(1, 1), 1e-6);
}

TEST(OffsetFilter, BelievesAContradictionWhenItIsRepeated) {
  OffsetFilter filter(test::row_rack(3), {.images_to_move = 2});
  auto solution = solution_with(filter.belief(), 0.1, 1e-6);
  solution.offset_moved.set(1);
  const double before = filter.belief().covariance(1, 1);
  filter.update(solution);
  EXPECT_EQ(filter.offsets()[1], 0);
  EXPECT_EQ(filter.belief().covariance(1, 1), before);
  filter.update(solution);
  EXPECT_EQ(filter.offsets()[1], 0.1);
}

TEST(OffsetFilter, SmallInnovationsOfOneSignAddUp) {
  OffsetFilter filter(test::row_rack(3), {.initial_deviation = 0.001});
  auto solution = solution_with(filter.belief(), 0, 1e-6);
  solution.offset_observed.set(1);
  solution.innovation_deviation[1] = 0.004;
  solution.offset_innovation[1] = 0.008;
  double widest = 0;
  for (int i = 0; i < 10; ++i) {
    filter.update(solution);
    widest = std::max(widest, filter.belief().covariance(1, 1));
  }
  EXPECT_GT(std::sqrt(widest), 0.008);
  filter.reset(std::vector<double>(3, 0.0));
  for (int i = 0; i < 50; ++i) {
    solution.offset_innovation[1] = i % 2 == 0 ? 0.008 : -0.008;
    filter.update(solution);
    EXPECT_EQ(filter.belief().covariance(1, 1), 1e-6) << "not those of changing sign";
  }
}

TEST(OffsetFilter, ConvergesFromAWrongModelInFiveFrames) {
  const RackModel model = test::row_rack(4);
  const std::vector<double> truth{0, -0.05, -0.15, -0.20};
  PoseSolver solver(model);
  OffsetFilter filter(model, {.initial_deviation = 0.2});
  test::Engine engine(1);
  const auto texture = test::texture(model, 25, engine);
  const geometry::Camera camera;
  geometry::SE3 last = test::above();
  PoseSolution solution;
  for (int frame = 0; frame < 5; ++frame) {
    const geometry::SE3 pose = test::above(0.6 + 0.02 * frame, 5, 2.7);
    const auto features = test::measure(model, truth, texture, pose, {}, engine);
    filter.predict(frame > 0 ? 0.04 : 0);
    PoseProblem problem = features.problem(last);
    problem.offsets = filter.belief();
    solver.solve(camera, problem, solution);
    filter.update(solution);
    last = solution.T_camera_rack;
  }
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(filter.offsets()[i], truth[i], 0.001);
  }
}

TEST(OffsetFilter, RefusesWrongOffsetsAndParameters) {
  OffsetFilter filter(test::row_rack(3));
  EXPECT_THROW(filter.reset(std::vector<double>(2, 0.0)), std::invalid_argument);
  EXPECT_THROW(filter.reset(std::vector<double>(3, INFINITY)), std::invalid_argument);
  EXPECT_THROW(OffsetFilter(test::row_rack(3), {.creep = -1}), std::invalid_argument);
  EXPECT_THROW(OffsetFilter(test::row_rack(3), {.initial_deviation = 0}), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::rack_vision
