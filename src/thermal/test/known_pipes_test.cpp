// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "heap_guard.hpp"
#include "pipe_pictures_helpers.hpp"
#include "pipescout/thermal/leak_detector.hpp"

namespace pipescout::thermal {
namespace {

using Eigen::Vector2d;
using test::Picture;

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr double kScale = 0.008;  // m per pixel

LeakDetectorParameters over_a_rack() {
  LeakDetectorParameters p;
  p.threshold = 20;
  p.min_length = 0.1;
  p.profile.split_delta = 3;
  p.profile.leak_delta = 4;
  p.profile.min_part_width_m = 0.12;
  return p;
}

PipeStrip strip(std::size_t pipe, const Vector2d& start, const Vector2d& end, double half_width,
                double depth) {
  return {.pipe = pipe,
          .start = start,
          .end = end,
          .half_width = {half_width, half_width},
          .depth = {depth, depth},
          .metres_per_pixel = kScale};
}

/// Four pipes side by side up the image, and one across that lies on them.
class KnownPipesTest : public ::testing::Test {
 protected:
  static constexpr std::size_t kAcross = 4;
  static constexpr double kHalfWidth = 22;  // of the one across

  void draw(const std::vector<Picture::Warm>& warm_along, double celsius_across,
            const std::vector<Picture::Warm>& warm_across) {
    for (std::size_t i = 0; i < kAcross; ++i) {
      const double x = 40 + 60.0 * static_cast<double>(i);
      picture_.pipe({x, kHeight + 5}, {x, -5}, 20, 36 + 4.0 * static_cast<double>(i),
                    i == 2 ? warm_along : std::vector<Picture::Warm>{});
      conditions_.strips.push_back(strip(i, {x, kHeight + 20}, {x, -20}, 20, 2.4));
    }
    picture_.pipe({-5, 120}, {kWidth + 5, 120}, kHalfWidth, celsius_across, warm_across);
    conditions_.strips.push_back(strip(kAcross, {-30, 120}, {kWidth + 30, 120}, kHalfWidth, 2.0));
    picture_.noise(0.1, 1);
  }

  const Detections& detect() { return detector_.detect(picture_.view(), conditions_); }

  /// Null when the pipe was not found.
  static const PipeSection* pipe_at(const Detections& d, double x) {
    const auto found = std::ranges::find_if(d.pipes, [&](const PipeSection& pipe) {
      return std::abs(pipe.start.x() - x) < 1 && std::abs(pipe.end.x() - x) < 1;
    });
    return found == d.pipes.end() ? nullptr : &*found;
  }

  Picture picture_{kWidth, kHeight, 12};
  FrameConditions conditions_{};
  LeakDetector detector_{over_a_rack()};
};

TEST_F(KnownPipesTest, ALeakOfThePipeAcrossTheOthersIsFound) {
  // Over the second pipe, which is as warm as the leak.
  draw({}, 31, {{85, 135, 41}});
  const Detections& d = detect();
  ASSERT_EQ(d.pipes.size(), 5U);
  ASSERT_EQ(d.leaks.size(), 1U);
  const LeakDetection& leak = d.leaks[0];
  EXPECT_LT((leak.centre() - Vector2d(105, 120)).norm(), 1);
  EXPECT_NEAR(leak.delta, 10, 0.5);
  EXPECT_NEAR(leak.length, 50 * kScale, 2 * kScale);
  EXPECT_NEAR(leak.across, 0, 1);
  EXPECT_FALSE(leak.stretch.open_at_start);
  EXPECT_FALSE(leak.stretch.open_at_end);
  const PipeSection& pipe = d.pipes[leak.pipe];
  EXPECT_NEAR(pipe.length(), kWidth - 1, 1e-9);
  EXPECT_NEAR(pipe.half_width, kHalfWidth, 1e-9);
  EXPECT_NEAR(pipe.visible, 1, 0.02);
  EXPECT_NEAR(pipe.reference_temperature, 31, 0.2);
}

TEST_F(KnownPipesTest, WhatIsHiddenBelongsToThePipeInFront) {
  for (const double across : {60.0, 26.0}) {
    picture_ = Picture(kWidth, kHeight, 12);
    conditions_.strips.clear();
    draw({}, across, {});
    const Detections& d = detect();
    EXPECT_EQ(d.pipes.size(), 5U);
    EXPECT_TRUE(d.leaks.empty()) << across;
    for (std::size_t i = 0; i < kAcross; ++i) {
      const PipeSection* const pipe = pipe_at(d, 40 + 60.0 * static_cast<double>(i));
      ASSERT_NE(pipe, nullptr) << i;
      EXPECT_NEAR(pipe->reference_temperature, 36 + 4.0 * static_cast<double>(i), 0.2) << i;
      EXPECT_NEAR(pipe->visible, 1, 0.05) << i;
      const auto parts = d.parts_of(*pipe);
      ASSERT_EQ(parts.size(), 3U);
      EXPECT_EQ(parts[1].kind, PartKind::kHidden);
      EXPECT_NEAR(parts[1].to - parts[1].from, 2 * kHalfWidth, 12);
    }
  }
}

TEST_F(KnownPipesTest, ALeakThatGoesOnBelowThePipeInFrontIsOpenThere) {
  // From y = 165 to 125, of which the pipe across hides what is above 142.
  draw({{80, 120, 54}}, 50, {});
  const Detections& d = detect();
  ASSERT_EQ(d.leaks.size(), 1U);
  EXPECT_FALSE(d.leaks[0].stretch.open_at_start);
  EXPECT_TRUE(d.leaks[0].stretch.open_at_end);
  EXPECT_NEAR(d.leaks[0].start.y(), 165, 1);
  EXPECT_NEAR(d.leaks[0].end.y(), 142, 7);
}

TEST_F(KnownPipesTest, DepthTellsWhichIsInFront) {
  draw({}, 60, {});
  conditions_.strips.back().depth = {3.0, 3.0};
  // Then all four are seen to have something warmer on them.
  EXPECT_EQ(detect().leaks.size(), 4U);
  // Lower on the right.
  conditions_.strips.back().depth = {1.8, 3.6};
  EXPECT_EQ(detect().leaks.size(), 2U);
}

TEST_F(KnownPipesTest, AWarmBodyBesideAPipeIsNoLeak) {
  draw({}, 40, {});
  picture_.box(118, 20, 62, 50, 60);  // over the third pipe, and what is between it and the second
  EXPECT_TRUE(detect().leaks.empty());
}

TEST_F(KnownPipesTest, APipeThatIsNotThereIsNone) {
  draw({}, 40, {});
  conditions_.strips.push_back(strip(9, {296, 260}, {296, -20}, 10, 2.4));
  const Detections& d = detect();
  EXPECT_EQ(d.pipes.size(), 5U);
  EXPECT_EQ(pipe_at(d, 296), nullptr);
}

TEST_F(KnownPipesTest, TheLongestFirstAndNoMoreThanAllowed) {
  draw({}, 40, {});
  LeakDetectorParameters p = over_a_rack();
  p.max_pipes = 2;
  const Detections d = LeakDetector(p).detect(picture_.view(), conditions_);
  ASSERT_EQ(d.pipes.size(), 2U);
  EXPECT_NEAR(d.pipes[0].length(), kWidth - 1, 1e-9);
  EXPECT_NEAR(d.pipes[1].length(), kHeight - 1, 1e-9);
}

TEST_F(KnownPipesTest, AShortPieceBetweenPipesThatHideItIsNotCompared) {
  draw({}, 40, {});
  conditions_.strips.push_back(strip(7, {-10, 60}, {330, 60}, 30, 1.8));
  conditions_.strips.push_back(strip(8, {-10, 190}, {330, 190}, 40, 1.8));
  const Detections& d = detect();
  for (std::size_t i = 0; i < kAcross; ++i) {
    EXPECT_EQ(pipe_at(d, 40 + 60.0 * static_cast<double>(i)), nullptr) << i;
  }
}

TEST(KnownPipes, SectionsOfOnePipeAreComparedTogether) {
  Picture picture(kWidth, kHeight, 12);
  // Where it becomes wider, it is warm.
  picture.pipe({-5, 120}, {170, 120}, 15, 40, {{150, 175, 55}})
      .pipe({160, 120}, {325, 120}, 20, 40, {{0, 30, 55}})
      .noise(0.1, 1);
  FrameConditions conditions;
  conditions.strips = {strip(0, {-20, 120}, {160, 120}, 15, 2),
                       strip(0, {160, 120}, {340, 120}, 20, 2)};
  LeakDetector detector(over_a_rack());
  const Detections& d = detector.detect(picture.view(), conditions);
  ASSERT_EQ(d.pipes.size(), 1U);
  EXPECT_NEAR(d.pipes[0].half_width, 17.5, 1e-9);
  ASSERT_EQ(d.leaks.size(), 1U);
  EXPECT_NEAR(d.leaks[0].start.x(), 145, 1);
  EXPECT_NEAR(d.leaks[0].end.x(), 190, 1);
}

TEST(KnownPipes, StripsWithoutSenseAreLeftOut) {
  Picture picture(kWidth, kHeight, 12);
  picture.pipe({-5, 120}, {325, 120}, 15, 40);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  FrameConditions conditions;
  conditions.strips = {strip(0, {kNan, 120}, {160, 120}, 15, 2), strip(1, {9, 9}, {9, 9}, 15, 2),
                       strip(2, {0, 120}, {160, 120}, 0, 2), strip(3, {0, 120}, {160, 120}, 15, 0),
                       strip(4, {-90, 20}, {-10, 20}, 15, 2)};
  LeakDetector detector(over_a_rack());
  const Detections& d = detector.detect(picture.view(), conditions);
  EXPECT_EQ(d.fault, FrameFault::kNone);
  EXPECT_TRUE(d.pipes.empty());
}

TEST_F(KnownPipesTest, NothingIsTakenFromTheHeapAfterTheFirstFrame) {
  draw({{30, 60, 60}}, 40, {{85, 135, 60}});
  EXPECT_EQ(detect().leaks.size(), 2U);
  const pipescout::test::HeapGuard guard;
  detect();
  EXPECT_EQ(guard.allocations(), 0U);
}

}  // namespace
}  // namespace pipescout::thermal
