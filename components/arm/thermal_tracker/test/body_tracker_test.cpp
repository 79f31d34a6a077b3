// SPDX-License-Identifier: Apache-2.0
#include "body_tracker.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace pipescout {
namespace {

constexpr tracking::ImageSize kSmallImage{.width = 160, .height = 120};
constexpr double kImagePeriod = 0.04;  // s

/// A hot square of so many pixels to a side; 0: none.
std::vector<float> square(double side) {
  std::vector<float> celsius;
  for (int y = 0; y < kSmallImage.height; ++y) {
    for (int x = 0; x < kSmallImage.width; ++x) {
      const bool hot = std::abs(x - 80) < side / 2 && std::abs(y - 60) < side / 2;
      celsius.push_back(hot ? 200.0F : 10.0F);
    }
  }
  return celsius;
}

class BodyTrackersTest : public ::testing::TestWithParam<FollowedShape> {};

TEST_P(BodyTrackersTest, AShapeThatShrankAndIsGoneHasNoNegativeSize) {
  TrackerSettings settings;
  settings.followed = GetParam();
  const auto tracker = make_body_tracker(settings);
  ASSERT_NE(tracker, nullptr);
  double time = 100;
  const auto show = [&](double side) {
    const auto celsius = square(side);
    tracker->update({.time = time, .image = kSmallImage, .celsius = celsius});
    time += kImagePeriod;
    return tracker->message();
  };
  for (int i = 0; i < 20; ++i) {
    EXPECT_GT(show(70 - 3 * i).regions, 0U);
  }
  for (int i = 0; i < 60; ++i) {
    const auto message = show(0);
    EXPECT_GE(message.estimate.length, 0);
    EXPECT_FALSE(message.half_width < 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, BodyTrackersTest,
                         ::testing::Values(FollowedShape::kValve, FollowedShape::kVessel));

TEST(BodyTrackers, APipeHasItsOwn) {
  EXPECT_EQ(make_body_tracker(TrackerSettings{}), nullptr);
}

}  // namespace
}  // namespace pipescout
