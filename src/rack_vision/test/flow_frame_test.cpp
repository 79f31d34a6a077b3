// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "drawn_rack.hpp"
#include "pipescout/rack_vision/rack_localization.hpp"

namespace pipescout::rack_vision {
namespace {

using geometry::Matrix6d;
using geometry::SE3;
using geometry::SO3;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

Pipe pipe(const char* name, const Eigen::Vector3d& start, const Eigen::Vector3d& direction,
          double length = 10) {
  return {.name = name,
          .start = start,
          .direction = direction.normalized(),
          .radii = {{0, 0.1}, {length, 0.1}},
          .movable = false};
}

TEST(MainDirection, IsYWhereTwoPipesRunAlongIt) {
  RackModel model = test::drawn_rack();
  EXPECT_EQ(main_direction(model), Eigen::Vector3d::UnitY());
  for (int i = 0; i < 6; ++i) {
    model.pipes.push_back(pipe("across", {0, 2.0 * i, 3}, Eigen::Vector3d::UnitX()));
  }
  EXPECT_EQ(main_direction(model), Eigen::Vector3d::UnitY());
}

TEST(MainDirection, IsThatOfMostPipesAndThenOfTheLongest) {
  RackModel model;
  model.pipes = {pipe("a", {0, 0, 0}, {0, 1, 0}, 50), pipe("b", {0, 0, 1}, {-1, 1e-3, 0}),
                 pipe("c", {0, 1, 1}, {-1, 0, 0}), pipe("riser", {9, 9, 0}, {0, 0, 1}, 90)};
  EXPECT_EQ(main_direction(model), Eigen::Vector3d(-1, 0, 0)) << "of the flow, along the axis";
  model.pipes.resize(2);
  EXPECT_EQ(main_direction(model), Eigen::Vector3d::UnitY());
  model.pipes = {pipe("a", {0, 0, 0}, {0, 0, 1})};
  EXPECT_EQ(main_direction(model), Eigen::Vector3d::UnitY());
  model.pipes = {pipe("a", {0, 0, 0}, {0, -1, 0})};
  EXPECT_EQ(main_direction(model), Eigen::Vector3d::UnitY());
  model.pipes = {pipe("a", {0, 0, 0}, {3, 4, 0})};
  EXPECT_TRUE(main_direction(model).isApprox(Eigen::Vector3d(0.6, 0.8, 0)));
}

/// The same rack in a frame that is turned and moved.
RackModel turned(const RackModel& model, const SE3& T_new_old) {
  RackModel result = model;
  for (Pipe& each : result.pipes) {
    each.start = T_new_old * each.start;
    each.direction = (T_new_old.rotation() * each.direction).normalized();
    each.movable = false;
  }
  return result;
}

RackModel fixed_rack() {
  return turned(test::drawn_rack(), SE3());
}

class AnyDirection : public ::testing::TestWithParam<double> {};

/// What is tracked is the same, whatever frame the rack is given in.
TEST_P(AnyDirection, GivesTheSamePoses) {
  const RackModel along_y = fixed_rack();
  const SE3 T_new_old(SO3::about_z(GetParam()), Eigen::Vector3d::Zero());
  const geometry::Camera camera = test::drawn_camera();
  RackLocalization one(along_y, camera);
  RackLocalization other(turned(along_y, T_new_old), camera);
  Matrix6d covariance = 1e-4 * Matrix6d::Identity();
  covariance.diagonal().tail<3>() *= 0.25;
  const auto flight = [](int k) {
    return test::drawn_pose(0.78 + 0.010 * k, 4.0 + 0.016 * k, 2.8 - 0.004 * k, 0.10 + 0.003 * k);
  };
  const SE3 start = flight(0);
  ASSERT_TRUE(one.set_pose(start, covariance));
  ASSERT_TRUE(other.set_pose(T_new_old * start, covariance));
  for (int k = 0; k < 5; ++k) {
    const test::DrawnImage image = test::draw(along_y, camera, flight(k));
    const RackTrackerResult a = one.track(image.view(), 0.04 * k);
    const RackTrackerResult b = other.track(image.view(), 0.04 * k);
    ASSERT_EQ(a.status, TrackStatus::kTracking) << k << ": " << a.reason;
    ASSERT_EQ(b.status, TrackStatus::kTracking) << k << ": " << b.reason;
    EXPECT_TRUE(a.reason.empty()) << a.reason;
    const SE3 expected = T_new_old * a.T_rack_camera;
    EXPECT_LT((b.T_rack_camera.translation() - expected.translation()).norm(), 1e-5);
    EXPECT_LT((b.T_rack_camera.rotation().inverse() * expected.rotation()).log().norm(), 1e-5);
    const Eigen::Matrix3d turn = T_new_old.rotation().matrix();
    const Eigen::Matrix3d place = turn * a.covariance.topLeftCorner<3, 3>() * turn.transpose();
    EXPECT_TRUE((b.covariance.topLeftCorner<3, 3>()).isApprox(place, 1e-3))
        << b.covariance.topLeftCorner<3, 3>() << "\n"
        << place;
  }
}

INSTANTIATE_TEST_SUITE_P(Headings, AnyDirection,
                         ::testing::Values(-std::numbers::pi / 2, std::numbers::pi / 2, 0.7));

TEST(MainDirection, IsFoundInTheImageAloneWithAHint) {
  const RackModel along_y = fixed_rack();
  const SE3 T_new_old(SO3::about_z(-std::numbers::pi / 2), {3, -7, 0.5});
  const geometry::Camera camera = test::drawn_camera();
  RackLocalization localization(turned(along_y, T_new_old), camera);
  const SE3 truth = test::drawn_pose(0.8, 4, 2.8, 0.1);
  const SE3 wanted = T_new_old * truth;
  localization.set_hint({.x = {{wanted.translation().x(), 0.3}},
                         .y = {{wanted.translation().y(), 0.3}},
                         .z = {},
                         .heading = {{0.1 - std::numbers::pi / 2, 0.3}}});
  RackTrackerResult result;
  for (int k = 0; k < 10 && result.status != TrackStatus::kTracking; ++k) {
    result = localization.track(test::draw(along_y, camera, truth, 1 - 0.004 * k).view(), 0.25 * k);
  }
  ASSERT_EQ(result.status, TrackStatus::kTracking) << result.reason;
  // Across the pipes, which run along x here.
  EXPECT_NEAR(result.T_rack_camera.translation().y(), wanted.translation().y(), 0.03);
  EXPECT_NEAR(result.T_rack_camera.translation().z(), wanted.translation().z(), 0.03);
  EXPECT_GT(result.covariance(0, 0), result.covariance(1, 1));
}

TEST(RackLocalization, RefusesSupportsInAnObliqueRack) {
  RackModel model = turned(test::drawn_rack(), SE3(SO3::about_z(0.4), {0, 0, 0}));
  EXPECT_NO_THROW(RackLocalization(model, geometry::Camera()));
  model.supports.push_back({"beam", {0, 0, -1}, {1, 1, -0.5}});
  EXPECT_THAT([&] { RackLocalization(model, geometry::Camera()); },
              ThrowsMessage<InvalidRack>(HasSubstr("'beam': the pipes run obliquely")));
}

}  // namespace
}  // namespace pipescout::rack_vision
