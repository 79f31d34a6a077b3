// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/first_pose.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "drawn_rack.hpp"

namespace pipescout::rack_vision {
namespace {

using geometry::Camera;
using geometry::SE3;
using geometry::SO3;
using test::DrawnImage;
using ::testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
using Engine = std::mt19937_64;

double uniform(Engine& engine, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(engine);
}

double heading_of(const SE3& T_rack_camera) {
  const Eigen::Vector3d right = T_rack_camera.rotation() * Eigen::Vector3d::UnitX();
  return std::atan2(right.y(), right.x());
}

/// GPS of 0.5 m and a compass of 0.2 rad, as far off as `engine` draws them.
FirstPoseHint hint_at(const SE3& T_rack_camera, Engine& engine) {
  std::normal_distribution<double> normal;
  const auto about = [&](double value, double deviation) {
    return FirstPoseHint::Value{value + deviation * normal(engine), deviation};
  };
  const Eigen::Vector3d& p = T_rack_camera.translation();
  return {.x = about(p.x(), 0.5),
          .y = about(p.y(), 0.5),
          .z = about(p.z(), 0.5),
          .heading = about(heading_of(T_rack_camera), 0.2)};
}

/// Somewhere over the rack, tilted by up to 10 degrees.
SE3 random_pose(Engine& engine) {
  const SE3 level = test::drawn_pose(uniform(engine, 0.4, 1.3), uniform(engine, 3, 7),
                                     uniform(engine, 2.4, 3.2), uniform(engine, -3, 3));
  const Eigen::Vector3d tilt(uniform(engine, -0.12, 0.12), uniform(engine, -0.12, 0.12), 0);
  return {level.rotation() * SO3::exp(tilt), level.translation()};
}

struct PoseError {
  double across = 0;    ///< worst of x and height, m
  double rotation = 0;  ///< rad
};

PoseError error_of(const FirstPoseCandidate& candidate, const SE3& T_rack_camera) {
  const SE3 found = candidate.T_camera_rack.inverse();
  const Eigen::Vector3d apart = found.translation() - T_rack_camera.translation();
  return {std::max(std::abs(apart.x()), std::abs(apart.z())),
          (found.rotation().inverse() * T_rack_camera.rotation()).log().norm()};
}

DrawnImage constant_image(const Camera& camera, std::uint8_t level) {
  DrawnImage image{camera.parameters().width, camera.parameters().height, {}};
  image.pixels.assign(
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height), level);
  return image;
}

TEST(FirstPose, IsFoundInDrawnImagesAndNeverSilentlyWrong) {
  const RackModel model = test::drawn_rack();
  const Camera camera = test::drawn_camera();
  const FirstPoseFinder finder({});
  constexpr int kImages = 12;
  int found = 0;
  double squares = 0;
  for (std::uint64_t seed = 1; seed <= kImages; ++seed) {
    Engine engine(seed);
    const SE3 truth = random_pose(engine);
    const DrawnImage image = test::draw(model, camera, truth);
    const FirstPose result = finder.find(image.view(), model, {}, camera, hint_at(truth, engine));
    if (result.status != FirstPoseStatus::kFound) {
      continue;
    }
    ++found;
    const FirstPoseCandidate& best = result.candidates.front();
    const PoseError error = error_of(best, truth);
    EXPECT_LT(error.across, 0.15) << seed;
    EXPECT_LT(error.rotation, 0.07) << seed;
    const geometry::Vector6d mu = (best.T_camera_rack.inverse() * truth.inverse()).log();
    squares += mu.dot(best.covariance.inverse() * mu);
  }
  EXPECT_GE(found, kImages / 2);
  EXPECT_LT(squares / found, 12);  // 6 for a covariance that is true
}

TEST(FirstPose, IsNotFoundWhereThereIsNoRack) {
  const RackModel model = test::drawn_rack();
  const Camera camera = test::drawn_camera();
  const FirstPoseFinder finder({});
  const FirstPoseHint anywhere;
  for (const std::uint8_t level : std::vector<std::uint8_t>{0, 128, 255}) {
    EXPECT_EQ(finder.find(constant_image(camera, level).view(), model, {}, camera, anywhere).status,
              FirstPoseStatus::kNotEnoughEdges);
  }
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Engine engine(seed);
    DrawnImage noise = constant_image(camera, 0);
    for (std::uint8_t& pixel : noise.pixels) {
      pixel = static_cast<std::uint8_t>(engine() % 256);
    }
    EXPECT_NE(finder.find(noise.view(), model, {}, camera, anywhere).status,
              FirstPoseStatus::kFound);
    // Stripes on the ground, all in one direction.
    DrawnImage stripes = constant_image(camera, 90);
    for (int i = 0; i < 8; ++i) {
      const int first = static_cast<int>(uniform(engine, 5, camera.parameters().width - 25));
      const int width = static_cast<int>(uniform(engine, 4, 20));
      const auto shade = static_cast<std::uint8_t>(uniform(engine, 20, 220));
      for (int v = 0; v < stripes.height; ++v) {
        std::fill_n(stripes.pixels.begin() + std::ptrdiff_t{v} * stripes.width + first, width,
                    shade);
      }
    }
    EXPECT_NE(finder.find(stripes.view(), model, {}, camera, anywhere).status,
              FirstPoseStatus::kFound)
        << seed;
  }
}

TEST(FirstPose, IsNotFoundOverOnePipe) {
  const RackModel model = test::drawn_rack();
  RackModel one = model;
  one.pipes.resize(1);
  const Camera camera = test::drawn_camera();
  Engine engine(1);
  const SE3 truth = test::drawn_pose(0.2, 5, 2.6, 0.3);
  EXPECT_NE(
      FirstPoseFinder({})
          .find(test::draw(one, camera, truth).view(), model, {}, camera, hint_at(truth, engine))
          .status,
      FirstPoseStatus::kFound);
}

TEST(FirstPose, OfASymmetricRackIsAmbiguousWithoutAHeading) {
  const std::vector<RowPipe> row{{"a", {{0, 0.15}, {10, 0.15}}},
                                 {"b", {{0, 0.2}, {10, 0.2}}},
                                 {"c", {{0, 0.2}, {10, 0.2}}},
                                 {"d", {{0, 0.15}, {10, 0.15}}}};
  RackModel model;
  model.pipes = row_of_pipes(row);
  const Camera camera = test::drawn_camera();
  const SE3 truth = test::drawn_pose(0.85, 5, 2.6, 0.4);
  const DrawnImage image = test::draw(model, camera, truth);
  FirstPoseHint hint;
  const FirstPose unknown = FirstPoseFinder({}).find(image.view(), model, {}, camera, hint);
  EXPECT_EQ(unknown.status, FirstPoseStatus::kAmbiguous);
  EXPECT_GE(unknown.candidates.size(), 2U);
  hint.heading = FirstPoseHint::Value{heading_of(truth) + 0.1, 0.2};
  const FirstPose known = FirstPoseFinder({}).find(image.view(), model, {}, camera, hint);
  ASSERT_EQ(known.status, FirstPoseStatus::kFound);
  EXPECT_LT(error_of(known.candidates[0], truth).across, 0.1);
  EXPECT_FALSE(known.candidates[0].along_from_image);
  EXPECT_GT(known.candidates[0].covariance(1, 1), 99.0 * 99.0);
}

TEST(FirstPose, TakesThePlaceAlongTheFlowFromTheHintWhenNothingElseTells) {
  const RackModel model = test::drawn_rack();
  const Camera camera = test::drawn_camera();
  const SE3 truth = test::drawn_pose(0.85, 5, 2.6, 0.2);
  FirstPoseHint hint;
  hint.y = FirstPoseHint::Value{5.3, 0.4};
  hint.heading = FirstPoseHint::Value{heading_of(truth), 0.2};
  const FirstPose found =
      FirstPoseFinder({}).find(test::draw(model, camera, truth).view(), model, {}, camera, hint);
  ASSERT_EQ(found.status, FirstPoseStatus::kFound);
  EXPECT_NEAR(found.candidates[0].T_camera_rack.inverse().translation().y(), 5.3, 1e-6);
  EXPECT_NEAR(std::sqrt(found.candidates[0].covariance(1, 1)), 0.4, 0.1);
}

TEST(FirstPose, GivesTheSameBitsAgain) {
  const RackModel model = test::drawn_rack();
  const Camera camera = test::drawn_camera();
  const DrawnImage image = test::draw(model, camera, test::drawn_pose(0.85, 5, 2.6, 0.2));
  const FirstPoseFinder finder({});
  const FirstPose first = finder.find(image.view(), model, {}, camera, {});
  const FirstPose again = finder.find(image.view(), model, {}, camera, {});
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

TEST(FirstPose, RefusesBadParametersAndHints) {
  for (const double bad : {0.0, -1.0, kNaN}) {
    expect_refused("smallest_height", FirstPoseParameters{.smallest_height = bad});
    expect_refused("largest_tilt", FirstPoseParameters{.largest_tilt = bad});
    expect_refused("typical_tilt", FirstPoseParameters{.typical_tilt = bad});
    expect_refused("edge_sigma", FirstPoseParameters{.edge_sigma = bad});
    expect_refused("shortest_segment", FirstPoseParameters{.shortest_segment = bad});
    expect_refused("smallest_score", FirstPoseParameters{.smallest_score = bad});
    expect_refused("smallest_evidence", FirstPoseParameters{.smallest_evidence = bad});
    expect_refused("rival_margin", FirstPoseParameters{.rival_margin = bad});
    expect_refused("largest_deviation", FirstPoseParameters{.largest_deviation = bad});
    expect_refused("unknown_along", FirstPoseParameters{.unknown_along = bad});
    expect_refused(
        "x.standard_deviation",
        FirstPoseHint{.x = FirstPoseHint::Value{0, bad}, .y = {}, .z = {}, .heading = {}});
  }
  expect_refused("largest_height", FirstPoseParameters{.largest_height = 0.4});
  expect_refused("largest_beside", FirstPoseParameters{.largest_beside = -1});
  expect_refused("smallest_matches", FirstPoseParameters{.smallest_matches = 2});
  expect_refused(
      "heading.value",
      FirstPoseHint{.x = {}, .y = {}, .z = {}, .heading = FirstPoseHint::Value{kNaN, 1}});
}

TEST(FirstPose, RefusesBadImagesAndRacks) {
  const RackModel model = test::drawn_rack();
  const Camera camera = test::drawn_camera();
  const DrawnImage image = constant_image(camera, 90);
  const FirstPoseFinder finder({});
  EXPECT_THROW(static_cast<void>(finder.find({}, model, {}, camera, {})), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(finder.find(image.view(), model, {}, Camera(), {})),
               std::invalid_argument);
  const std::vector<double> offsets{0, 0};
  EXPECT_THROW(static_cast<void>(finder.find(image.view(), model, offsets, camera, {})),
               std::invalid_argument);
  RackModel crossing = model;
  for (Pipe& pipe : crossing.pipes) {
    pipe.direction = Eigen::Vector3d::UnitX();
  }
  EXPECT_THROW(FirstPoseFinder::check(crossing), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(finder.find(image.view(), crossing, {}, camera, {})),
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
