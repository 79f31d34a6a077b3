// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigation_maps/path.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace pipescout::navigation {
namespace {

TEST(Path, QuarterCircleInReverse) {
  const Pose2d end = drive_arc({0, 0, 0}, 0.5, -std::numbers::pi);
  EXPECT_NEAR(end.x, -2, 1e-12);
  EXPECT_NEAR(end.y, 2, 1e-12);
  EXPECT_NEAR(end.heading, -std::numbers::pi / 2, 1e-12);
}

TEST(Path, InterpolatesAlongTheArc) {
  const Pose2d end = drive_arc({0, 0, 0}, 1, 1);
  const Path path({{.pose = {}, .curvature = 1}, {.pose = end, .curvature = 1, .arc_length = 1}});
  const Pose2d expected = drive_arc({0, 0, 0}, 1, 0.25);
  EXPECT_NEAR(distance(path.at(0.25).pose, expected), 0, 1e-12);
  EXPECT_EQ(path.at(-1).pose, Pose2d{});
  EXPECT_EQ(path.at(9).pose, end);
}

TEST(Path, CountsCuspsAndReverse) {
  const Path path({{.pose = {0, 0, 0}},
                   {.pose = {1, 0, 0}, .arc_length = 1},
                   {.pose = {1, 0, 0}, .direction = Direction::kReverse, .arc_length = 1},
                   {.pose = {0.5, 0, 0}, .direction = Direction::kReverse, .arc_length = 1.5}});
  EXPECT_EQ(path.cusps(), 1U);
  EXPECT_DOUBLE_EQ(path.reverse_length(), 0.5);
  EXPECT_DOUBLE_EQ(path.length(), 1.5);
}

TEST(Path, RefusesWhatIsNoPath) {
  EXPECT_THROW(Path({{.pose = {NAN, 0, 0}}}), std::invalid_argument);
  EXPECT_THROW(Path({{.arc_length = 1}, {.arc_length = 0.5}}), std::invalid_argument);
  EXPECT_THROW((void)Path().at(0), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::navigation
