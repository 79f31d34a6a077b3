// SPDX-License-Identifier: Apache-2.0
#include "column_mapping.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipescout/files/yaml_location.hpp"

namespace pipescout::ledger {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr const char* kLeast =
    "distance: log [ft]\nunit: feet\nkind: event\ngirth_weld: Girth Weld\n";

TEST(ColumnMapping, NeedsDistanceUnitKindAndGirthWeld) {
  const auto mapping = parse_column_mapping(kLeast, "m.yaml");
  EXPECT_FALSE(mapping.format.delimiter);
  EXPECT_EQ(mapping.format.settings, "m.yaml");
  EXPECT_EQ(mapping.distance.name, "log [ft]");
  EXPECT_EQ(mapping.distance.location, "m.yaml:1:11");
  EXPECT_DOUBLE_EQ(mapping.metres_per_unit, 0.3048);
  EXPECT_THAT(mapping.girth_welds, ElementsAre("Girth Weld"));
  EXPECT_FALSE(mapping.clock || mapping.relative_distance || mapping.latitude || mapping.height);
}

TEST(ColumnMapping, ReadsAll) {
  const auto mapping = parse_column_mapping(R"(delimiter: tab
decimal_mark: ','
distance: d
unit: metres
kind: k
girth_weld: [Girth Weld, GWD]
clock: o'clock
relative_distance: r
latitude: lat
longitude: lon
height: h
height_unit: feet
odometer_standard_deviation: 0.02
weld_standard_deviation: 0.1
position_standard_deviation: 2
)",
                                            "m.yaml");
  EXPECT_EQ(mapping.format.delimiter, '\t');
  EXPECT_EQ(mapping.format.decimal_mark, ',');
  EXPECT_DOUBLE_EQ(mapping.metres_per_unit, 1.0);
  EXPECT_THAT(mapping.girth_welds, ElementsAre("Girth Weld", "GWD"));
  EXPECT_EQ(mapping.clock->name, "o'clock");
  EXPECT_EQ(mapping.relative_distance->name, "r");
  EXPECT_EQ(mapping.latitude->name, "lat");
  EXPECT_EQ(mapping.longitude->name, "lon");
  EXPECT_EQ(mapping.height->name, "h");
  EXPECT_DOUBLE_EQ(mapping.metres_per_height_unit, 0.3048);
  EXPECT_DOUBLE_EQ(mapping.odometer_standard_deviation, 0.02);
  EXPECT_DOUBLE_EQ(mapping.weld_standard_deviation, 0.1);
  EXPECT_DOUBLE_EQ(mapping.position_standard_deviation, 2.0);
}

TEST(ColumnMapping, ShippedOnesAreRead) {
  for (const char* name : {"ili_2007.yaml", "ili_2015.yaml"}) {
    const auto mapping = load_column_mapping(std::string(COLUMNS_FOLDER) + "/" + name);
    EXPECT_DOUBLE_EQ(mapping.metres_per_unit, 0.3048) << name;
    EXPECT_TRUE(mapping.clock && mapping.relative_distance) << name;
  }
}

std::string error_of(const std::string& text) {
  try {
    (void)parse_column_mapping(text, "m.yaml");
  } catch (const YamlError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ColumnMapping, ErrorsNameFileLineAndKey) {
  const std::string least = kLeast;
  EXPECT_THAT(error_of(least + "clok: c\n"),
              StartsWith("m.yaml:5:1: unknown key 'clok' in a mapping of columns; did you mean "
                         "'clock'? (known: delimiter, decimal_mark, distance, "));
  EXPECT_THAT(error_of("distance: d\n"), HasSubstr("key 'unit' is missing"));
  EXPECT_THAT(error_of("distance: d\nunit: yards\n"),
              "m.yaml:2:7: unit must be one of metres (m), millimetres (mm), centimetres (cm), "
              "kilometres (km), feet (ft), not 'yards'");
  EXPECT_THAT(error_of("distance: d\nunit: feet\nkind: k\n"), HasSubstr("'girth_weld' is missing"));
  EXPECT_THAT(error_of("distance: log [mm]\nunit: metres\nkind: k\ngirth_weld: w\n"),
              "m.yaml:2:7: unit is 'metres', and the column 'log [mm]' says mm");
  EXPECT_THAT(error_of("distance: [a, b]\n"), "m.yaml:1:11: distance must be a text");
  EXPECT_THAT(error_of("distance: d\nunit: feet\nkind: k\ngirth_weld: []\n"),
              "m.yaml:4:13: girth_weld must be a text or a list of texts");
  EXPECT_THAT(error_of("distance: d\nunit: feet\nkind: k\ngirth_weld: {a: b}\n"),
              "m.yaml:4:13: girth_weld must be a text or a list of texts");
  EXPECT_THAT(error_of(least + "delimiter: x\n"),
              "m.yaml:5:12: delimiter must be ',', ';', '|', tab or blank, not 'x'");
  EXPECT_THAT(error_of(least + "decimal_mark: ;\n"),
              "m.yaml:5:15: decimal_mark must be '.' or ',', not ';'");
  EXPECT_THAT(error_of(least + "latitude: a\n"),
              "m.yaml:5:11: latitude and longitude belong together; one of them is missing");
  EXPECT_THAT(error_of(least + "longitude: a\n"), StartsWith("m.yaml:5:12: latitude and"));
  EXPECT_THAT(error_of(least + "height: a\n"),
              "m.yaml:5:9: a height needs a latitude and a longitude");
  EXPECT_THAT(error_of(least + "height_unit: feet\n"), "m.yaml:5:14: height_unit needs a height");
  EXPECT_THAT(error_of(least + "weld_standard_deviation: 0\n"),
              "m.yaml:5:26: weld_standard_deviation must be a number in (0, 10], not '0'");
  EXPECT_THAT(error_of(least + "odometer_standard_deviation: nan\n"),
              HasSubstr("must be a number in (0, 1], not 'nan'"));
  EXPECT_THAT(error_of("- a\n"), HasSubstr("must be a map with the keys"));
  EXPECT_THAT(error_of(""), HasSubstr("must be a map with the keys"));
  EXPECT_THAT(error_of("distance: a\ndistance: b\n"), StartsWith("m.yaml:2"));
}

}  // namespace
}  // namespace pipescout::ledger
