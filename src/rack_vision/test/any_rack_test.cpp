// SPDX-License-Identifier: Apache-2.0
// Racks at the limits of what a model may have: one pipe and a box, up to 32 pipes, one that looks
// the same from behind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "drawn_rack.hpp"
#include "pipescout/rack_vision/rack_localization.hpp"

namespace pipescout::rack_vision {
namespace {

using geometry::Matrix6d;
using geometry::SE3;
using ::testing::HasSubstr;

Matrix6d start_covariance() {
  geometry::Vector6d deviations;
  deviations << 0.01, 0.01, 0.01, 0.005, 0.005, 0.005;
  return deviations.cwiseAbs2().asDiagonal();
}

SE3 beside(const SE3& T_rack_camera) {
  return {geometry::SO3::about_y(0.004) * T_rack_camera.rotation(),
          T_rack_camera.translation() + Eigen::Vector3d(0.007, -0.008, 0.01)};
}

/// `count` pipes of 10 m and of three diameters.
RackModel row_of(int count) {
  std::vector<RowPipe> row;
  for (int i = 0; i < count; ++i) {
    const double radius = i % 3 == 0 ? 0.05 : i % 3 == 1 ? 0.08 : 0.06;
    row.push_back({"p" + std::to_string(i), {{0, radius}, {10, radius}}, i == 0 ? 0 : 0.06});
  }
  RackModel model;
  model.pipes = row_of_pipes(row);
  return model;
}

class RowsOf : public ::testing::TestWithParam<int> {};

TEST_P(RowsOf, ManyPipesAreTrackedFromEndToEnd) {
  const geometry::Camera camera = test::drawn_camera();
  const RackModel model = row_of(GetParam());
  model.validate();
  RackLocalization localization(model, camera);
  const double last = model.pipes.back().start.x();
  // Over the first pipes, over the last ones.
  for (const double x : {0.6, last - 0.6}) {
    const auto flight = [&](int k) { return test::drawn_pose(x + 0.006 * k, 4, 2.2, 0.1); };
    ASSERT_TRUE(localization.set_pose(beside(flight(0)), start_covariance()));
    for (int k = 0; k < 4; ++k) {
      const RackTrackerResult result = localization.track(
          test::noisy(test::draw(model, camera, flight(k)), 1.5, 1U + static_cast<unsigned>(k))
              .view(),
          x * 100 + 0.04 * k);
      ASSERT_EQ(result.status, TrackStatus::kTracking) << x << " " << k << ": " << result.reason;
      const Eigen::Vector3d error = result.T_rack_camera.translation() - flight(k).translation();
      EXPECT_LT(std::abs(error.x()), 0.02) << x << " " << k;
      EXPECT_LT(std::abs(error.z()), 0.02) << x << " " << k;
      EXPECT_EQ(result.offsets.size(), model.pipes.size());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Racks, RowsOf, ::testing::Values(17, 24, 32));

TEST(AnyRack, OnePipeAndABoxAreTracked) {
  RackModel model;
  model.pipes = row_of_pipes(std::vector<RowPipe>{{"a", {{0, 0.2}, {10, 0.2}}, 0}});
  model.supports = {{"box", {0.8, 4.6, 0}, {1.3, 5.2, 0.4}}};
  model.validate();
  const geometry::Camera camera = test::drawn_camera();
  RackLocalizationParameters parameters;
  parameters.find_first_pose = false;
  RackLocalization localization(model, camera, parameters);
  const auto flight = [](int k) { return test::drawn_pose(0.7 + 0.006 * k, 4.8, 2.6, 0.1); };
  ASSERT_TRUE(localization.set_pose(beside(flight(0)), start_covariance()));
  for (int k = 0; k < 6; ++k) {
    const RackTrackerResult result = localization.track(
        test::noisy(test::draw(model, camera, flight(k)), 1.5, 1U + static_cast<unsigned>(k))
            .view(),
        0.04 * k);
    ASSERT_EQ(result.status, TrackStatus::kTracking) << k << ": " << result.reason;
    EXPECT_LT((result.T_rack_camera.translation() - flight(k).translation()).norm(), 0.03) << k;
  }
}

TEST(AnyRack, OneThatLooksTheSameFromBehindIsAmbiguous) {
  RackModel model;
  model.pipes = row_of_pipes(std::vector<RowPipe>{{"a", {{0, 0.15}, {10, 0.15}}, 0},
                                                  {"b", {{0, 0.2}, {10, 0.2}}, 0.1},
                                                  {"c", {{0, 0.2}, {10, 0.2}}, 0.1},
                                                  {"d", {{0, 0.15}, {10, 0.15}}, 0.1}});
  const geometry::Camera camera = test::drawn_camera();
  RackLocalizationParameters parameters;
  parameters.retry_period = 0;
  RackLocalization localization(model, camera, parameters);
  const SE3 truth = test::drawn_pose(0.85, 5, 2.6, 0.4);
  for (int k = 0; k < 2; ++k) {
    const RackTrackerResult result = localization.track(
        test::noisy(test::draw(model, camera, truth), 1.5, 1U + static_cast<unsigned>(k)).view(),
        0.1 * k);
    EXPECT_NE(result.status, TrackStatus::kTracking);
    EXPECT_THAT(std::string(result.reason), HasSubstr("ambiguous")) << k;
  }
  // Which way is ahead decides.
  const Eigen::Vector3d right = truth.rotation() * Eigen::Vector3d::UnitX();
  FirstPoseHint hint;
  hint.heading = FirstPoseHint::Value{std::atan2(right.y(), right.x()) + 0.1, 0.2};
  localization.set_hint(hint);
  const RackTrackerResult result =
      localization.track(test::noisy(test::draw(model, camera, truth), 1.5, 9).view(), 0.3);
  ASSERT_EQ(result.status, TrackStatus::kTracking) << result.reason;
  EXPECT_NEAR(result.T_rack_camera.translation().x(), 0.85, 0.1);
}

/// Files of other racks than the one in the images.
RackModel other_rack(int which) {
  RackModel model;
  switch (which) {
    case 0:  // other pipes
      model.pipes = row_of_pipes(std::vector<RowPipe>{{"a", {{0, 0.06}, {10, 0.06}}, 0},
                                                      {"b", {{0, 0.09}, {10, 0.09}}, 0.25},
                                                      {"c", {{0, 0.30}, {10, 0.30}}, 0.2},
                                                      {"d", {{0, 0.07}, {10, 0.07}}, 0.3}});
      break;
    case 1:  // its pipes in another order and farther apart
      model.pipes = row_of_pipes(std::vector<RowPipe>{{"a", {{0, 0.20}, {10, 0.20}}, 0},
                                                      {"b", {{0, 0.15}, {10, 0.15}}, 0.3},
                                                      {"c", {{0, 0.18}, {10, 0.18}}, 0.4},
                                                      {"d", {{0, 0.15}, {10, 0.15}}, 0.2}});
      break;
    default:  // many more of them
      model = row_of(9);
  }
  model.validate();
  return model;
}

class FilesOfOtherRacks : public ::testing::TestWithParam<int> {};

TEST_P(FilesOfOtherRacks, AreSaidToBeLostAndGiveNoPose) {
  constexpr int kImages = 6;
  const geometry::Camera camera = test::drawn_camera();
  const auto flight = [](int k) { return test::drawn_pose(0.78 + 0.006 * k, 4, 2.6, 0.1); };
  RackTracker tracker(other_rack(GetParam()), camera, {});
  ASSERT_TRUE(tracker.set_pose(beside(flight(0)), start_covariance()));
  RackLocalization localization(other_rack(GetParam()), camera);
  for (int k = 0; k < kImages; ++k) {
    const test::DrawnImage image = test::noisy(test::draw(test::drawn_rack(), camera, flight(k)),
                                               1.5, 1U + static_cast<unsigned>(k));
    const RackTrackerResult near = tracker.track(image.view(), 0.04 * k);
    EXPECT_EQ(near.status, TrackStatus::kLost) << k;
    EXPECT_FALSE(near.reason.empty()) << k;
    EXPECT_NE(localization.track(image.view(), 0.04 * k).status, TrackStatus::kTracking) << k;
  }
}

/// Places over the drawn rack.
std::vector<std::array<double, 3>> views() {
  std::vector<std::array<double, 3>> result;
  for (const double x : {0.6, 0.7, 0.78, 0.85, 0.95}) {
    for (const double height : {2.2, 2.6}) {
      result.push_back({x, x < 0.8 ? 3.2 : 4.0, height});
    }
  }
  return result;
}

TEST_P(FilesOfOtherRacks, GiveNoPoseThatLasts) {
  constexpr int kImages = 40;
  const geometry::Camera camera = test::drawn_camera();
  int taken = 0;
  for (const auto& [x, y, height] : views()) {
    const auto at = [&](int k) { return test::drawn_pose(x + 0.006 * k, y, height, 0.1); };
    const auto seen = [&](int k) {
      return test::noisy(test::draw(test::drawn_rack(), camera, at(k)), 1.5,
                         static_cast<unsigned>(1000 * x + k));
    };
    RackTracker of_another(other_rack(GetParam()), camera, {});
    ASSERT_TRUE(of_another.set_pose(beside(at(0)), start_covariance()));
    bool lost = false;
    for (int k = 0; k < kImages && !lost; ++k) {
      lost = of_another.track(seen(k).view(), 0.04 * k).status == TrackStatus::kLost;
      taken += k == 0 && !lost ? 1 : 0;
    }
    EXPECT_TRUE(lost) << x << " " << height;
    RackTracker of_this(test::drawn_rack(), camera, {});
    ASSERT_TRUE(of_this.set_pose(beside(at(0)), start_covariance()));
    EXPECT_EQ(of_this.track(seen(0).view(), 0).status, TrackStatus::kTracking)
        << x << " " << height;
  }
  EXPECT_LE(taken, 1);
}

INSTANTIATE_TEST_SUITE_P(Racks, FilesOfOtherRacks, ::testing::Values(0, 1, 2));

}  // namespace
}  // namespace pipescout::rack_vision
