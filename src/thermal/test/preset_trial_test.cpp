// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal/preset_trial.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "pipe_pictures_helpers.hpp"

namespace pipescout::thermal {
namespace {

using test::Picture;
using ::testing::Field;
using ::testing::IsEmpty;

constexpr int kWidth = 160;
constexpr int kHeight = 120;

Picture with_pipe(double celsius) {
  Picture picture(kWidth, kHeight);
  picture.noise(0.05, 3);
  picture.pipe({-5, 60}, {165, 60}, 4, celsius);
  return picture;
}

TEST(PresetTrial, FindsThePresetsThatFindPipes) {
  PresetTrial trial;
  for (int i = 0; i < 3; ++i) {
    trial.keep(with_pipe(85).view());
  }
  const auto outcomes = trial.try_others(DetectorPreset::kCollectors);
  ASSERT_FALSE(outcomes.empty());
  EXPECT_EQ(outcomes[0].preset, DetectorPreset::kHotPipes);
  EXPECT_EQ(outcomes[0].with_pipes, 3U);
  EXPECT_THAT(trial.try_others(DetectorPreset::kHotPipes),
              ::testing::Not(::testing::Contains(
                  Field(&PresetTrial::Outcome::preset, DetectorPreset::kCollectors))));
}

TEST(PresetTrial, FindsNothingWhereThereIsNothing) {
  PresetTrial trial;
  EXPECT_EQ(trial.temperatures(), std::nullopt);
  trial.keep(TemperatureView{});
  EXPECT_EQ(trial.images(), 0U);
  trial.keep(Picture(kWidth, kHeight).noise(0.05, 3).view());
  EXPECT_THAT(trial.try_others(DetectorPreset::kCollectors), IsEmpty());
}

TEST(PresetTrial, TemperaturesAreNotThoseOfAFewPixels) {
  PresetTrial trial;
  Picture picture = with_pipe(85);
  picture.at(2, 2) = 1500;
  picture.at(3, 3) = std::numeric_limits<float>::quiet_NaN();
  picture.at(4, 4) = -60;
  trial.keep(picture.view());
  const auto range = trial.temperatures();
  ASSERT_TRUE(range.has_value());
  EXPECT_NEAR(range->low, 20, 0.3);
  EXPECT_NEAR(range->high, 85, 0.3);
}

TEST(PresetTrial, KeepsAFewSpreadOverTheRecording) {
  PresetTrial trial;
  constexpr int kImages = 1000;
  for (int i = 0; i < kImages; ++i) {
    trial.keep(Picture(8, 8, static_cast<float>(i)).view());
    ASSERT_LE(trial.images(), PresetTrial::kMostImages);
  }
  EXPECT_GE(trial.images(), PresetTrial::kMostImages / 2);
  const auto range = trial.temperatures();
  ASSERT_TRUE(range.has_value());
  EXPECT_EQ(range->low, 0);
  // Of the last eighth.
  EXPECT_GE(range->high, kImages * 7 / 8);
}

}  // namespace
}  // namespace pipescout::thermal
