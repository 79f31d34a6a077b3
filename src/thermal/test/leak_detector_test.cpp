// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal/leak_detector.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "camera_helpers.hpp"
#include "pipe_pictures_helpers.hpp"

namespace pipescout::thermal {
namespace {

using Eigen::Vector2d;
using test::Picture;

constexpr int kWidth = 320;
constexpr int kHeight = 240;

Detections detect(const Picture& picture, const LeakDetectorParameters& parameters = {},
                  const FrameConditions& conditions = {}) {
  LeakDetector detector(parameters);
  return detector.detect(picture.view(), conditions);
}

/// Distance of a point from the axis of a section.
double off_axis(const PipeSection& pipe, const Vector2d& point) {
  const Vector2d u = (pipe.end - pipe.start).normalized();
  const Vector2d d = point - pipe.start;
  return std::abs(u.x() * d.y() - u.y() * d.x());
}

TEST(LeakDetector, AnEmptySceneHasNoPipe) {
  const Detections d = detect(Picture(kWidth, kHeight).noise(0.5, 1));
  EXPECT_EQ(d.fault, FrameFault::kNone);
  EXPECT_TRUE(d.pipes.empty());
  EXPECT_TRUE(d.leaks.empty());
}

TEST(LeakDetector, APipeBelowTheThresholdIsNone) {
  const Detections d = detect(Picture(kWidth, kHeight).pipe({-5, 90}, {325, 120}, 5, 95));
  EXPECT_EQ(d.fault, FrameFault::kNone);
  EXPECT_TRUE(d.pipes.empty());
}

TEST(LeakDetector, AWarmBodyIsNoPipe) {
  const Detections d = detect(Picture(kWidth, kHeight).box(100, 60, 60, 90, 150));
  EXPECT_EQ(d.fault, FrameFault::kNone);
  EXPECT_TRUE(d.pipes.empty());
}

TEST(LeakDetector, AxisAndWidthInAllDirections) {
  for (int degrees = 0; degrees < 180; degrees += 3) {
    const double angle = degrees * std::numbers::pi / 180;
    const Vector2d u(std::cos(angle), std::sin(angle));
    const Vector2d middle(158.3, 121.4);
    for (const double half_width : {2.5, 6.3}) {
      Picture picture(kWidth, kHeight);
      picture.pipe(middle - 80 * u, middle + 80 * u, half_width, 180).noise(0.1, 1);
      const Detections d = detect(picture);
      ASSERT_EQ(d.pipes.size(), 1U) << degrees;
      const PipeSection& pipe = d.pipes.front();
      EXPECT_LT(off_axis(pipe, middle - 70 * u), 0.5) << degrees;
      EXPECT_LT(off_axis(pipe, middle + 70 * u), 0.5) << degrees;
      EXPECT_NEAR(pipe.half_width, half_width, 0.4) << degrees;
      EXPECT_NEAR(pipe.length(), 160, 4) << degrees;
      EXPECT_GT(pipe.visible, 0.95) << degrees;
      // Of the thin one, half is averaged over: an axis half a pixel off takes its edge in.
      EXPECT_NEAR(pipe.reference_temperature, 180, 0.01 * 160) << degrees;
      EXPECT_TRUE(d.leaks.empty()) << degrees;
    }
  }
}

TEST(LeakDetector, ALeakIsPlacedAndMeasured) {
  for (const double degrees : {0.0, 17.0, 45.0, 88.0, 150.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    const Vector2d u(std::cos(angle), std::sin(angle));
    const Vector2d middle(160, 120);
    Picture picture(kWidth, kHeight);
    picture.pipe(middle - 90 * u, middle + 90 * u, 5, 150, {{100.25, 130.75, 240}}).noise(0.2, 2);
    const Detections d = detect(picture);
    ASSERT_EQ(d.leaks.size(), 1U) << degrees;
    const LeakDetection& leak = d.leaks.front();
    const Vector2d expected = middle + 25.5 * u;
    EXPECT_LT((leak.centre() - expected).norm(), 0.7) << degrees;
    EXPECT_NEAR((leak.end - leak.start).norm(), 30.5, 1.2) << degrees;
    EXPECT_NEAR(leak.delta, 90, 4) << degrees;
    EXPECT_NEAR(leak.peak_delta, 90, 3) << degrees;
    EXPECT_FALSE(leak.stretch.open_at_start);
    EXPECT_FALSE(leak.stretch.open_at_end);
    EXPECT_TRUE(std::isnan(leak.length));
  }
}

TEST(LeakDetector, TellsHowFarDeltaTMayBeOff) {
  Picture picture(kWidth, kHeight);
  picture.pipe({-5, 120}, {325, 120}, 5, 150, {{200, 230, 260}});
  const Detections without = detect(picture);
  ASSERT_EQ(without.leaks.size(), 1U);
  EXPECT_TRUE(std::isnan(without.leaks[0].delta_deviation));
  const TemperatureErrors errors{Radiometry(test::sc660(), {}), {.emissivity = 0.05}};
  const Detections d = detect(picture, {}, {.errors = errors});
  ASSERT_EQ(d.leaks.size(), 1U);
  const LeakDetection& leak = d.leaks[0];
  // By the interval's own definition, of counts.
  const Radiometry& r = errors.radiometry;
  EXPECT_NEAR(leak.delta_deviation,
              difference_interval(r, r.counts(leak.stretch.mean), r.counts(150), errors.deviations)
                  .deviation,
              0.05);
  EXPECT_GE(leak.peak_delta_deviation, leak.delta_deviation);
}

TEST(LeakDetector, JointsAreFilteredByMetresWhereTheScaleIsKnown) {
  Picture picture(kWidth, kHeight);
  picture.pipe({-5, 120}, {325, 120}, 5, 150, {{80, 95, 260}, {200, 230, 260}});
  // 15 pixels are 0.15 m, below the 0.24 m of a leak; 30 are not.
  const Detections d = detect(picture, {}, {.metres_per_pixel = 0.01});
  ASSERT_EQ(d.leaks.size(), 1U);
  EXPECT_NEAR(d.leaks[0].length, 0.3, 0.02);
  EXPECT_EQ(d.leaks[0].severity, Severity::kModerate);
  // In pixels, 8 are enough.
  EXPECT_EQ(detect(picture).leaks.size(), 2U);
  // The scale by the diameter: 0.1 m are 10 pixels.
  LeakDetectorParameters by_diameter;
  by_diameter.pipe_diameter = 0.1;
  const Detections scaled = detect(picture, by_diameter);
  ASSERT_EQ(scaled.leaks.size(), 1U);
  EXPECT_NEAR(scaled.pipes[0].metres_per_pixel, 0.01, 0.001);
}

TEST(LeakDetector, APipeBehindSupportsIsOne) {
  Picture picture(kWidth, kHeight);
  picture.pipe({-5, 100}, {325, 130}, 5, 150, {{220, 250, 250}})
      .box(60, 0, 14, 240, 10)
      .box(150, 0, 14, 240, 10);
  const Detections d = detect(picture);
  ASSERT_EQ(d.pipes.size(), 1U);
  EXPECT_GT(d.pipes[0].length(), 310);
  ASSERT_EQ(d.leaks.size(), 1U);
  const auto parts = d.parts_of(d.pipes[0]);
  EXPECT_EQ(std::count_if(parts.begin(), parts.end(),
                          [](const PipePart& p) { return p.kind == PartKind::kHidden; }),
            2);
}

TEST(LeakDetector, ALeakBehindASupportIsOpen) {
  Picture picture(kWidth, kHeight);
  picture.pipe({-5, 120}, {325, 120}, 5, 150, {{150, 190, 250}}).box(140, 0, 20, 240, 10);
  const Detections d = detect(picture);
  ASSERT_EQ(d.leaks.size(), 1U);
  EXPECT_TRUE(d.leaks[0].stretch.open_at_start);
  EXPECT_FALSE(d.leaks[0].stretch.open_at_end);
}

TEST(LeakDetector, ALeakAtTheBorderIsOpen) {
  Picture picture(kWidth, kHeight);
  picture.pipe({-5, 120}, {325, 120}, 5, 150, {{0, 40, 250}});
  const Detections d = detect(picture);
  ASSERT_EQ(d.leaks.size(), 1U);
  EXPECT_TRUE(d.leaks[0].stretch.open_at_start);
}

TEST(LeakDetector, ParallelPipes) {
  Picture picture(kWidth, kHeight);
  picture.pipe({-5, 60}, {325, 80}, 5, 150)
      .pipe({-5, 90}, {325, 110}, 5, 170, {{100, 140, 260}})
      .pipe({20, 180}, {300, 200}, 3, 130);
  const Detections d = detect(picture);
  ASSERT_EQ(d.pipes.size(), 3U);
  ASSERT_EQ(d.leaks.size(), 1U);
  EXPECT_LT(off_axis(d.pipes[d.leaks[0].pipe], {160, 100}), 0.5);
}

TEST(LeakDetector, CrossingPipesDoNotLeakWhereTheyCross) {
  Picture picture(kWidth, kHeight);
  picture.pipe({-5, 120}, {325, 120}, 5, 150).pipe({150, -5}, {170, 245}, 7, 260);
  const Detections d = detect(picture);
  ASSERT_EQ(d.pipes.size(), 2U);
  EXPECT_GT(d.pipes[0].length(), 310);
  EXPECT_GT(d.pipes[1].length(), 230);
  EXPECT_TRUE(d.leaks.empty());
}

TEST(LeakDetector, AWarmPostBeforeThePipeIsNoLeak) {
  Picture picture(kWidth, kHeight);
  picture.pipe({-5, 120}, {325, 120}, 5, 150).box(150, 60, 24, 180, 250);
  EXPECT_TRUE(detect(picture).leaks.empty());
}

TEST(LeakDetector, AWarmPostUpToThePipeIsNoLeak) {
  Picture picture(kWidth, kHeight);
  picture.pipe({-5, 120}, {325, 120}, 5, 150).box(150, 117, 24, 123, 250);
  EXPECT_TRUE(detect(picture).leaks.empty());
}

TEST(LeakDetector, AWarmBodyBehindThePipeIsNoLeak) {
  Picture picture(kWidth, kHeight);
  picture.box(120, 100, 60, 50, 240).pipe({-5, 120}, {325, 120}, 5, 150);
  EXPECT_TRUE(detect(picture).leaks.empty());
}

TEST(LeakDetector, ALeakBeforeAColderBodyIsOne) {
  Picture picture(kWidth, kHeight);
  picture.box(120, 123, 60, 50, 120).pipe({-5, 120}, {325, 120}, 5, 150, {{135, 165, 260}});
  EXPECT_EQ(detect(picture).leaks.size(), 1U);
}

TEST(LeakDetector, ACurvedCollectorIsItsStraightSections) {
  Picture picture(kWidth, kHeight);
  picture.ring({160, 400}, 300, 5, 160);
  const Detections d = detect(picture);
  ASSERT_GE(d.pipes.size(), 2U);
  for (const PipeSection& pipe : d.pipes) {
    for (double along = 0; along <= pipe.length(); along += 5) {
      EXPECT_NEAR((pipe.at(along) - Vector2d(160, 400)).norm(), 300, 3.0);
    }
  }
  EXPECT_TRUE(d.leaks.empty());
}

TEST(LeakDetector, APipeCutLengthwiseSaysSo) {
  Picture picture(kWidth, kHeight);
  picture.pipe({-5, 1}, {325, 1}, 6, 150);
  const Detections d = detect(picture);
  ASSERT_EQ(d.pipes.size(), 1U);
  EXPECT_TRUE(d.pipes[0].cut_along);
}

TEST(LeakDetector, APipeThatLeavesAtAnAngleKeepsItsAxis) {
  Picture picture(kWidth, kHeight);
  picture.pipe({-20, -6}, {340, 90}, 8, 150);
  const Detections d = detect(picture);
  ASSERT_EQ(d.pipes.size(), 1U);
  EXPECT_FALSE(d.pipes[0].cut_along);
  EXPECT_LT(off_axis(d.pipes[0], {-20, -6}), 1.0);
  EXPECT_LT(off_axis(d.pipes[0], {340, 90}), 1.0);
}

TEST(LeakDetector, DeadPixelsChangeNothing) {
  Picture picture(kWidth, kHeight);
  picture.pipe({-5, 118}, {325, 124}, 5, 150);
  for (int x = 10; x < kWidth; x += 23) {
    picture.at(x, 119 + x % 5) = x % 2 == 0 ? -90.0F : 400.0F;
  }
  const Detections d = detect(picture);
  ASSERT_EQ(d.pipes.size(), 1U);
  EXPECT_GT(d.pipes[0].length(), 315);
  EXPECT_TRUE(d.leaks.empty());
}

TEST(LeakDetector, ColdPipesAndTheScenesOwnThreshold) {
  Picture picture(kWidth, kHeight, 24);
  picture.pipe({-5, 118}, {325, 124}, 12, 5, {{120, 170, -8}}).noise(0.1, 3);
  for (const ThresholdRule rule : {ThresholdRule::kScene, ThresholdRule::kLocal}) {
    LeakDetectorParameters p = LeakDetectorParameters::adaptive(Polarity::kCold);
    p.threshold_rule = rule;
    p.local_radius = 0.2;
    const Detections d = detect(picture, p);
    ASSERT_EQ(d.pipes.size(), 1U);
    EXPECT_NEAR(d.pipes[0].reference_temperature, 5, 0.5);
    ASSERT_EQ(d.leaks.size(), 1U);
    EXPECT_NEAR(d.leaks[0].delta, 13, 1);
    EXPECT_NEAR(d.leaks[0].stretch.mean, -8, 1);
    EXPECT_NEAR((d.leaks[0].end - d.leaks[0].start).norm(), 50, 1.5);
  }
}

TEST(LeakDetector, ASceneWithoutContrastHasNoPipe) {
  LeakDetectorParameters p = LeakDetectorParameters::adaptive();
  p.threshold_rule = ThresholdRule::kScene;
  EXPECT_TRUE(detect(Picture(kWidth, kHeight).noise(0.1, 4), p).pipes.empty());
  p.threshold_rule = ThresholdRule::kLocal;
  EXPECT_TRUE(detect(Picture(kWidth, kHeight).noise(0.1, 4), p).pipes.empty());
}

TEST(LeakDetector, AStripBesideAWarmEdgeIsNoPipe) {
  // Near it the surroundings are warm on the mean, so what is next to it is colder than they are.
  Picture picture(320, 240, 20);
  picture.box(160, 0, 160, 240, 26).noise(0.05, 3);
  for (const Polarity polarity : {Polarity::kCold, Polarity::kHot}) {
    LeakDetector detector(LeakDetectorParameters::adaptive(polarity));
    EXPECT_TRUE(detector.detect(picture.view()).pipes.empty()) << static_cast<int>(polarity);
  }
}

TEST(LeakDetector, AKnownReferenceTellsThatAllOfItLeaks) {
  Picture picture(kWidth, kHeight);
  picture.pipe({-5, 120}, {325, 120}, 5, 260);
  EXPECT_TRUE(detect(picture).leaks.empty());
  const FrameConditions conditions{.sound = SoundPipe{150, {0.985, -0.174}}};
  const Detections d = detect(picture, {}, conditions);
  ASSERT_EQ(d.leaks.size(), 1U);
  EXPECT_NEAR(d.leaks[0].delta, 110, 1);
  EXPECT_TRUE(d.leaks[0].stretch.open_at_start);
  EXPECT_TRUE(d.leaks[0].stretch.open_at_end);
  // Of a post across it nobody knows how warm it is when it is sound.
  Picture post(kWidth, kHeight);
  post.pipe({160, -5}, {160, 245}, 5, 260);
  const Detections across = detect(post, {}, conditions);
  ASSERT_EQ(across.pipes.size(), 1U);
  EXPECT_TRUE(across.leaks.empty());
}

TEST(LeakDetector, CountsWithAnyStrideSayTheSameAsTemperatures) {
  Picture picture(kWidth, kHeight);
  picture.pipe({-5, 110}, {325, 131}, 5, 150, {{100, 140, 230}}).noise(0.3, 5);
  const std::vector<std::uint16_t> counts = picture.counts(kWidth + 7);
  const std::vector<float> table = Picture::table();
  LeakDetector detector({});
  const Detections by_counts =
      detector.detect(CountView{counts.data(), kWidth, kHeight, kWidth + 7}, table);
  const Detections d = detect(picture);
  ASSERT_EQ(by_counts.pipes.size(), d.pipes.size());
  ASSERT_EQ(by_counts.leaks.size(), 1U);
  EXPECT_NEAR(by_counts.leaks[0].delta, d.leaks[0].delta, 0.05);
  EXPECT_LT((by_counts.leaks[0].start - d.leaks[0].start).norm(), 0.05);
}

TEST(LeakDetector, GreyLevelsOfTheLowestTemperatureAreNoPipe) {
  std::vector<std::uint8_t> greys(static_cast<std::size_t>(kWidth * kHeight), 0);
  for (int y = 115; y < 125; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      greys[static_cast<std::size_t>(y * kWidth + x)] = x >= 100 && x < 140 ? 200 : 64;
    }
  }
  std::vector<float> table(256);
  for (std::size_t i = 0; i < table.size(); ++i) {
    table[i] = static_cast<float>(100 + 200.0 * static_cast<double>(i) / 255);
  }
  LeakDetector detector(LeakDetectorParameters::torresol());
  const Detections d = detector.detect(GreyView{greys.data(), kWidth, kHeight, kWidth}, table);
  ASSERT_EQ(d.pipes.size(), 1U);
  ASSERT_EQ(d.leaks.size(), 1U);
  EXPECT_NEAR(d.leaks[0].stretch.mean, 100 + 200.0 * 200 / 255, 0.1);
  EXPECT_NEAR((d.leaks[0].end - d.leaks[0].start).norm(), 40, 0.5);
}

TEST(LeakDetector, TheProfileIsKeptForPlots) {
  Picture picture(kWidth, kHeight);
  picture.pipe({-5, 120}, {325, 120}, 5, 150, {{100, 140, 230}});
  const Detections d = detect(picture);
  ASSERT_EQ(d.pipes.size(), 1U);
  const auto profile = d.profile_of(d.pipes[0]);
  ASSERT_EQ(profile.size(), 320U);
  EXPECT_NEAR(profile[50], 150, 0.01);
  EXPECT_NEAR(profile[115], 230, 0.01);
  std::vector<float> change;
  absolute_change(profile, 1, change);
  ASSERT_EQ(change.size(), 319U);
  EXPECT_GT(*std::max_element(change.begin(), change.end()), 30);
  const auto parts = d.parts_of(d.pipes[0]);
  EXPECT_DOUBLE_EQ(parts.front().from, 0);
  EXPECT_DOUBLE_EQ(parts.back().to, 320);
}

}  // namespace
}  // namespace pipescout::thermal
