// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal_parameters/detection_parameters.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace pipescout {
namespace {

using ::testing::HasSubstr;

std::vector<ParameterOverride> overrides(const std::vector<NamedParameter>& values) {
  std::vector<ParameterOverride> result;
  for (const NamedParameter& value : values) {
    result.push_back({.name = value.name, .value = value.value});
  }
  return result;
}

DetectionSettings read(const std::vector<NamedParameter>& values) {
  Parameters parameters(overrides(values));
  return DetectionParameters(parameters).read();
}

std::string refusal(const std::vector<NamedParameter>& values) {
  try {
    (void)read(values);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "none";
}

TEST(DetectionParametersTest, APresetGivesTheDefaultsOfAllOthers) {
  EXPECT_EQ(read({}).detector.threshold_rule, thermal::ThresholdRule::kFixed);
  const DetectionSettings cold = read({{"preset", "cold_pipes"}});
  EXPECT_EQ(cold.detector.threshold_rule, thermal::ThresholdRule::kLocal);
  EXPECT_EQ(cold.detector.polarity, thermal::Polarity::kCold);
  Parameters parameters(overrides({{"preset", "dragon"}}));
  EXPECT_THROW(DetectionParameters{parameters}, ParameterError);
}

TEST(DetectionParametersTest, WhatIsWrongIsNamed) {
  EXPECT_THAT(refusal({{"threshold_rule", "loose"}}), HasSubstr("'loose' is not one of 'fixed'"));
  EXPECT_THAT(refusal({{"camera.planck", std::vector<double>{1, 2}}}), HasSubstr("camera.planck"));
  EXPECT_THAT(refusal({{"camera.linear", std::vector<double>{-1, 2}}}), HasSubstr("camera.linear"));
  EXPECT_THAT(refusal({{"camera.linear", std::vector<double>{0.01, -273.15}},
                       {"camera.planck", std::vector<double>{21106.77, 0.0125, 1501, 1, -7340}}}),
              HasSubstr("exclude each other"));
  EXPECT_THAT(refusal({{"camera.grey_range", std::vector<double>{300, 100}}}),
              HasSubstr("camera.grey_range"));
  EXPECT_THAT(refusal({{"leak_delta", std::vector<double>{1, 2}}}), HasSubstr("leak_delta"));
}

TEST(DetectionParametersTest, PicturesOfACameraThatIsNotDescribedAreRefusedByName) {
  const std::array<std::uint16_t, 4> counts{};
  const std::array<std::uint8_t, 4> greys{};
  const std::array<float, 4> degrees{};
  const DetectionSettings nothing = read({{"camera.grey_range", std::vector<double>{}}});
  const auto counter = [&nothing](const ThermalImageReader::View& picture) {
    try {
      (void)nothing.celsius_of(picture);
    } catch (const UndescribedPicture& error) {
      return error.counter();
    }
    return std::string("none");
  };
  EXPECT_EQ(counter(thermal::CountView{counts.data(), 2, 2, 2}), "image.counts_without_camera");
  EXPECT_EQ(counter(thermal::GreyView{greys.data(), 2, 2, 2}), "image.grey_without_range");
  EXPECT_EQ(counter(thermal::TemperatureView{degrees.data(), 2, 2, 2}), "none");
}

TEST(DetectionParametersTest, APipeIsFoundWhateverThePixelsAre) {
  constexpr int kWidth = 80;
  constexpr int kHeight = 60;
  std::vector<float> degrees(kWidth * kHeight, 20.0F);
  std::vector<std::uint16_t> counts(degrees.size(), 29315);
  for (int y = 27; y < 34; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      degrees[static_cast<std::size_t>(y * kWidth + x)] = 150.0F;
      counts[static_cast<std::size_t>(y * kWidth + x)] = 42315;
    }
  }
  const DetectionSettings settings = read({{"camera.linear", std::vector<double>{0.01, -273.15}}});
  thermal::LeakDetector detector(settings.detector);
  for (const ThermalImageReader::View& picture :
       {ThermalImageReader::View(thermal::TemperatureView{degrees.data(), kWidth, kHeight, kWidth}),
        ThermalImageReader::View(thermal::CountView{counts.data(), kWidth, kHeight, kWidth})}) {
    const thermal::Detections& found = detect(detector, picture, settings.celsius_of(picture));
    ASSERT_EQ(found.pipes.size(), 1U);
    EXPECT_NEAR(found.pipes.front().start.y(), 30, 0.1);
    EXPECT_NEAR(found.pipes.front().length(), kWidth - 1, 2);
  }
}

}  // namespace
}  // namespace pipescout
