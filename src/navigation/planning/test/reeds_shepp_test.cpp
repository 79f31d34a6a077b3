// SPDX-License-Identifier: Apache-2.0
#include "pipescout/planning/reeds_shepp.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace pipescout::navigation {
namespace {

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11U) * 0x1p-53;
  }

 private:
  std::mt19937_64 engine_;
};

TEST(ReedsShepp, EachWordEndsAtTheGoal) {
  Draw draw(3);
  for (int round = 0; round < 5000; ++round) {
    const Pose2d from{draw(-5, 5), draw(-5, 5), draw(-4, 4)};
    const Pose2d to{draw(-5, 5), draw(-5, 5), draw(-4, 4)};
    const double radius = draw(0.3, 3);
    const auto words = reeds_shepp_words(from, to, radius);
    ASSERT_FALSE(words.empty());
    EXPECT_NEAR(words.front().length(), reeds_shepp_length(from, to, radius), 1e-9);
    for (const SteeringWord& word : words) {
      const Pose2d end = drive_word(from, word, radius, 0.5).poses().back().pose;
      ASSERT_NEAR(distance(end, to), 0, 1e-6) << round;
      ASSERT_NEAR(wrap_angle(end.heading - to.heading), 0, 1e-6) << round;
    }
  }
}

TEST(ReedsShepp, IsAMetric) {
  Draw draw(4);
  for (int round = 0; round < 5000; ++round) {
    const auto pose = [&] { return Pose2d{draw(-3, 3), draw(-3, 3), draw(-4, 4)}; };
    const Pose2d a = pose();
    const Pose2d b = pose();
    const Pose2d c = pose();
    const double ab = reeds_shepp_length(a, b, 1);
    EXPECT_NEAR(ab, reeds_shepp_length(b, a, 1), 1e-7);
    EXPECT_LE(ab, reeds_shepp_length(a, c, 1) + reeds_shepp_length(c, b, 1) + 1e-7);
    EXPECT_GE(ab, distance(a, b) - 1e-9);
  }
}

TEST(ReedsShepp, KnownLengths) {
  EXPECT_NEAR(reeds_shepp_length({}, {3, 0, 0}, 1), 3, 1e-9);
  EXPECT_NEAR(reeds_shepp_length({}, {-3, 0, 0}, 1), 3, 1e-9);
  EXPECT_NEAR(reeds_shepp_length({}, {2, 2, std::numbers::pi / 2}, 2), std::numbers::pi, 1e-9);
  // Turned about on the spot: three arcs of 60 degrees.
  EXPECT_NEAR(reeds_shepp_length({}, {0, 0, std::numbers::pi}, 1), std::numbers::pi, 1e-6);
  EXPECT_TRUE(std::isinf(reeds_shepp_length({}, {NAN, 0, 0}, 1)));
}

TEST(ReedsShepp, PathsKeepTheRadiusAndMarkCusps) {
  const auto words = reeds_shepp_words({}, {0, 0, std::numbers::pi}, 1.5);
  const Path path = drive_word({}, words.front(), 1.5, 0.05);
  EXPECT_EQ(path.cusps(), 2U);
  EXPECT_NEAR(path.largest_curvature(), 1 / 1.5, 1e-12);
  EXPECT_NEAR(path.length(), words.front().length(), 1e-9);
}

}  // namespace
}  // namespace pipescout::navigation
