// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_study/rack_bodies.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "pipescout/rack_study/image_flight.hpp"
#include "pipescout/rack_study/image_scene.hpp"
#include "pipescout/rack_study/image_score.hpp"

namespace pipescout::rack_study {
namespace {

TEST(FitOut, GivesValidBodiesAndAValidFileForEachSeed) {
  const rack_vision::RackModel rack = rack_on_beams();
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const FittedRack fitted = fit_out(rack, seed);
    EXPECT_NO_THROW(fitted.bodies.validate());
    EXPECT_NO_THROW(fitted.with_bodies.validate());
    EXPECT_GT(fitted.bodies.cylinders.size(), 30U);
    EXPECT_GE(fitted.bodies.boxes.size(), 1U);
  }
}

TEST(FitOut, PutsRingsAroundThePipes) {
  const rack_vision::RackModel rack = rack_without_beams(10);
  const FittedRack fitted = fit_out(rack, 1);
  for (std::size_t i = 0; i < rack.pipes.size(); ++i) {
    EXPECT_GE(fitted.with_bodies.pipes[i].largest_radius(), rack.pipes[i].largest_radius() + 0.03);
    EXPECT_DOUBLE_EQ(fitted.with_bodies.pipes[i].length(), rack.pipes[i].length());
  }
}

TEST(PeopleBeside, WalkToAndFro) {
  const rack_vision::RackModel rack = rack_without_beams(10);
  const auto at = [&](double time) { return people_beside(rack, 2, time); };
  EXPECT_EQ(at(0).size(), 2U);
  EXPECT_LT(at(0)[0].x(), rack.pipes.front().start.x());
  EXPECT_GT(at(0)[1].x(), rack.pipes.back().start.x());
  EXPECT_DOUBLE_EQ(at(4)[0].y(), 4);
  EXPECT_DOUBLE_EQ(at(12)[0].y(), 8);
  EXPECT_NEAR((at(3)[0] - at(23)[0]).norm(), 0, 1e-12);
}

class BodiesOnTheRack : public ::testing::TestWithParam<bool> {};

TEST_P(BodiesOnTheRack, DoNotMakeThePoseSilentlyWrong) {
  constexpr std::uint64_t kSeed = 5;
  ImageFlightSettings settings;
  settings.scene.model = rack_on_beams();
  settings.scene.bodies = fit_out(settings.scene.model, kSeed).bodies;
  settings.scene.people = 2;
  settings.flight.duration = 1.2;
  settings.way_points = inspection_way_points(settings.flight.duration, kSeed);
  if (GetParam()) {
    settings.mesh.emplace();
  }
  const auto score = score_flight(run_image_flight(settings, kSeed).frames);
  EXPECT_EQ(score.with_pose, score.images);
  EXPECT_EQ(score.silent_wrong, 0U);
}

TEST(BodiesOnTheRackOfRays, DoNotKeepTheFlightFromStarting) {
  // Seeds by which they hide so many contours that less than two of three samples are found.
  for (const std::uint64_t seed : {2, 19}) {
    ImageFlightSettings settings;
    settings.scene.model = rack_on_beams();
    settings.scene.bodies = fit_out(settings.scene.model, seed).bodies;
    settings.scene.people = 2;
    settings.flight.duration = 0.2;
    settings.way_points = inspection_way_points(60, seed);
    const auto score = score_flight(run_image_flight(settings, seed).frames);
    EXPECT_EQ(score.with_pose, score.images) << seed;
    EXPECT_EQ(score.silent_wrong, 0U) << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Renderers, BodiesOnTheRack, ::testing::Bool(),
                         [](const auto& test) { return test.param ? "Mesh" : "Rays"; });

}  // namespace
}  // namespace pipescout::rack_study
