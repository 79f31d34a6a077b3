// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/rack_model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "rack_scenes.hpp"

namespace pipescout::rack_vision {
namespace {

using Eigen::Vector3d;
using ::testing::AllOf;
using ::testing::HasSubstr;
using Part = InvalidRack::Part;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(RowOfPipes, LeavesTheGapsBetweenThePipes) {
  const std::vector<RowPipe> row{{"a", {{0, 0.15}, {10, 0.15}}}, {"b", {{0, 0.2}, {10, 0.2}}, 0.1}};
  const std::vector<Pipe> pipes = row_of_pipes(row);
  EXPECT_DOUBLE_EQ(pipes[0].start.x(), 0.15);
  EXPECT_DOUBLE_EQ(pipes[1].start.x(), 0.3 + 0.1 + 0.2);
  EXPECT_FALSE(pipes[0].movable);
  EXPECT_TRUE(pipes[1].movable);
}

TEST(RowOfPipes, CountsGapsFromTheWidestPlaces) {
  const std::vector<RowPipe> row{{"a", {{0, 0.15}, {5, 0.15}, {5, 0.2}, {10, 0.2}}},
                                 {"b", {{0, 0.1}, {10, 0.1}}, 0.05}};
  const std::vector<Pipe> pipes = row_of_pipes(row);
  EXPECT_DOUBLE_EQ(pipes[0].start.x(), 0.2);
  EXPECT_DOUBLE_EQ(pipes[0].start.z(), 0.2);
  EXPECT_DOUBLE_EQ(pipes[1].start.x(), 0.4 + 0.05 + 0.1);
}

TEST(RowOfPipes, RefusesPipesAndGapsThatCannotBe) {
  const std::vector<RadiusAt> radii{{0, 0.1}, {1, 0.1}};
  for (const double gap : {-0.1, kNaN}) {
    const std::vector<RowPipe> row{{"a", radii}, {"b", radii, gap}};
    EXPECT_THROW((void)row_of_pipes(row), InvalidRack);
  }
  const std::vector<RowPipe> without_radii{{"a", {}}};
  EXPECT_THROW((void)row_of_pipes(without_radii), InvalidRack);
  EXPECT_TRUE(row_of_pipes({}).empty());
}

TEST(AppendSections, LeavesStepsOut) {
  const Pipe pipe{
      .name = "a", .start = {1, 2, 3}, .radii = {{0, 0.1}, {2, 0.1}, {2, 0.3}, {3, 0.2}}};
  std::vector<PipeSection> sections;
  append_sections(pipe, 0.5, sections);
  ASSERT_EQ(sections.size(), 2U);
  EXPECT_EQ(sections[0].start, Vector3d(1.5, 2, 3));
  EXPECT_EQ(sections[0].length, 2);
  EXPECT_EQ(sections[1].start, Vector3d(1.5, 4, 3));
  EXPECT_EQ(sections[1].radius_start, 0.3);
  EXPECT_EQ(sections[1].radius_end, 0.2);
}

struct Mistake {
  std::function<void(RackModel&)> make;
  Part part;
  std::size_t index;
  const char* message;
};

/// Each mistake alone, made in `small_rack`.
void expect_refused(const std::vector<Mistake>& mistakes) {
  for (const Mistake& mistake : mistakes) {
    RackModel model = test::small_rack();
    mistake.make(model);
    try {
      model.validate();
      ADD_FAILURE() << "accepted: " << mistake.message;
    } catch (const InvalidRack& error) {
      EXPECT_THAT(error.what(), HasSubstr(mistake.message));
      EXPECT_EQ(error.part(), mistake.part) << mistake.message;
      EXPECT_EQ(error.index(), mistake.index) << mistake.message;
    }
  }
}

TEST(RackModel, SaysWhatIsWrongWhere) {
  test::small_rack().validate();
  const std::vector<Mistake> mistakes{
      {[](RackModel& m) { m.pipes.clear(); }, Part::kRack, 0, "0 pipes; it must have 1 to 32"},
      {[](RackModel& m) { m.pipes.resize(33); }, Part::kRack, 0, "33 pipes"},
      {[](RackModel& m) { m.supports.resize(65); }, Part::kRack, 0, "65 supports"},
      {[](RackModel& m) {
         for (int i = 1; i < 140; ++i) {
           m.pipes[1].radii.push_back({10.0 + i, 0.15});
         }
       },
       Part::kRack, 0, "sections of pipes; it must have at most 128"},
      {[](RackModel& m) { m.pipes[1].name.clear(); }, Part::kPipe, 1, "name is empty"},
      {[](RackModel& m) { m.pipes[2].name = "a"; }, Part::kPipe, 2, "also that of number 0"},
      {[](RackModel& m) { m.supports[3].name = "beam 1"; }, Part::kSupport, 3, "number 1"},
      {[](RackModel& m) { m.pipes[1].start.y() = kNaN; }, Part::kPipe, 1, "start.y is nan"},
      {[](RackModel& m) { m.pipes[1].start.z() = 1e6; }, Part::kPipe, 1, "start.z is 1e+06"},
      {[](RackModel& m) { m.pipes[1].direction *= 1.001; }, Part::kPipe, 1, "norm of direction"},
      {[](RackModel& m) { m.pipes[1].direction.x() = kNaN; }, Part::kPipe, 1, "norm of direction"},
      {[](RackModel& m) { m.pipes[1].radii.resize(1); }, Part::kPipe, 1, "radii has 1 entries"},
      {[](RackModel& m) { m.pipes[1].radii[1].radius = -0.1; }, Part::kPipe, 1,
       "pipe 1 'b': radii[1].radius is -0.1; it must be above 0"},
      {[](RackModel& m) { m.pipes[1].radii[0].radius = kNaN; }, Part::kPipe, 1, "radius is nan"},
      {[](RackModel& m) { m.pipes[1].radii[0].along = 1; }, Part::kPipe, 1, "radii[0].along is 1"},
      {[](RackModel& m) { m.pipes[0].radii[2].along = 3; }, Part::kPipe, 0, "radii[2].along is 3"},
      {[](RackModel& m) { m.pipes[1].radii[1].along = 0; }, Part::kPipe, 1, "length of the pipe"},
      {[](RackModel& m) { m.pipes[0].movable = true; }, Part::kPipe, 0, "for the first pipe"},
      {[](RackModel& m) { m.pipes[4].movable = true; }, Part::kPipe, 4, "runs along x"},
      {[](RackModel& m) { m.supports[2].highest_corner.z() = -0.15; }, Part::kSupport, 2,
       "highest_corner.z is -0.15"},
      {[](RackModel& m) { m.supports[2].lowest_corner.x() = kNaN; }, Part::kSupport, 2,
       "lowest_corner.x is nan"},
      {[](RackModel& m) { m.pipes[2].start.x() -= 0.11; }, Part::kPipe, 2, "intersects pipe 1 'b'"},
      {[](RackModel& m) { m.pipes[4].start.z() -= 0.001; }, Part::kPipe, 4, "intersects pipe"},
  };
  expect_refused(mistakes);
}

TEST(RackModel, AcceptsDeviationsOfTheShapeUpToTheirLimits) {
  RackModel model = test::small_rack();
  EXPECT_FALSE(model.pipes[1].shape_deviation.any());
  const double third = model.pipes[1].smallest_radius() / 3;
  model.pipes[1].shape_deviation = {
      .height = kMostHeightDeviation, .direction = kMostDirectionDeviation, .radius = third};
  model.pipes[4].shape_deviation.height = 0.01;
  EXPECT_NO_THROW(model.validate());
  EXPECT_TRUE(model.pipes[1].shape_deviation.any());
}

TEST(RackModel, SaysWhichDeviationOfAShapeIsWrong) {
  const std::vector<Mistake> mistakes{
      {[](RackModel& m) { m.pipes[1].shape_deviation.height = -0.01; }, Part::kPipe, 1,
       "pipe 1 'b': height_deviation is -0.01; it must be 0 to 0.3 m"},
      {[](RackModel& m) { m.pipes[1].shape_deviation.height = 0.31; }, Part::kPipe, 1,
       "pipe 1 'b': height_deviation is 0.31; it must be 0 to 0.3 m"},
      {[](RackModel& m) { m.pipes[2].shape_deviation.height = kNaN; }, Part::kPipe, 2,
       "pipe 2 'c': height_deviation is nan"},
      {[](RackModel& m) { m.pipes[2].shape_deviation.direction = -0.001; }, Part::kPipe, 2,
       "pipe 2 'c': direction_deviation is -0.001; it must be 0 to 0.1 rad"},
      {[](RackModel& m) { m.pipes[2].shape_deviation.direction = 0.11; }, Part::kPipe, 2,
       "pipe 2 'c': direction_deviation is 0.11; it must be 0 to 0.1 rad"},
      {[](RackModel& m) { m.pipes[3].shape_deviation.direction = kNaN; }, Part::kPipe, 3,
       "pipe 3 'd': direction_deviation is nan"},
      {[](RackModel& m) { m.pipes[1].shape_deviation.radius = -0.02; }, Part::kPipe, 1,
       "pipe 1 'b': radius_deviation is -0.02; it must be at least 0 m"},
      {[](RackModel& m) { m.pipes[1].shape_deviation.radius = 0.051; }, Part::kPipe, 1,
       "pipe 1 'b': radius_deviation is 0.051; it must be at least 0 m, and at most a third"},
      {[](RackModel& m) {
         m.pipes[3].radii[1].radius = 0.09;  // smaller at its end: that counts
         m.pipes[3].shape_deviation.radius = 0.04;
       },
       Part::kPipe, 3, "pipe 3 'd': radius_deviation is 0.04"},
      {[](RackModel& m) { m.pipes[1].shape_deviation.radius = kNaN; }, Part::kPipe, 1,
       "pipe 1 'b': radius_deviation is nan"},
      {[](RackModel& m) { m.pipes[0].shape_deviation.height = 0.01; }, Part::kPipe, 0,
       "pipe 0 'a': deviations of its shape must be 0 for the first pipe"},
      {[](RackModel& m) { m.pipes[0].shape_deviation.direction = 0.01; }, Part::kPipe, 0,
       "pipe 0 'a': deviations of its shape must be 0 for the first pipe"},
      {[](RackModel& m) { m.pipes[0].shape_deviation.radius = 0.01; }, Part::kPipe, 0,
       "pipe 0 'a': deviations of its shape must be 0 for the first pipe"},
  };
  expect_refused(mistakes);
}

TEST(RackModel, HasNoHeightOfAPipeSteeperThan45Degrees) {
  const auto leaning = [](double degrees) {
    const double angle = degrees * std::numbers::pi / 180;
    RackModel model = test::small_rack();
    model.pipes.push_back({.name = "leaning",
                           .start = {5, 0, 1},
                           .direction = {std::cos(angle), 0, -std::sin(angle)},
                           .radii = {{0, 0.1}, {2, 0.1}},
                           .movable = false,
                           .shape_deviation = {.height = 0.02, .direction = 0.01, .radius = 0.01}});
    return model;
  };
  EXPECT_NO_THROW(leaning(44).validate());
  for (const double degrees : {46.0, 90.0}) {
    RackModel steep = leaning(degrees);
    EXPECT_THAT([&steep] { steep.validate(); },
                ::testing::ThrowsMessage<InvalidRack>(
                    HasSubstr("pipe 5 'leaning': height_deviation must be 0 for a pipe steeper")));
    steep.pipes.back().shape_deviation.height = 0;
    EXPECT_NO_THROW(steep.validate()) << degrees;
  }
}

/// Two pipes of radius 0.1, the first along y from (0, 0, 0) to (0, 10, 0).
RackModel pair(const Vector3d& start, const Vector3d& direction, double length = 10) {
  RackModel model;
  model.pipes.push_back({.name = "a", .radii = {{0, 0.1}, {10, 0.1}}, .movable = false});
  model.pipes.push_back({.name = "b",
                         .start = start,
                         .direction = direction.normalized(),
                         .radii = {{0, 0.1}, {length, 0.1}},
                         .movable = false});
  return model;
}

TEST(RackModel, LetsPipesTouch) {
  EXPECT_NO_THROW(pair({0.2, 0, 0}, {0, 1, 0}).validate()) << "side by side";
  EXPECT_NO_THROW(pair({0.2, 0, 0}, {0, -1, 0}).validate()) << "side by side at one place";
  EXPECT_NO_THROW(pair({0, 10, 0}, {0, 1, 0}).validate()) << "end to end";
  EXPECT_NO_THROW(pair({-5, 5, 0.2}, {1, 0, 0}).validate()) << "across";
  EXPECT_NO_THROW(pair({-5, 0, 0.2}, {1, 1, 0}).validate()) << "across at an angle";
  EXPECT_NO_THROW(pair({0.1, 5, 0}, {1, 0, 0}).validate()) << "a branch";
  EXPECT_NO_THROW(pair({0, 3, 0.1}, {0, 0, 1}).validate()) << "upright";
}

TEST(RackModel, RefusesPipesThatRunIntoEachOtherByTenMicrometres) {
  EXPECT_THROW(pair({0.19999, 0, 0}, {0, 1, 0}).validate(), InvalidRack);
  EXPECT_THROW(pair({0, 9.99999, 0}, {0, 1, 0}).validate(), InvalidRack);
  EXPECT_THROW(pair({-5, 5, 0.19999}, {1, 0, 0}).validate(), InvalidRack);
  EXPECT_THROW(pair({-5, 0, 0.19999}, {1, 1, 0}).validate(), InvalidRack);
  EXPECT_THROW(pair({0.09999, 5, 0}, {1, 0, 0}).validate(), InvalidRack);
  EXPECT_THROW(pair({0, 3, 0.05}, {0, 0, 1}, 0.01).validate(), InvalidRack) << "one in the other";
}

TEST(RackModel, KnowsThatPipesEnd) {
  // The axes meet, beyond the end of one of them.
  EXPECT_NO_THROW(pair({0.11, 5, 0}, {1, 0, 0}).validate());
  EXPECT_NO_THROW(pair({0, 10.5, 0}, {1, 0, 0}).validate());
  // So near to the end that a round one would reach it.
  EXPECT_NO_THROW(pair({0, 10.11, -1}, {0, 0, 1}).validate());
  EXPECT_THROW(pair({0, 10.09, -1}, {0, 0, 1}).validate(), InvalidRack);
}

TEST(RackModel, KnowsHowWideAReducerIsWhereAnotherPipeCrosses) {
  RackModel model = pair({-5, 2, 0.31}, {1, 0, 0});
  model.pipes[0].radii = {{0, 0.1}, {10, 0.5}};
  // Beside y = 2 the cone has a radius of 0.18: its surface, at an angle, keeps the other away.
  EXPECT_NO_THROW(model.validate());
  model.pipes[1].start.z() = 0.28;
  EXPECT_THROW(model.validate(), InvalidRack);
  model.pipes[1].start.y() = 0.5;
  EXPECT_NO_THROW(model.validate());
}

TEST(RackModel, JudgesRandomPairsAsTheirAxesDo) {
  // Infinite cylinders run into each other when their axes are nearer than their radii together;
  // the ends of these are far from there.
  test::Engine engine(11);
  int together = 0;
  for (int i = 0; i < 300; ++i) {
    const double angle = test::uniform(engine, 0.1, 3.0);
    const double depth = std::pow(10, test::uniform(engine, -4.5, -1));
    const double height = 0.2 + (i % 2 == 0 ? depth : -depth);
    const Vector3d direction(std::sin(angle), std::cos(angle), 0);
    RackModel model = pair(Vector3d(0, 5, height) - 5 * direction, direction);
    const bool apart = height > 0.2;
    together += apart ? 0 : 1;
    if (apart) {
      EXPECT_NO_THROW(model.validate()) << angle << ' ' << height;
    } else {
      EXPECT_THROW(model.validate(), InvalidRack) << angle << ' ' << height;
    }
  }
  EXPECT_GT(together, 100);
}

}  // namespace
}  // namespace pipescout::rack_vision
