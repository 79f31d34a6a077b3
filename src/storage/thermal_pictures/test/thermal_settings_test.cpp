// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal_files/thermal_settings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pipescout {
namespace {

using ::testing::StartsWith;
using ::testing::ThrowsMessage;

ThermalSettings parse(const std::string& text) {
  return parse_thermal_settings(text, "thermal.yaml");
}

TEST(ThermalSettings, NothingChangesNothing) {
  const ThermalSettings settings = parse("");
  EXPECT_FALSE(settings.scale || settings.planck || settings.grey || settings.range);
  EXPECT_DOUBLE_EQ(settings.object.apply({.emissivity = 0.5}).emissivity, 0.5);
}

TEST(ThermalSettings, TakesAll) {
  const ThermalSettings settings = parse(R"(
object: {emissivity: 0.9, distance: 12}
regions:
  - {x: 1, y: 2, width: 3, height: 4, object: {emissivity: 0.3}}
deviations: {emissivity: 0.05, calibration: 2}
planck: {r1: 21106.77, r2: 0.0125, b: 1501, f: 1, o: -7340}
grey: {black: 100, white: 300}
float_unit: kelvin
air_path: window_midway
range: {least: 10, most: 60000}
)");
  const thermal::ObjectParameters object = settings.object.apply({.relative_humidity = 0.1});
  EXPECT_DOUBLE_EQ(object.emissivity, 0.9);
  EXPECT_DOUBLE_EQ(object.distance, 12);
  EXPECT_DOUBLE_EQ(object.relative_humidity, 0.1);
  ASSERT_EQ(settings.regions.size(), 1U);
  EXPECT_EQ(settings.regions[0].height, 4);
  EXPECT_DOUBLE_EQ(settings.regions[0].object.apply(object).emissivity, 0.3);
  EXPECT_DOUBLE_EQ(settings.regions[0].object.apply(object).distance, 12);
  EXPECT_DOUBLE_EQ(settings.deviations.calibration, 2);
  ASSERT_TRUE(settings.planck.has_value());
  EXPECT_DOUBLE_EQ(settings.planck->o, -7340);
  EXPECT_EQ(settings.float_unit, TemperatureUnit::kKelvin);
  EXPECT_EQ(settings.air_path, thermal::AirPath::kWindowMidway);
  ASSERT_TRUE(settings.range && settings.grey);
  EXPECT_EQ(settings.range->most, 60000);
  EXPECT_DOUBLE_EQ(settings.grey->white, 300);
  EXPECT_DOUBLE_EQ(parse("scale: {gain: 0.04, offset: -273.15}").scale->gain, 0.04);
}

TEST(ThermalSettings, APresetMayBeChanged) {
  const thermal::ObjectParameters object =
      parse("object: {distance: 8}\npreset: ibarguren2013").object.apply({});
  EXPECT_DOUBLE_EQ(object.emissivity, 0.04);
  EXPECT_DOUBLE_EQ(object.distance, 8);
}

TEST(ThermalSettings, ErrorsNameFileAndLine) {
  const auto throws = [](const char* begin) {
    return ThrowsMessage<std::runtime_error>(StartsWith(begin));
  };
  const auto parsing = [](const char* text) { return [text] { (void)parse(text); }; };
  EXPECT_THAT(parsing("a: ["), throws("thermal.yaml:"));
  EXPECT_THAT(parsing("- 1"), throws("thermal.yaml:1: the file is not a map"));
  EXPECT_THAT(parsing("\nobjekt: 1"), throws("thermal.yaml:2: unknown name 'objekt'; there is"));
  EXPECT_THAT(parsing("float_unit: kelvin\nfloat_unit: kelvin"),
              throws("thermal.yaml:2: 'float_unit' is given twice"));
  EXPECT_THAT(parsing("object: {emissivity: high}"),
              throws("thermal.yaml:1: 'high' is not a number"));
  EXPECT_THAT(parsing("object:\n  emissivity: 1.5"),
              throws("thermal.yaml:2: emissivity: 1.5 is outside (0, 1]"));
  EXPECT_THAT(parsing("object: 3"), throws("thermal.yaml:1: object is not a map"));
  EXPECT_THAT(parsing("preset: torresol"),
              throws("thermal.yaml:1: 'torresol' is not one of ibarguren2013"));
  EXPECT_THAT(parsing("regions: {}"), throws("thermal.yaml:1: regions is not a list"));
  EXPECT_THAT(parsing("regions: [{x: 1, y: 1}]"), throws("thermal.yaml:1: a region needs"));
  EXPECT_THAT(parsing("scale: {gain: 0, offset: 1}"), throws("thermal.yaml:1: gain: 0"));
  EXPECT_THAT(parsing("grey: {black: 5, white: 5}"), throws("thermal.yaml:1: white: 5"));
  EXPECT_THAT(parsing("planck: {r1: 1}"), throws("thermal.yaml:1: planck.r2: 0"));
  EXPECT_THAT(parsing("range: {least: 5, most: 70000}"), throws("thermal.yaml:1: range needs"));
  EXPECT_THAT(parsing("deviations: {counts: -1}"), throws("thermal.yaml:1: deviations.counts"));
  EXPECT_THAT(parsing("scale: {gain: 1, offset: 0}\n"
                      "planck: {r1: 21106, r2: 0.0125, b: 1501, f: 1, o: 0}"),
              throws("thermal.yaml:1: scale and planck"));
  EXPECT_THAT([] { (void)read_thermal_settings("/nowhere/thermal.yaml"); },
              throws("/nowhere/thermal.yaml: cannot be read"));
}

}  // namespace
}  // namespace pipescout
