// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cstdlib>
#include <functional>
#include <limits>

#include "pipe_pictures_helpers.hpp"
#include "pipescout/thermal/leak_detector.hpp"
#include "pipescout/thermal/temperature_table.hpp"

namespace pipescout::thermal {
namespace {

using test::Picture;

constexpr int kWidth = 160;
constexpr int kHeight = 120;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

class LeakDetectorFaults : public testing::Test {
 protected:
  LeakDetector detector_{LeakDetectorParameters{}};

  void TearDown() override {
    // The next frame is fine.
    Picture picture(kWidth, kHeight);
    picture.pipe({-5, 60}, {165, 60}, 4, 150, {{60, 90, 250}});
    const Detections& d = detector_.detect(picture.view());
    EXPECT_EQ(d.fault, FrameFault::kNone);
    EXPECT_EQ(d.pipes.size(), 1U);
    EXPECT_EQ(d.leaks.size(), 1U);
  }
};

/// Pixels spread over the picture that hold a value which is no temperature of the scene.
TEST(ExtremePixels, HideNeitherPipesNorLeaks) {
  LeakDetector detector(LeakDetectorParameters::of(DetectorPreset::kHotPipes));
  for (const float extreme : {300.0F, 1500.0F, 9999.0F, 3.4e38F, -9999.0F, -3.4e38F,
                              std::numeric_limits<float>::infinity(), kNan}) {
    for (const int count : {0, 1, 190}) {
      Picture picture(kWidth, kHeight);
      picture.noise(0.1, 7);
      picture.pipe({-5, 60}, {165, 60}, 4, 60, {{60, 90, 80}});
      for (int i = 0; i < count; ++i) {
        // 61 and 37 share no divisor with the sizes; the rows of the pipe are left out.
        const int y = (5 + i * 37) % kHeight;
        picture.at((3 + i * 61) % kWidth, std::abs(y - 60) < 8 ? 5 : y) = extreme;
      }
      const Detections& d = detector.detect(picture.view());
      EXPECT_EQ(d.fault, FrameFault::kNone) << extreme << ", " << count;
      EXPECT_EQ(d.pipes.size(), 1U) << extreme << ", " << count;
      EXPECT_EQ(d.leaks.size(), 1U) << extreme << ", " << count;
    }
  }
}

TEST_F(LeakDetectorFaults, NoPixels) {
  EXPECT_EQ(detector_.detect(TemperatureView{}).fault, FrameFault::kBadShape);
  const float pixel = 20;
  EXPECT_EQ(detector_.detect(TemperatureView{&pixel, 0, 1, 1}).fault, FrameFault::kBadShape);
  EXPECT_EQ(detector_.detect(TemperatureView{&pixel, 1, -1, 1}).fault, FrameFault::kBadShape);
}

TEST_F(LeakDetectorFaults, AStrideBelowTheWidth) {
  const Picture picture(kWidth, kHeight);
  EXPECT_EQ(detector_.detect({picture.view().data, kWidth, kHeight, kWidth - 1}).fault,
            FrameFault::kBadShape);
}

TEST_F(LeakDetectorFaults, OnePixel) {
  const float pixel = 150;
  EXPECT_EQ(detector_.detect(TemperatureView{&pixel, 1, 1, 1}).fault, FrameFault::kSaturated);
}

TEST_F(LeakDetectorFaults, AllNan) {
  EXPECT_EQ(detector_.detect(Picture(kWidth, kHeight, kNan).view()).fault,
            FrameFault::kNoTemperature);
}

TEST_F(LeakDetectorFaults, AllBeyondAnyBody) {
  Picture hot(kWidth, kHeight, 2600);
  hot.at(3, 3) = 3300;
  EXPECT_EQ(detector_.detect(hot.view()).fault, FrameFault::kNoTemperature);
  // Hundredths of a kelvin, told as tenths.
  std::vector<std::uint16_t> counts(kWidth * kHeight, 29500);
  counts[7] = 36000;
  const TemperatureTable tenths(0.1, -273.15);
  EXPECT_EQ(
      detector_.detect(CountView{counts.data(), kWidth, kHeight, kWidth}, tenths.degrees()).fault,
      FrameFault::kNoTemperature);
}

TEST_F(LeakDetectorFaults, AllSaturated) {
  EXPECT_EQ(detector_.detect(Picture(kWidth, kHeight, 300).view()).fault, FrameFault::kSaturated);
  const std::vector<std::uint16_t> counts(kWidth * kHeight, 65535);
  EXPECT_EQ(
      detector_.detect(CountView{counts.data(), kWidth, kHeight, kWidth}, Picture::table()).fault,
      FrameFault::kSaturated);
}

TEST_F(LeakDetectorFaults, SomeNanAreNoPipe) {
  Picture picture(kWidth, kHeight);
  picture.pipe({-5, 60}, {165, 60}, 4, 150).box(0, 0, kWidth, 40, kNan).box(70, 50, 20, 30, kNan);
  const Detections& d = detector_.detect(picture.view());
  EXPECT_EQ(d.fault, FrameFault::kNone);
  EXPECT_EQ(d.pipes.size(), 1U);
}

TEST_F(LeakDetectorFaults, TablesThatFallOrAreEmpty) {
  const std::vector<std::uint16_t> counts = Picture(kWidth, kHeight).noise(1, 1).counts(kWidth);
  const CountView view{counts.data(), kWidth, kHeight, kWidth};
  EXPECT_EQ(detector_.detect(view, {}).fault, FrameFault::kBadTable);
  std::vector<float> table = Picture::table();
  table[30000] = 0;
  EXPECT_EQ(detector_.detect(view, table).fault, FrameFault::kBadTable);
  table = Picture::table();
  table[30000] = kNan;  // not at an end
  EXPECT_EQ(detector_.detect(view, table).fault, FrameFault::kBadTable);
  table.assign(table.size(), kNan);
  EXPECT_EQ(detector_.detect(view, table).fault, FrameFault::kBadTable);
}

TEST_F(LeakDetectorFaults, CountsWithoutATemperatureAreNoPipe) {
  Picture picture(kWidth, kHeight);
  picture.pipe({-5, 60}, {165, 60}, 4, 150);
  const std::vector<std::uint16_t> counts = picture.counts(kWidth);
  const CountView view{counts.data(), kWidth, kHeight, kWidth};
  std::vector<float> table = Picture::table();
  std::fill(table.begin(), table.begin() + 15000, kNan);  // what is below 50 degC
  EXPECT_EQ(detector_.detect(view, table).pipes.size(), 1U);
  table = Picture::table();
  table.resize(15000);
  EXPECT_EQ(detector_.detect(view, table).pipes.size(), 0U);
}

TEST_F(LeakDetectorFaults, AThresholdInTheBackgroundIsClutter) {
  Picture picture(640, 512, 100);
  picture.noise(3, 1);
  LeakDetectorParameters p;
  p.min_width = 1;
  LeakDetector all(p);
  EXPECT_EQ(all.detect(picture.view()).fault, FrameFault::kCluttered);
  EXPECT_TRUE(all.detect(picture.view()).pipes.empty());
}

TEST(LeakDetectorParameters, RefusalsNameTheField) {
  using Change = std::function<void(LeakDetectorParameters&)>;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<const char*, Change>> changes{
      {"threshold: nan", [&](auto& p) { p.threshold = nan; }},
      {"min_contrast: 0", [](auto& p) { p.min_contrast = 0; }},
      {"local_radius: 2", [](auto& p) { p.local_radius = 2; }},
      {"min_width: 0", [](auto& p) { p.min_width = 0; }},
      {"max_width: 1.5", [](auto& p) { p.max_width = 1.5; }},
      {"min_length: 0", [](auto& p) { p.min_length = 0; }},
      {"min_elongation: 0", [](auto& p) { p.min_elongation = 0; }},
      {"min_visible: -1", [](auto& p) { p.min_visible = -1; }},
      {"straightness: 0", [](auto& p) { p.straightness = 0; }},
      {"max_gap: -1", [](auto& p) { p.max_gap = -1; }},
      {"profile_width: 2", [](auto& p) { p.profile_width = 2; }},
      {"pipe_diameter: -1", [](auto& p) { p.pipe_diameter = -1; }},
      {"max_pipes: 0", [](auto& p) { p.max_pipes = 0; }},
      {"severe_delta: 10", [](auto& p) { p.severity.severe_delta = 10; }},
      {"split_delta: 0", [](auto& p) { p.profile.split_delta = 0; }},
      {"split_distance: 0", [](auto& p) { p.profile.split_distance = 0; }},
      {"min_part_width: 0", [](auto& p) { p.profile.min_part_width = 0; }},
      {"min_part_width_m: -1", [](auto& p) { p.profile.min_part_width_m = -1; }},
      {"leak_delta: 0", [](auto& p) { p.profile.leak_delta = 0; }},
      {"leak_delta: is not set", [](auto& p) { p.profile.leak_delta.reset(); }},
      {"maximum_temperature: -300", [](auto& p) { p.profile.maximum_temperature = -300; }},
      {"reference_quantile: 1", [](auto& p) { p.profile.reference_quantile = 1; }},
      {"leak_delta: is not set; on cold",
       [](auto& p) {
         p.polarity = Polarity::kCold;
         p.profile = ProfileParameters::torresol();
       }},
  };
  for (const auto& [message, change] : changes) {
    LeakDetectorParameters p;
    change(p);
    EXPECT_THAT([&] { p.validate(); },
                testing::ThrowsMessage<std::invalid_argument>(testing::StartsWith(message)));
  }
  EXPECT_NO_THROW(LeakDetectorParameters::torresol().validate());
  EXPECT_NO_THROW(LeakDetectorParameters::adaptive(Polarity::kCold).validate());
}

TEST(Severity, ByDeltaAndLength) {
  const SeverityScale scale;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(scale.of(75, 0.3), Severity::kMinor);
  EXPECT_EQ(scale.of(90, nan), Severity::kModerate);
  EXPECT_EQ(scale.of(75, 1), Severity::kModerate);
  EXPECT_EQ(scale.of(130, 0.3), Severity::kSevere);
  EXPECT_EQ(scale.of(150, 4), Severity::kCritical);
  EXPECT_EQ(to_string(Severity::kCritical), "critical");
  EXPECT_EQ(to_string(static_cast<Severity>(9)), "unknown");
  EXPECT_EQ(to_string(FrameFault::kCluttered), "cluttered");
  EXPECT_EQ(to_string(PartKind::kNotThisPipe), "not_this_pipe");
}

TEST(DetectorPreset, IsKnownByItsName) {
  for (const DetectorPreset preset : kDetectorPresets) {
    EXPECT_EQ(detector_preset(to_string(preset)), preset);
    EXPECT_NO_THROW(LeakDetectorParameters::of(preset).validate());
  }
  EXPECT_FALSE(detector_preset("").has_value());
  EXPECT_EQ(LeakDetectorParameters::of(DetectorPreset::kColdPipes).polarity, Polarity::kCold);
}

}  // namespace
}  // namespace pipescout::thermal
