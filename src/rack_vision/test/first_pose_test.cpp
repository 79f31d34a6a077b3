// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/first_pose.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "first_pose_scenes.hpp"

namespace pipescout::rack_vision {
namespace {

using geometry::Camera;
using geometry::SE3;
using test::Engine;
using test::FlightPose;
using test::PoseError;
using ::testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kDegree = std::numbers::pi / 180;
constexpr test::SegmentNoise kClean{
    .sigma = 0, .missing = 0, .parallel_lines = 0, .random_segments = 0};

FirstPoseHint heading_hint(double heading) {
  FirstPoseHint hint;
  hint.heading = FirstPoseHint::Value{heading, 10 * kDegree};
  return hint;
}

bool is_good(const PoseError& error) {
  return error.across < 0.03 && error.rotation < kDegree;
}

bool is_wrong(const PoseError& error) {
  return error.across > 0.1 || error.rotation > 3 * kDegree;
}

/// Contours of pipes along the flow that are seen over at least 40 pixels.
std::size_t visible_contours(const RackModel& model, const Camera& camera, const SE3& pose) {
  EdgeRenderer renderer;
  std::vector<VisibleEdge> edges;
  renderer.render(model, {}, camera, pose, edges);
  std::vector<EdgeId> contours;
  for (const VisibleEdge& edge : edges) {
    if (edge.id.kind == EdgeKind::kPipe && model.pipes[edge.id.body].direction.y() > 0.9 &&
        (edge.image_end - edge.image_start).norm() > 40) {
      const EdgeId contour{edge.id.kind, edge.id.body, 0, edge.id.side};
      if (std::ranges::find(contours, contour) == contours.end()) {
        contours.push_back(contour);
      }
    }
  }
  return contours.size();
}

struct Count {
  int solvable = 0;  ///< images with one contour more than there are unknowns
  int good = 0;
  int wrong = 0;
  int wrong_along = 0;  ///< place along the flow claimed and false
};

Count fly(const RackModel& model, bool with_heading, std::uint64_t first, std::uint64_t last) {
  const Camera camera;
  const FirstPoseFinder finder({});
  Count count;
  for (std::uint64_t seed = first; seed <= last; ++seed) {
    Engine engine(seed);
    const FlightPose pose = test::random_flight_pose(engine, model);
    const auto segments = test::segments_of(engine, model, camera, pose.T_camera_rack, {});
    const FirstPose found =
        finder.find(segments, model, {}, camera,
                    with_heading ? heading_hint(pose.heading + test::uniform(engine, -0.2, 0.2))
                                 : FirstPoseHint{});
    count.solvable += visible_contours(model, camera, pose.T_camera_rack) >= 4 ? 1 : 0;
    if (found.status != FirstPoseStatus::kFound) {
      continue;
    }
    const PoseError error = test::pose_error(found.candidates[0].T_camera_rack, pose.T_camera_rack);
    count.good += is_good(error) ? 1 : 0;
    count.wrong += is_wrong(error) ? 1 : 0;
    count.wrong_along += found.candidates[0].along_from_image && error.along > 0.1 ? 1 : 0;
  }
  return count;
}

TEST(FirstPose, IsExactOnSegmentsWithoutNoise) {
  const RackModel model = test::paper_rack();
  const Camera camera;
  Engine engine(1);
  const SE3 truth = test::looking_down({0.9, 2.1, 3}, 0.4, 0.1, -0.08);
  const FirstPose found = FirstPoseFinder({}).find(
      test::segments_of(engine, model, camera, truth, kClean), model, {}, camera, {});
  ASSERT_EQ(found.status, FirstPoseStatus::kFound);
  ASSERT_EQ(found.candidates.size(), 1U);
  const PoseError error = test::pose_error(found.candidates[0].T_camera_rack, truth);
  EXPECT_LT(error.across, 1e-6);
  EXPECT_LT(error.rotation, 1e-6);
  EXPECT_TRUE(found.candidates[0].along_from_image);
  EXPECT_LT(error.along, 1e-6);
}

TEST(FirstPose, WorksWhenTheLinesAreExactlyParallelInTheImage) {
  const RackModel model = test::paper_rack();
  const Camera camera;
  Engine engine(2);
  const SE3 truth = test::looking_down({0.9, 2.1, 3}, 0, 0, 0);
  const FirstPose found = FirstPoseFinder({}).find(
      test::segments_of(engine, model, camera, truth, kClean), model, {}, camera, {});
  ASSERT_EQ(found.status, FirstPoseStatus::kFound);
  EXPECT_LT(test::pose_error(found.candidates[0].T_camera_rack, truth).across, 1e-6);
}

TEST(FirstPose, IsFoundInNoiseAndClutterAndNeverSilentlyWrong) {
  for (const RackModel& model : {test::paper_rack(), test::small_rack()}) {
    const Count count = fly(model, true, 2001, 2100);
    EXPECT_GE(count.good, 0.95 * count.solvable);
    EXPECT_EQ(count.wrong, 0);
    EXPECT_EQ(count.wrong_along, 0);
  }
}

TEST(FirstPose, KnowsTheDirectionOfTheFlowWhereTheRackIsNotSymmetric) {
  const Count count = fly(test::paper_rack(), false, 2001, 2040);
  EXPECT_GE(count.good, 0.9 * count.solvable);
  EXPECT_EQ(count.wrong, 0);
}

RackModel symmetric_rack() {
  const std::vector<RowPipe> row{
      {"a", {{0, 0.15}, {10, 0.15}}}, {"b", {{0, 0.2}, {10, 0.2}}}, {"c", {{0, 0.15}, {10, 0.15}}}};
  RackModel model;
  model.pipes = row_of_pipes(row);
  return model;
}

TEST(FirstPose, OfASymmetricRackIsAmbiguousWithoutAHeading) {
  const RackModel model = symmetric_rack();
  const Camera camera;
  Engine engine(3);
  const SE3 truth = test::looking_down({0.3, 5, 3.2}, 1.0, 0.05, 0.1);
  const auto segments = test::segments_of(engine, model, camera, truth, {});
  const FirstPose unknown = FirstPoseFinder({}).find(segments, model, {}, camera, {});
  EXPECT_EQ(unknown.status, FirstPoseStatus::kAmbiguous);
  EXPECT_GE(unknown.candidates.size(), 2U);
  const FirstPose known = FirstPoseFinder({}).find(segments, model, {}, camera, heading_hint(1.1));
  ASSERT_EQ(known.status, FirstPoseStatus::kFound);
  EXPECT_TRUE(is_good(test::pose_error(known.candidates[0].T_camera_rack, truth)));
  EXPECT_FALSE(known.candidates[0].along_from_image);
}

TEST(FirstPose, OfEqualPipesIsAmbiguousUntilTheHintSaysWhichTheyAre) {
  std::vector<RowPipe> row;
  for (int i = 0; i < 6; ++i) {
    row.push_back({"pipe " + std::to_string(i), {{0, 0.15}, {10, 0.15}}, 0.2});
  }
  RackModel model;
  model.pipes = row_of_pipes(row);
  const Camera camera;
  Engine engine(4);
  // Sees the middle pipes and none of the ends of the row.
  const SE3 truth = test::looking_down({1.4, 5, 1.35}, 0.1, 0.02, -0.03);
  const auto segments = test::segments_of(engine, model, camera, truth, kClean);
  FirstPoseHint hint = heading_hint(0.1);
  EXPECT_NE(FirstPoseFinder({}).find(segments, model, {}, camera, hint).status,
            FirstPoseStatus::kFound);
  hint.x = FirstPoseHint::Value{1.45, 0.04};
  const FirstPose known = FirstPoseFinder({}).find(segments, model, {}, camera, hint);
  ASSERT_EQ(known.status, FirstPoseStatus::kFound);
  EXPECT_TRUE(is_good(test::pose_error(known.candidates[0].T_camera_rack, truth)));
}

TEST(FirstPose, TakesThePlaceAlongTheFlowFromTheHintWhenNothingElseTells) {
  const RackModel model = symmetric_rack();
  const Camera camera;
  Engine engine(5);
  const SE3 truth = test::looking_down({0.5, 5, 3}, 0.2, 0.05, 0.1);
  const auto segments = test::segments_of(engine, model, camera, truth, kClean);
  FirstPoseHint hint = heading_hint(0.2);
  const FirstPose without = FirstPoseFinder({}).find(segments, model, {}, camera, hint);
  ASSERT_EQ(without.status, FirstPoseStatus::kFound);
  EXPECT_GT(without.candidates[0].covariance(1, 1), 99.0 * 99.0);
  hint.y = FirstPoseHint::Value{5.3, 0.4};
  const FirstPose with = FirstPoseFinder({}).find(segments, model, {}, camera, hint);
  ASSERT_EQ(with.status, FirstPoseStatus::kFound);
  const SE3& found = with.candidates[0].T_camera_rack;
  EXPECT_NEAR(found.inverse().translation().y(), 5.3, 1e-6);
  EXPECT_NEAR(std::sqrt(with.candidates[0].covariance(1, 1)), 0.4, 0.05);
}

TEST(FirstPose, CovarianceCoversTheError) {
  const RackModel model = test::paper_rack();
  const Camera camera;
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 2001; seed <= 2060; ++seed) {
    Engine engine(seed);
    const FlightPose pose = test::random_flight_pose(engine, model);
    const auto segments = test::segments_of(engine, model, camera, pose.T_camera_rack, {});
    const FirstPose found =
        FirstPoseFinder({}).find(segments, model, {}, camera, heading_hint(pose.heading));
    if (found.status == FirstPoseStatus::kFound && found.candidates[0].along_from_image) {
      const FirstPoseCandidate& best = found.candidates[0];
      const geometry::Vector6d mu = (best.T_camera_rack.inverse() * pose.T_camera_rack).log();
      sum += mu.dot(best.covariance.inverse() * mu);
      ++count;
    }
  }
  ASSERT_GE(count, 30);
  EXPECT_LT(sum / count, 12);  // 6 for one that is true
}

TEST(FirstPose, SaysSoWhenThereIsNothingToSee) {
  const RackModel model = test::paper_rack();
  const Camera camera;
  const FirstPoseFinder finder({});
  EXPECT_EQ(finder.find({}, model, {}, camera, {}).status, FirstPoseStatus::kNotEnoughEdges);
  const std::vector<ImageSegment> bad{{{kNaN, 0}, {100, 100}, 10},
                                      {{0, 0}, {0, kNaN}, 10},
                                      {{5, 5}, {5, 5}, 10},
                                      {{0, 0}, {1e308, -1e308}, 10}};
  EXPECT_EQ(finder.find(bad, model, {}, camera, {}).status, FirstPoseStatus::kNotEnoughEdges);
}

TEST(FirstPose, IsNotFoundInClutterAlone) {
  const RackModel model = test::paper_rack();
  const Camera camera;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Engine engine(seed);
    const SE3 away = test::looking_down({40, 5, 3}, 0.3, 0, 0);
    auto segments = test::segments_of(engine, model, camera, away, {.random_segments = 60});
    for (int i = 0; i < 10; ++i) {  // lines in parallel, anywhere
      const double u = test::uniform(engine, 50, 670);
      segments.push_back({{u, 20}, {u + 3, 460}, 20});
    }
    EXPECT_NE(FirstPoseFinder({}).find(segments, model, {}, camera, {}).status,
              FirstPoseStatus::kFound)
        << seed;
  }
}

TEST(FirstPose, GivesTheSameBitsAgain) {
  const RackModel model = test::paper_rack();
  const Camera camera;
  Engine engine(6);
  const FlightPose pose = test::random_flight_pose(engine, model);
  const auto segments = test::segments_of(engine, model, camera, pose.T_camera_rack, {});
  const FirstPoseFinder finder({});
  const FirstPose first = finder.find(segments, model, {}, camera, {});
  const FirstPose again = finder.find(segments, model, {}, camera, {});
  ASSERT_EQ(first.candidates.size(), again.candidates.size());
  for (std::size_t i = 0; i < first.candidates.size(); ++i) {
    EXPECT_EQ(first.candidates[i].T_camera_rack.matrix(),
              again.candidates[i].T_camera_rack.matrix());
    EXPECT_EQ(first.candidates[i].covariance, again.candidates[i].covariance);
  }
}

template <typename Value>
void expect_refused(const char* field, const Value& value) {
  try {
    value.validate();
    ADD_FAILURE() << field;
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr(field));
  }
}

TEST(FirstPose, RefusesBadArguments) {
  for (const double bad : {0.0, -1.0, kNaN}) {
    expect_refused("smallest_height", FirstPoseParameters{.smallest_height = bad});
    expect_refused("pixel_tolerance", FirstPoseParameters{.pixel_tolerance = bad});
    expect_refused("segment_sigma", FirstPoseParameters{.segment_sigma = bad});
    expect_refused("shortest_segment", FirstPoseParameters{.shortest_segment = bad});
    expect_refused("largest_tilt", FirstPoseParameters{.largest_tilt = bad});
    expect_refused("smallest_score", FirstPoseParameters{.smallest_score = bad});
    expect_refused("largest_false_alarms", FirstPoseParameters{.largest_false_alarms = bad});
    expect_refused("rival_share", FirstPoseParameters{.rival_share = bad});
    expect_refused("unknown_along", FirstPoseParameters{.unknown_along = bad});
    expect_refused(
        "x.standard_deviation",
        FirstPoseHint{.x = FirstPoseHint::Value{0, bad}, .y = {}, .z = {}, .heading = {}});
  }
  expect_refused("largest_height", FirstPoseParameters{.largest_height = 0.4});
  expect_refused("largest_beside", FirstPoseParameters{.largest_beside = -1});
  expect_refused("largest_lines", FirstPoseParameters{.largest_lines = 65});
  expect_refused("smallest_matches", FirstPoseParameters{.smallest_matches = 3});
  expect_refused(
      "heading.value",
      FirstPoseHint{.x = {}, .y = {}, .z = {}, .heading = FirstPoseHint::Value{kNaN, 1}});
  const RackModel model = test::paper_rack();
  const std::vector<double> offsets{0, 0};
  EXPECT_THROW(static_cast<void>(FirstPoseFinder({}).find({}, model, offsets, Camera(), {})),
               std::invalid_argument);
  RackModel crossing = model;
  for (Pipe& pipe : crossing.pipes) {
    pipe.direction = Eigen::Vector3d::UnitX();
  }
  EXPECT_THROW(static_cast<void>(FirstPoseFinder({}).find({}, crossing, {}, Camera(), {})),
               std::invalid_argument);
}

TEST(FirstPoseStatus, HasWords) {
  EXPECT_STREQ(to_string(FirstPoseStatus::kFound), "found");
  EXPECT_STREQ(to_string(FirstPoseStatus::kAmbiguous), "ambiguous");
  EXPECT_STREQ(to_string(FirstPoseStatus::kNotEnoughEdges), "not enough edges");
  EXPECT_STREQ(to_string(static_cast<FirstPoseStatus>(9)), "unknown");
}

}  // namespace
}  // namespace pipescout::rack_vision
