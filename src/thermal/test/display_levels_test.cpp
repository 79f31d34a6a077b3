// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal/display_levels.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <vector>

namespace pipescout::thermal {
namespace {

TEST(DisplayLevels, SpreadOverTheTemperaturesOfTheScene) {
  std::vector<float> degrees(100 * 100);
  for (std::size_t i = 0; i < degrees.size(); ++i) {
    degrees[i] = 20.0F + static_cast<float>(i % 100);
  }
  degrees[5] = 1500;
  degrees[6] = std::numeric_limits<float>::quiet_NaN();
  const auto levels = display_levels(TemperatureView{degrees.data(), 100, 100, 100});
  ASSERT_EQ(levels.size(), degrees.size());
  EXPECT_EQ(levels[5], 255);
  EXPECT_EQ(levels[6], 0);
  EXPECT_EQ(levels[100], 0);
  EXPECT_NEAR(levels[150], 129, 3);
  EXPECT_EQ(levels[199], 255);
}

TEST(DisplayLevels, RowsMayBeApartAndAllTheSame) {
  const std::vector<std::uint16_t> counts{7, 7, 99, 7, 7, 99};
  EXPECT_EQ(display_levels(CountView{counts.data(), 2, 2, 3}), std::vector<std::uint8_t>(4, 0));
  const std::vector<std::uint8_t> grey{0, 200};
  EXPECT_EQ(display_levels(GreyView{grey.data(), 2, 1, 2}).size(), 2U);
  EXPECT_THROW((void)display_levels(GreyView{}), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::thermal
