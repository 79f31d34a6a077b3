// SPDX-License-Identifier: Apache-2.0
// In a program that has set a locale with decimal commas.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "flir_file.hpp"
#include "picture_time.hpp"
#include "pipescout/files/testing/comma_locale.hpp"
#include "pipescout/thermal_files/testing/synthetic_flir.hpp"
#include "pipescout/thermal_files/thermal_file.hpp"
#include "pipescout/thermal_files/yaml_entries.hpp"

namespace pipescout {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Optional;
using ::testing::ThrowsMessage;

TEST(CommaLocale, YamlHasPoints) {
  const ::pipescout::testing::CommaLocale locale;
  ASSERT_EQ(std::to_string(1.5), "1,500000") << "the locale is not set";
  const ThermalSettings settings = parse_thermal_settings(
      "object: {emissivity: 0.9, reflected_temperature: -12.5}\n"
      "scale: {gain: 1e-2, offset: -273.15}\n"
      "regions: [{x: 1000, y: 0, width: 12345, height: 1}]\n"
      "range: {least: 1000, most: 65535}\n",
      "thermal.yaml");
  EXPECT_DOUBLE_EQ(settings.object.emissivity.value_or(0), 0.9);
  EXPECT_DOUBLE_EQ(settings.scale->offset, -273.15);
  const ThermalSettings again = parse_thermal_settings(to_yaml(settings), "again");
  EXPECT_EQ(again.regions.at(0).width, 12345);
  EXPECT_EQ(again.range->most, 65535);
  EXPECT_THAT([] { (void)parse_thermal_settings("object: {emissivity: '0,9'}", "a"); },
              ThrowsMessage<std::runtime_error>(HasSubstr("'0,9' is not a number")));
}

TEST(CommaLocale, FlirFilesAreReadAsEver) {
  const ::pipescout::testing::CommaLocale locale;
  const ::pipescout::testing::TemporaryFolder folder;
  test::SyntheticFlir flir;
  flir.emissivity = 0.7F;
  const auto file = folder.path() / "a.fff";
  std::ofstream(file, std::ios::binary) << flir.bytes();
  const ThermalPicture picture = ThermalFileReader({}).read(file);
  EXPECT_THAT(picture.taken, Optional(1700000000.0));
  EXPECT_NEAR(picture.radiometry->camera().atmosphere.alpha1, 0.006569, 1e-9);
  EXPECT_THAT(picture.doubts, Contains(HasSubstr("emissivity 0.7: ")));
  EXPECT_THAT(exif_time("2013:04:16 15:12:26.104-05:00"), Optional(1366143146.104));
}

TEST(YamlNumbers, AreThoseOfYaml) {
  const YamlEntries entries("a.yaml");
  const auto number = [&](const std::string& text) { return entries.number(YAML::Load(text)); };
  EXPECT_EQ(number("+2.5e3"), 2500);
  EXPECT_EQ(number("-.inf"), -std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::isnan(number(".nan")));
  for (const char* bad : {"1,5", "inf", "nan(1)", "0x1p3", "1 2", "''", "--1"}) {
    EXPECT_THROW((void)number(bad), std::runtime_error) << bad;
  }
  EXPECT_EQ(entries.whole(YAML::Load("-12")), -12);
  EXPECT_THROW((void)entries.whole(YAML::Load("12.5")), std::runtime_error);
}

}  // namespace
}  // namespace pipescout
