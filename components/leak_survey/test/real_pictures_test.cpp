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
  [[nodiscard]] thermal::Detections detect(const char* name, SurveyPreset preset) const {
    const ThermalPicture picture = ThermalFileReader({}).read(folder_ / name);
    thermal::LeakDetector detector(detector_of(preset));
    return detector.detect(picture.view());
  }

  fs::path folder_;
};

}  // namespace
}  // namespace pipescout
