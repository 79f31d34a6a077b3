// SPDX-License-Identifier: Apache-2.0
#include "pipescout/planning/motion_primitives.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace pipescout::navigation {
namespace {

TEST(MotionPrimitives, EndWhereTheySayAndKeepTheRadius) {
  for (const double radius : {0.5, 1.0, 2.0, 5.0}) {
    const LatticePrimitives lattice = generate_primitives(radius, radius / 10);
    EXPECT_EQ(lattice.headings.size(), 16U);
    for (const MotionPrimitive& primitive : lattice.primitives) {
      const auto poses = lattice.poses(primitive, 0.05);
      const Pose2d& end = poses.back();
      EXPECT_NEAR(end.x, primitive.columns * lattice.spacing, 1e-9);
      EXPECT_NEAR(end.y, primitive.rows * lattice.spacing, 1e-9);
      EXPECT_NEAR(wrap_angle(end.heading -
                             lattice.headings[static_cast<std::size_t>(primitive.end_heading)]),
                  0, 1e-9);
      EXPECT_TRUE(primitive.radius() == 0 || primitive.radius() >= radius);
    }
  }
}

TEST(MotionPrimitives, NoHeadingIsFlipped) {
  // Each small step of each primitive leads forwards along the heading it has there.
  const LatticePrimitives lattice = generate_primitives(1.5, 0.1);
  for (const MotionPrimitive& primitive : lattice.primitives) {
    const auto poses = lattice.poses(primitive, 0.02);
    for (std::size_t i = 1; i < poses.size(); ++i) {
      const double direction = std::atan2(poses[i].y - poses[i - 1].y, poses[i].x - poses[i - 1].x);
      EXPECT_NEAR(wrap_angle(direction - poses[i - 1].heading), 0, 0.02) << primitive.id;
    }
  }
}

TEST(MotionPrimitives, EachHeadingTurnsBothWays) {
  const LatticePrimitives lattice = generate_primitives(2, 0.2);
  for (int heading = 0; heading < 16; ++heading) {
    for (const int turn : {0, 1, 15, 2, 14}) {
      EXPECT_TRUE(std::any_of(lattice.primitives.begin(), lattice.primitives.end(),
                              [&](const MotionPrimitive& primitive) {
                                return primitive.start_heading == heading &&
                                       primitive.end_heading == (heading + turn) % 16;
                              }))
          << heading << " by " << turn;
    }
  }
}

TEST(MotionPrimitives, RefusesWhatDoesNotFit) {
  EXPECT_THROW((void)generate_primitives(0, 0.1), std::invalid_argument);
  EXPECT_THROW((void)generate_primitives(1, 0.6), std::invalid_argument);
  LatticePrimitives lattice = generate_primitives(1, 0.1);
  lattice.primitives[0].end_heading = (lattice.primitives[0].end_heading + 8) % 16;
  EXPECT_THROW(lattice.validate(), std::invalid_argument);
  lattice = generate_primitives(1, 0.1);
  lattice.turning_radius = 2;
  EXPECT_THROW(lattice.validate(), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::navigation
