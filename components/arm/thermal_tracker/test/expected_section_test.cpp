// SPDX-License-Identifier: Apache-2.0
#include "expected_section.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "pipescout/simulation/pipe_view.hpp"
#include "pipescout/simulation/thermal_camera.hpp"
#include "pipescout/simulation/thermal_patrol.hpp"
#include "pipescout/tracking/shapes.hpp"

namespace pipescout {
namespace {

using geometry::SE3;
using geometry::SO3;
using leak_findings::PipeLine;
using tracking::PipeShape;

const PipeLine kTube{{0, 10, 3}, {150, 10, 3}};

class ExpectedSectionTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::optional<ExpectedSection> expected(const std::vector<PipeLine>& lines,
                                                        const SE3& T_map_base) const {
    leak_findings::FramePose pose{.T_map_base = T_map_base};
    pose.covariance.diagonal() << 0.01, 0.01, 0.01, 1e-6, 1e-6, 1e-6;
    return expected_section(lines, 0.05, camera_, pose, T_base_camera_);
  }

  geometry::Camera camera_{simulation::ThermalCameraParameters::qvga().camera};
  SE3 T_base_camera_ = simulation::T_body_side_camera({0.2, 0.2, 1.2}, 0.145);
};

TEST_F(ExpectedSectionTest, IsWhatTheCameraSeesOfTheLine) {
  const SE3 T_map_base(SO3::about_z(0.05), {40, 0, 0.35});
  const auto section = expected({kTube}, T_map_base);
  const auto seen = simulation::view_pipe({.from = kTube.from, .to = kTube.to}, camera_,
                                          T_map_base * T_base_camera_);
  ASSERT_TRUE(section && seen);
  const Eigen::Vector2d middle = (seen->from + seen->to) / 2;
  EXPECT_NEAR(section->hint.shape[PipeShape::kX], middle.x(), 1);
  EXPECT_NEAR(section->hint.shape[PipeShape::kY], middle.y(), 0.1);
  EXPECT_NEAR(section->hint.shape[PipeShape::kLength], (seen->to - seen->from).norm(), 2);
  EXPECT_NEAR(section->depth, 10, 0.3);
  EXPECT_GT(section->hint.deviation[PipeShape::kY], 5);
  EXPECT_LT(section->hint.deviation[PipeShape::kY], 20);
  EXPECT_GT(section->hint.deviation[PipeShape::kX], 50) << "posts may hide parts of the pipe";
}

TEST_F(ExpectedSectionTest, TheNearestOfSeveralIsTaken) {
  const PipeLine behind{{0, 30, 6}, {150, 30, 6}};
  const auto section = expected({behind, kTube}, SE3(SO3(), {40, 0, 0.35}));
  ASSERT_TRUE(section);
  EXPECT_NEAR(section->depth, 10, 0.3);
}

TEST_F(ExpectedSectionTest, APipeThatIsNotInViewIsNotExpected) {
  EXPECT_FALSE(expected({}, SE3(SO3(), {40, 0, 0.35})));
  EXPECT_FALSE(expected({kTube}, SE3(SO3(), {-20, 0, 0.35}))) << "before the row";
  EXPECT_FALSE(expected({kTube}, SE3(SO3::about_z(3.14), {40, 0, 0.35}))) << "behind the camera";
}

}  // namespace
}  // namespace pipescout
