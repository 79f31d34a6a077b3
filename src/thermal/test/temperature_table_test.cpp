// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal/temperature_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "camera_helpers.hpp"

namespace pipescout::thermal {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(TemperatureTable, IsTheRadiometryOfEveryCount) {
  const Radiometry radiometry(test::sc660(), {});
  const TemperatureTable table(radiometry);
  ASSERT_EQ(table.degrees().size(), 65536U);
  for (std::uint32_t i = 0; i < 65536; i += 13) {
    const auto count = static_cast<std::uint16_t>(i);
    const double expected = radiometry.temperature(i);
    if (std::isnan(expected)) {
      EXPECT_TRUE(std::isnan(table[count]));
    } else {
      EXPECT_FLOAT_EQ(table[count], static_cast<float>(expected));
    }
  }
}

TEST(TemperatureTable, FindsTheFirstCountOfATemperature) {
  const TemperatureTable table(Radiometry(test::sc660(), ibarguren2013_object()));
  const std::uint32_t first = table.first_at_least(100);
  ASSERT_GT(first, 0U);
  ASSERT_LT(first, 65536U);
  EXPECT_GE(table[static_cast<std::uint16_t>(first)], 100);
  EXPECT_LT(table[static_cast<std::uint16_t>(first - 1)], 100);
  EXPECT_EQ(table.first_at_least(1e6), 65536U);
  EXPECT_FALSE(std::isnan(table[static_cast<std::uint16_t>(table.first_at_least(-300))]));
}

TEST(TemperatureTable, LinearAndGrey) {
  const TemperatureTable kelvin(0.01, -273.15);
  EXPECT_FLOAT_EQ(kelvin[30000], 26.85F);
  EXPECT_EQ(kelvin.first_at_least(26.845), 30000U);
  // What no body has, at either end.
  EXPECT_TRUE(std::isnan(kelvin[0]));
  const TemperatureTable tenths(0.1, -273.15);
  EXPECT_TRUE(std::isnan(tenths[29000]));
  EXPECT_FLOAT_EQ(tenths[22000], 1926.85F);
  EXPECT_EQ(tenths.first_at_least(1926), 21992U);
  EXPECT_EQ(tenths.first_at_least(2500), 65536U);
  const TemperatureTable grey = TemperatureTable::of_grey(100, 300);
  EXPECT_FLOAT_EQ(grey[0], 100);
  EXPECT_FLOAT_EQ(grey[255], 300);
  EXPECT_FLOAT_EQ(grey[51], 140);
  EXPECT_TRUE(std::isnan(grey[256]));
  EXPECT_EQ(grey.first_at_least(300), 255U);
  EXPECT_EQ(grey.first_at_least(301), 65536U);
  EXPECT_THAT([] { (void)TemperatureTable::of_grey(300, 100); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("white: 100 is outside (black")));
  EXPECT_THAT([] { TemperatureTable(0, 1); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("gain: 0 is outside")));
}

TEST(TemperatureTable, CountsWhatHasNoTemperatureAndWhatIsSaturated) {
  const Radiometry radiometry(test::sc660(), ibarguren2013_object());
  const TemperatureTable table(radiometry, {.least = 100, .most = 60000});
  const std::array<std::uint16_t, 6> counts = {0, 100, 101, 59999, 60000, 65535};
  std::array<float, 6> degrees{};
  const PixelCount count = table.convert(counts, degrees);
  EXPECT_EQ(count, (PixelCount{
                       .pixels = 6, .without_temperature = 3, .below_range = 2, .above_range = 2}));
  EXPECT_TRUE(std::isnan(degrees[2]));
  EXPECT_FLOAT_EQ(degrees[3], table[59999]);
}

TEST(TemperatureTable, RefusesOtherSizes) {
  const TemperatureTable table(1, 0);
  const std::array<std::uint16_t, 6> counts{};
  std::array<float, 6> degrees{};
  EXPECT_THROW(table.convert(counts, std::span(degrees).first(5)), std::invalid_argument);
  EXPECT_THROW(table.convert(CountView{counts.data(), 3, 2, 2}, degrees), std::invalid_argument);
  EXPECT_THROW(table.convert(CountView{counts.data(), 0, 2, 3}, degrees), std::invalid_argument);
  EXPECT_THROW(table.convert(CountView{counts.data(), 2, 2, 3}, degrees), std::invalid_argument);
  EXPECT_THROW(TemperatureTable(1, 0, {.least = 5, .most = 5}), std::invalid_argument);
}

TEST(TemperatureTable, RowsMayBeApart) {
  const TemperatureTable table(1, 0);
  const std::array<std::uint16_t, 6> counts = {1, 2, 9, 3, 4, 9};
  std::array<float, 4> degrees{};
  EXPECT_EQ(table.convert(CountView{counts.data(), 2, 2, 3}, degrees).pixels, 4U);
  EXPECT_THAT(degrees, ::testing::ElementsAre(1, 2, 3, 4));
}

TEST(RegionTables, EachPixelByTheLastRegionThatHoldsIt) {
  const CameraConstants camera = test::sc660();
  ObjectParameters bare;
  bare.emissivity = 0.3;
  ObjectParameters paint;
  paint.emissivity = 0.9;
  const std::vector<Region> regions = {{2, 1, 5, 4, bare}, {5, 3, 100, 100, paint}};
  const RegionTables tables(camera, {}, regions);
  constexpr int kWidth = 12;
  constexpr int kHeight = 7;
  const std::vector<std::uint16_t> counts(kWidth * kHeight, 24000);
  std::vector<float> degrees(counts.size());
  const PixelCount count =
      tables.convert(CountView{counts.data(), kWidth, kHeight, kWidth}, degrees);
  EXPECT_EQ(count.pixels, counts.size());
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool in_paint = x >= 5 && y >= 3;
      const bool in_bare = x >= 2 && x < 7 && y >= 1 && y < 5;
      const ObjectParameters object = in_paint ? paint : in_bare ? bare : ObjectParameters{};
      EXPECT_FLOAT_EQ(degrees[static_cast<std::size_t>(y * kWidth + x)],
                      static_cast<float>(Radiometry(camera, object).temperature(24000)))
          << x << ", " << y;
    }
  }
}

TEST(RegionTables, NameTheRegionThatIsWrong) {
  ObjectParameters bad;
  bad.emissivity = 2;
  const auto with = [](Region region) {
    return [region] { RegionTables(test::sc660(), {}, std::array{region}); };
  };
  EXPECT_THAT(with({0, 0, 1, 1, bad}), ThrowsMessage<std::invalid_argument>(
                                           HasSubstr("regions[0].emissivity: 2 is outside")));
  EXPECT_THAT(with({0, 0, 0, 1, {}}),
              ThrowsMessage<std::invalid_argument>(HasSubstr("regions[0]: 0 x 1")));
  EXPECT_THAT(with({-1, 0, 1, 1, {}}),
              ThrowsMessage<std::invalid_argument>(HasSubstr("regions[0]: begins at (-1, 0)")));
}

}  // namespace
}  // namespace pipescout::thermal
