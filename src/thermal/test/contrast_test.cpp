// SPDX-License-Identifier: Apache-2.0
// Detection by contrast alone.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "pipe_pictures_helpers.hpp"
#include "pipescout/thermal/leak_detector.hpp"

namespace pipescout::thermal {
namespace {

using Eigen::Vector2d;
using test::Picture;

/// A tube before a cold mirror, in which its image is almost as warm; `gain` and `offset` are what
/// nobody knows. The leak rises by half of the tube's contrast.
Picture scene(double gain, double offset, bool leak) {
  const auto level = [&](double value) { return offset + gain * value; };
  Picture picture(320, 240, static_cast<float>(level(0)));
  picture.pipe({0, 95}, {319, 95}, 4, level(8.2));
  const std::vector<Picture::Warm> warm =
      leak ? std::vector<Picture::Warm>{{150, 180, level(15)}} : std::vector<Picture::Warm>{};
  picture.pipe({0, 120}, {319, 123}, 5, level(10), warm);
  picture.noise(0.02 * gain, 3);
  return picture;
}

TEST(Contrast, FindsTheLeakWhateverADegreeIs) {
  LeakDetector detector(LeakDetectorParameters::by_contrast());
  for (const double gain : {1.0, 3.0, 12.0}) {
    for (const double offset : {-60.0, 0.0, 80.0}) {
      const Detections& found = detector.detect(scene(gain, offset, true).view());
      ASSERT_FALSE(found.pipes.empty()) << gain << ", " << offset;
      ASSERT_EQ(found.leaks.size(), 1U) << gain << ", " << offset;
      EXPECT_EQ(&found.pipes[found.leaks[0].pipe], found.main_pipe());
      EXPECT_NEAR(found.leaks[0].centre().x(), 165, 2);
      EXPECT_NEAR(found.main_pipe()->reference_temperature, offset + 10 * gain, 0.1 * gain);
      EXPECT_TRUE(detector.detect(scene(gain, offset, false).view()).leaks.empty());
    }
  }
}

TEST(Contrast, FindsNoPipeWhereThereIsNone) {
  LeakDetector detector(LeakDetectorParameters::by_contrast());
  Picture bare(320, 240);
  bare.noise(0.5, 5);
  EXPECT_TRUE(detector.detect(bare.view()).pipes.empty());
  Picture step(320, 240);
  step.box(0, 120, 320, 120, 40).noise(0.1, 5);
  EXPECT_TRUE(detector.detect(step.view()).pipes.empty());
}

TEST(Contrast, FindsATubeInAnyDirection) {
  LeakDetector detector(LeakDetectorParameters::by_contrast());
  for (const Vector2d& end : {Vector2d(319, 239), Vector2d(319, 120), Vector2d(160, 239)}) {
    Picture picture(320, 240, 0);
    picture.pipe(Vector2d(319, 239) - end, end, 5, 10).noise(0.05, 7);
    const Detections& found = detector.detect(picture.view());
    ASSERT_EQ(found.pipes.size(), 1U) << end.transpose();
    EXPECT_GT(found.pipes[0].length(), 200);
  }
}

TEST(Contrast, LevelsOfAutomaticGainAreNoKelvins) {
  LeakDetector detector(LeakDetectorParameters::by_contrast());
  const Detections& found = detector.detect(scene(12, 20, true).view(), {.levels = true});
  ASSERT_EQ(found.leaks.size(), 1U);
  EXPECT_TRUE(std::isnan(found.leaks[0].delta));
  EXPECT_TRUE(std::isnan(found.leaks[0].peak_delta));
}

TEST(Contrast, OnePixelMovesNothing) {
  LeakDetector detector(LeakDetectorParameters::by_contrast());
  Picture picture = scene(3, 0, true);
  const double before = detector.detect(picture.view()).threshold;
  picture.at(40, 40) = 1500;
  picture.at(41, 200) = -200;
  const Detections& found = detector.detect(picture.view());
  EXPECT_NEAR(found.threshold, before, 0.2);
  EXPECT_EQ(found.leaks.size(), 1U);
}

}  // namespace
}  // namespace pipescout::thermal
