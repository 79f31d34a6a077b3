// SPDX-License-Identifier: Apache-2.0
// Straight bodies in pictures of real cameras: hot tubes, a conveyor's stringer and a pipe that is
// colder than its wall.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "pipescout/leak_survey/survey_settings.hpp"
#include "pipescout/thermal_files/thermal_file.hpp"

namespace pipescout {
namespace {

namespace fs = std::filesystem;

class RealPictures : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* shared = std::getenv("PIPESCOUT_SHARED_DATA");
    folder_ = fs::path(shared == nullptr ? "" : shared) / "thermal_flir";
    if (!fs::exists(folder_ / "conveyor_zenmuse_xtr.jpg")) {
      GTEST_SKIP() << "NOT TESTED on real thermal pictures: PIPESCOUT_SHARED_DATA names no folder "
                      "with thermal_flir/conveyor_zenmuse_xtr.jpg";
    }
  }
  [[nodiscard]] thermal::Detections detect(const char* name, thermal::DetectorPreset preset) const {
    const ThermalPicture picture = ThermalFileReader({}).read(folder_ / name);
    thermal::LeakDetector detector(thermal::LeakDetectorParameters::of(preset));
    return detector.detect(picture.view());
  }

  fs::path folder_;
};

struct Straight {
  double row;           // of the axis, at half the width of the picture
  double least_length;  // pixels
  double slack;         // pixels, of the row
};

/// Whether a section is that one: nearly level, long enough, and where a person sees it.
auto holds(const Straight& wanted, int width) {
  return ::testing::Contains(::testing::Truly([wanted, width](const thermal::PipeSection& pipe) {
    const Eigen::Vector2d along = pipe.end - pipe.start;
    const double slope = along.y() / along.x();
    const double row = pipe.start.y() + slope * (0.5 * width - pipe.start.x());
    return pipe.length() >= wanted.least_length && std::abs(slope) < 0.12 &&
           std::abs(row - wanted.row) <= wanted.slack;
  }));
}

TEST_F(RealPictures, BothHotTubes) {
  const auto found = detect("fluorescent_tubes_t650sc.jpg", thermal::DetectorPreset::kHotPipes);
  EXPECT_THAT(found.pipes, holds({.row = 111, .least_length = 450, .slack = 10}, 640));
  EXPECT_THAT(found.pipes, holds({.row = 389, .least_length = 450, .slack = 10}, 640));
}

TEST_F(RealPictures, TheConveyorsStringer) {
  const auto found = detect("conveyor_zenmuse_xtr.jpg", thermal::DetectorPreset::kHotPipes);
  EXPECT_THAT(found.pipes, holds({.row = 307, .least_length = 580, .slack = 10}, 640));
}

TEST_F(RealPictures, ThePipeThatIsColderThanItsWall) {
  const auto found = detect("pipe_ax8.jpg", thermal::DetectorPreset::kColdPipes);
  EXPECT_THAT(found.pipes, holds({.row = 28, .least_length = 45, .slack = 2}, 80));
}

TEST_F(RealPictures, NothingLongAndStraightIsNoPipe) {
  // Beside a body that is warmer there is a strip that is colder than the mean about it.
  for (const char* name : {"iguana_sc660.jpg", "duo_pro_r_640x512.fff"}) {
    for (const auto preset :
         {thermal::DetectorPreset::kHotPipes, thermal::DetectorPreset::kColdPipes}) {
      EXPECT_TRUE(detect(name, preset).pipes.empty()) << name << ", " << to_string(preset);
    }
  }
}

TEST_F(RealPictures, NothingAboveTheThresholdIsNoPipe) {
  // None is as hot as a collector: with the settings of a solar plant there is no pipe.
  for (const char* name : {"fluorescent_tubes_t650sc.jpg", "conveyor_zenmuse_xtr.jpg",
                           "pipe_ax8.jpg", "iguana_sc660.jpg", "duo_pro_r_640x512.fff"}) {
    for (const thermal::DetectorPreset preset :
         {thermal::DetectorPreset::kCollectors, thermal::DetectorPreset::kTorresol}) {
      EXPECT_TRUE(detect(name, preset).pipes.empty()) << name;
    }
  }
}

}  // namespace
}  // namespace pipescout
