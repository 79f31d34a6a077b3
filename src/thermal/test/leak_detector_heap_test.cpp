// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "heap_guard.hpp"
#include "pipe_pictures_helpers.hpp"
#include "pipescout/thermal/leak_detector.hpp"

namespace pipescout::thermal {
namespace {

using test::Picture;

TEST(LeakDetectorHeap, NothingIsTakenAfterAFewFrames) {
  const std::vector<float> table = Picture::table();
  std::vector<std::vector<std::uint16_t>> frames;
  for (int i = 0; i < 12; ++i) {
    Picture picture(640, 512);
    picture
        .pipe({-5, 100.0 + 9 * i}, {645, 180.0 - 3 * i}, 8, 150,
              {{60.0 + 20 * i, 110.0 + 20 * i, 250}})
        .pipe({300, -5}, {320, 515}, 5, 130)
        .box(150, 0, 12, 512, 10)
        .noise(0.5, 1);
    frames.push_back(picture.counts(640));
  }
  for (const ThresholdRule rule :
       {ThresholdRule::kFixed, ThresholdRule::kScene, ThresholdRule::kLocal}) {
    LeakDetectorParameters p;
    p.threshold_rule = rule;
    p.pipe_diameter = 0.12;
    LeakDetector detector(p);
    const auto all = [&] {
      std::size_t leaks = 0;
      for (const auto& frame : frames) {
        leaks += detector.detect(CountView{frame.data(), 640, 512, 640}, table).leaks.size();
      }
      return leaks;
    };
    EXPECT_GE(all(), frames.size() / 2);
    const pipescout::test::HeapGuard guard;
    all();
    EXPECT_EQ(guard.allocations(), 0U);
  }
}

}  // namespace
}  // namespace pipescout::thermal
