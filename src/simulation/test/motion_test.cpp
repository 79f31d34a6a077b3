// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace pipescout::simulation {
namespace {

TEST(Motion, IsTheTrapezoidOfTheBooks) {
  const Motion motion({{.speed = 0.4, .duration = 10.0}, {.speed = 0.0, .duration = 10.0}}, 0.2);
  EXPECT_DOUBLE_EQ(motion.duration(), 20.0);
  EXPECT_DOUBLE_EQ(motion.speed(1.0), 0.2);
  EXPECT_DOUBLE_EQ(motion.speed(5.0), 0.4);
  EXPECT_DOUBLE_EQ(motion.distance(1.0), 0.1);
  EXPECT_DOUBLE_EQ(motion.distance(10.0), 0.4 + 3.2);
  EXPECT_DOUBLE_EQ(motion.distance(20.0), 4.0);
  EXPECT_DOUBLE_EQ(motion.speed(15.0), 0.0);
}

TEST(Motion, ReversesThroughRest) {
  const Motion motion({{.speed = 0.5, .duration = 10.0}, {.speed = -0.5, .duration = 10.0}}, 0.25);
  EXPECT_DOUBLE_EQ(motion.speed(12.0), 0.0);
  EXPECT_DOUBLE_EQ(motion.speed(14.0), -0.5);
  EXPECT_DOUBLE_EQ(motion.distance(12.0), 5.0);
  EXPECT_DOUBLE_EQ(motion.distance(20.0), 5.0 - 3.5);
  EXPECT_DOUBLE_EQ(motion.path(20.0), 5.0 + 3.5);
  for (const MotionPiece& piece : motion.pieces()) {  // none changes its direction
    const double end = piece.speed + piece.acceleration * piece.duration;
    EXPECT_GE(piece.speed * end, -1e-12);
  }
}

TEST(Motion, ALegTooShortForItsSpeedGoesOnFromWhatItReached) {
  const Motion motion({{.speed = 1.0, .duration = 2.0}, {.speed = -1.0, .duration = 1.0}}, 0.2);
  EXPECT_DOUBLE_EQ(motion.speed(2.0), 0.4);
  EXPECT_NEAR(motion.speed(3.0), 0.2, 1e-15);
  EXPECT_NEAR(motion.distance(3.0), 0.4 + 0.3, 1e-15);
}

TEST(Motion, DistanceIsTheIntegralOfSpeed) {
  const Motion motion = draw_inspection({.length = 300.0, .stop_spacing = 20.0}, 1);
  constexpr double kStep = 0.001;
  const auto steps = static_cast<int>(motion.duration() / kStep);
  double distance = 0.0;
  double path = 0.0;
  for (int k = 0; k < steps; ++k) {
    distance += kStep * motion.speed(kStep * (k + 0.5));
    path += kStep * std::abs(motion.speed(kStep * (k + 0.5)));
  }
  EXPECT_NEAR(motion.distance(kStep * steps), distance, 1e-4);
  EXPECT_NEAR(motion.path(kStep * steps), path, 1e-4);
}

TEST(Motion, AnInspectionGetsThereWithStopsAndReversals) {
  const Motion motion = draw_inspection({.length = 1000.0, .stop_spacing = 50.0}, 2);
  EXPECT_NEAR(motion.distance(motion.duration()), 1000.0, 2.0 * 3.0 * 8.0);  // it may end reversed
  EXPECT_GT(motion.path(motion.duration()), motion.distance(motion.duration()) + 1.0);
  const auto& pieces = motion.pieces();
  EXPECT_TRUE(std::any_of(pieces.begin(), pieces.end(), [](const MotionPiece& piece) {
    return piece.speed == 0.0 && piece.acceleration == 0.0 && piece.duration > 1.0;
  }));
  double furthest = 0.0;
  for (const MotionPiece& piece : pieces) {
    furthest = std::max(furthest, piece.distance);
    EXPECT_LE(std::abs(piece.speed), 0.33 + 1e-12);
  }
  EXPECT_NEAR(furthest, 1000.0, 1e-6);
}

TEST(Motion, RefusesWhatCannotBeDriven) {
  EXPECT_THROW(Motion({}, 0.2), std::invalid_argument);
  EXPECT_THROW(Motion({{.speed = 0.1, .duration = 0.0}}, 0.2), std::invalid_argument);
  EXPECT_THROW(Motion({{.speed = std::nan(""), .duration = 1.0}}, 0.2), std::invalid_argument);
  EXPECT_THROW(Motion({{.speed = 0.1, .duration = 1.0}}, 0.0), std::invalid_argument);
  EXPECT_THROW(draw_inspection({.speed = -1.0}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::simulation
