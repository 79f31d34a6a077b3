// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/shaped_pipes.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <stdexcept>

#include "pipescout/geometry/so3.hpp"
#include "pipescout/rack_study/paper_flight.hpp"

namespace pipescout::rack_study {
namespace {

using Eigen::Vector3d;
using rack_vision::Pipe;
using rack_vision::PipeShape;

Pipe pipe_along(const Vector3d& direction) {
  return {.name = "pipe",
          .start = {1, 2, 3},
          .direction = direction.normalized(),
          .radii = {{0, 0.2}, {4, 0.2}}};
}

/// `pipe` with its axis turned about its middle, raised and made thicker.
Pipe changed(const Pipe& pipe, const Vector3d& rotation, double height, double radius) {
  Pipe result = pipe;
  const double half = 0.5 * pipe.length();
  result.direction = geometry::SO3::exp(rotation) * pipe.direction;
  result.start =
      pipe.start + half * pipe.direction + height * Vector3d::UnitZ() - half * result.direction;
  for (auto& at : result.radii) {
    at.radius += radius;
  }
  return result;
}

constexpr double kSecondOrder = 1e-4;  // rad: tangents for angles

TEST(ShapeOf, ALevelPipeTurnsAboutRackZAndRisesAtItsEnd) {
  const Pipe file = pipe_along({0, 1, 0});
  const PipeShape turned = shape_of(changed(file, -0.01 * Vector3d::UnitZ(), 0.03, -0.02), file);
  EXPECT_NEAR(turned.turn_aside, 0.01, kSecondOrder) << "to the right";
  EXPECT_NEAR(turned.turn_up, 0, 1e-12);
  EXPECT_NEAR(turned.height, 0.03, 1e-12);
  EXPECT_NEAR(turned.radius, -0.02, 1e-12);
  const PipeShape raised = shape_of(changed(file, 0.01 * Vector3d::UnitX(), 0, 0), file);
  EXPECT_NEAR(raised.turn_aside, 0, 1e-12);
  EXPECT_NEAR(raised.turn_up, 0.01, kSecondOrder);
}

TEST(ShapeOf, AnyPipeWithTheShapeIsTheTrueOne) {
  for (const Vector3d& direction :
       {Vector3d(1, 0, 0), Vector3d(1, -2, 0.3), Vector3d(0, 1, 0.9), Vector3d(0, 0, -1)}) {
    const Pipe file = pipe_along(direction);
    const Pipe truth = changed(file, {0.02, -0.03, 0.01}, 0.01, 0.02);
    const Pipe again = rack_vision::shaped(file, shape_of(truth, file));
    EXPECT_LT((again.direction - truth.direction).norm(), 1e-12) << direction;
    EXPECT_LT((again.start - truth.start).norm(), 1e-12) << direction;
    EXPECT_NEAR(again.radii.back().radius, truth.radii.back().radius, 1e-12);
  }
}

ShapedPipesSettings short_flight(World world) {
  ShapedPipesSettings settings;
  settings.rack = parallel_rack(4);
  settings.world = world;
  settings.duration = 0.08;
  return settings;
}

class ShapedPipesIn : public ::testing::TestWithParam<World> {};

TEST_P(ShapedPipesIn, OnlyThePipesAskedForHaveOtherShapes) {
  const ShapedPipesSettings settings = short_flight(GetParam());
  const auto trial = try_shaped_pipes(settings, false, 3);
  ASSERT_EQ(trial.frames.size(), 2U);
  ASSERT_EQ(trial.shapes.size(), 4U);
  for (const std::size_t right : {0U, 2U}) {
    EXPECT_EQ(trial.shapes[right].height, 0);
    EXPECT_EQ(trial.shapes[right].turn_aside, 0);
    EXPECT_EQ(trial.shapes[right].turn_up, 0);
    EXPECT_EQ(trial.shapes[right].radius, 0);
  }
  for (const std::size_t wrong : {1U, 3U}) {
    const PipeShape& shape = trial.shapes[wrong];
    EXPECT_NE(shape.height, 0);
    EXPECT_NE(shape.turn_aside, 0);
    EXPECT_NE(shape.turn_up, 0);
    EXPECT_NE(shape.radius, 0);
    EXPECT_LE(std::abs(shape.height), 2 * settings.drawn.height);
    EXPECT_LE(std::abs(shape.radius), 2 * settings.drawn.radius + 1e-12);
    // Two errors of up to two sigma each.
    EXPECT_LE(std::hypot(shape.turn_aside, shape.turn_up),
              std::sqrt(8.0) * settings.drawn.direction + kSecondOrder);
  }
}

TEST_P(ShapedPipesIn, AreDrawnTheSameForASeedWhetherToldOrNot) {
  const ShapedPipesSettings settings = short_flight(GetParam());
  const auto pair = compare_shaped_pipes(settings, 7);
  for (const bool told : {true, false}) {
    const auto once = try_shaped_pipes(settings, told, 7);
    const auto& again = told ? pair.told : pair.not_told;
    ASSERT_EQ(once.frames.size(), again.frames.size());
    EXPECT_EQ(once.frames.back().error, again.frames.back().error);
    for (std::size_t i = 0; i < once.shapes.size(); ++i) {
      EXPECT_EQ(once.shapes[i].height, pair.told.shapes[i].height);
      EXPECT_EQ(once.shapes[i].turn_up, pair.told.shapes[i].turn_up);
    }
  }
}

TEST_P(ShapedPipesIn, AreFollowedWhereTheFileIsRight) {
  ShapedPipesSettings settings = short_flight(GetParam());
  settings.pipes.clear();
  settings.duration = 0.2;
  const auto trial = try_shaped_pipes(settings, true, 6);
  const auto score = score_shaped_pipes({&trial, 1});
  EXPECT_EQ(score.converged, 1U);
  EXPECT_EQ(score.silent_wrong, 0U);
  EXPECT_EQ(score.images.pose_covered_99, score.images.with_pose);
  EXPECT_LT(score.position_rms(), kWrongPosition);
}

INSTANTIATE_TEST_SUITE_P(Worlds, ShapedPipesIn, ::testing::Values(World::kRayCaster, World::kMesh));

TEST(ShapedPipes, UprightOnesHaveNoErrorOfHeight) {
  ShapedPipesSettings settings = short_flight(World::kRayCaster);
  settings.duration = 0.04;
  settings.rack.pipes.push_back({.name = "upright",
                                 .start = {-1, 5, -1},
                                 .direction = {0, 0, 1},
                                 .radii = {{0, 0.2}, {2, 0.2}},
                                 .movable = false});
  settings.pipes = {4};
  const auto trial = try_shaped_pipes(settings, true, 2);
  EXPECT_NEAR(trial.shapes[4].height, 0, 1e-12);
  EXPECT_NE(trial.shapes[4].turn_up, 0);
  EXPECT_NE(trial.shapes[4].radius, 0);
}

TEST(ShapedPipes, RefusesPipesAndDeviationsThatCannotBe) {
  ShapedPipesSettings settings = short_flight(World::kRayCaster);
  for (const std::size_t pipe : {0U, 4U}) {
    settings.pipes = {pipe};
    EXPECT_THROW((void)try_shaped_pipes(settings, true, 1), std::invalid_argument);
  }
  settings.pipes = {1};
  settings.drawn.height = 2 * rack_vision::kMostHeightDeviation;
  EXPECT_THROW((void)try_shaped_pipes(settings, false, 1), std::invalid_argument);
}

TEST(ShapedPipesScore, CountsWrongPosesThatTheCovarianceDenies) {
  FrameScore right;
  right.has_pose = true;
  right.pose_nees = 6;
  FrameScore wrong = right;
  wrong.error.x() = 2 * kWrongPosition;
  FrameScore silent = wrong;
  silent.pose_nees = 100;
  const std::array<ShapedPipesTrial, 3> trials{
      {{.frames = {right, silent, right}}, {.frames = {wrong}}, {.frames = {silent, {}}}}};
  ShapedPipesScore score = score_shaped_pipes(trials);
  EXPECT_EQ(score.trials, 3U);
  EXPECT_EQ(score.converged, 1U);
  EXPECT_EQ(score.lost, 1U);
  EXPECT_EQ(score.silent_wrong, 2U);
  EXPECT_EQ(score.images.with_pose, 5U);
  EXPECT_EQ(score.images.silent_wrong, 2U);
  EXPECT_EQ(score.images.pose_covered_99, 3U);
  EXPECT_NEAR(score.position_rms(), 2 * kWrongPosition * std::sqrt(3.0 / 5), 1e-12);
  score += score_shaped_pipes(std::span(trials).first(1));
  EXPECT_EQ(score.trials, 4U);
  EXPECT_EQ(score.converged, 2U);
  EXPECT_EQ(score.images.with_pose, 8U);
  EXPECT_EQ(ShapedPipesScore{}.position_rms(), 0);
}

TEST(ShapedPipesScore, CountsTheValuesOfShapesThatWereFound) {
  ShapedPipesTrial trial;
  trial.shapes.resize(3);
  trial.shapes[1].height = 0.02;
  const PipeShape deviation{.height = 0.002, .radius = 0.001};
  trial.estimates = {{.pipe = 1, .found = true, .shape = {.height = 0.01}, .deviation = deviation},
                     {.pipe = 2, .found = false, .shape = {}, .deviation = deviation}};
  const ShapedPipesScore score = score_shaped_pipes({&trial, 1});
  EXPECT_EQ(score.shapes, 2U);
  EXPECT_EQ(score.shapes_found, 1U);
  EXPECT_EQ(score.values, 2U);
  EXPECT_EQ(score.values_covered, 1U);
}

}  // namespace
}  // namespace pipescout::rack_study
