// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_store/leak_exports.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "example_findings.hpp"
#include "pipescout/files/testing/comma_locale.hpp"

namespace pipescout {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const std::vector<leak_findings::Finding> kFindings = {test::example_finding(1),
                                                       test::bare_finding(2)};
// San Jose del Valle.
const geometry::GeodeticPosition kDatum{.latitude = 36.66, .longitude = -5.8, .altitude = 60};

TEST(LeakExports, AreTheSameInALocaleWithCommas) {
  const auto all = [] {
    return leaks_geojson(kFindings, kDatum) + leaks_kml(kFindings, kDatum) +
           leaks_csv(kFindings, kDatum);
  };
  const std::string before = all();
  const ::pipescout::testing::CommaLocale locale;
  EXPECT_EQ(all(), before);
}

TEST(LeaksGeoJson, IsACollectionOfPoints) {
  const auto json = nlohmann::json::parse(leaks_geojson(kFindings, kDatum));
  EXPECT_EQ(json["type"], "FeatureCollection");
  ASSERT_EQ(json["features"].size(), 2U);
  const auto& first = json["features"][0];
  EXPECT_EQ(first["geometry"]["type"], "Point");
  const auto& at = first["geometry"]["coordinates"];
  const Eigen::Vector3d back = geometry::LocalFrame(kDatum).position(
      {.latitude = at[1], .longitude = at[0], .altitude = at[2]});
  EXPECT_LT((back - kFindings[0].position->point).norm(), 0.02);
  EXPECT_EQ(first["properties"]["severity"], "moderate");
  EXPECT_EQ(first["properties"]["mean_delta_k"], 85.5);
  EXPECT_EQ(first["properties"]["first_time"], "2013-10-09T06:27:40.000Z");
  EXPECT_NEAR(first["properties"]["map_x_deviation"], 0.3, 1e-12);
  const auto& second = json["features"][1];
  EXPECT_TRUE(second["geometry"].is_null());
  EXPECT_TRUE(second["properties"]["length_m"].is_null());
}

TEST(LeaksGeoJson, WithoutADatumNothingHasAPlaceOnTheEarth) {
  const auto json = nlohmann::json::parse(leaks_geojson(kFindings, std::nullopt));
  EXPECT_TRUE(json["features"][0]["geometry"].is_null());
  EXPECT_EQ(json["features"][0]["properties"]["map_x"], 12.5);
  EXPECT_EQ(nlohmann::json::parse(leaks_geojson({}, kDatum))["features"].size(), 0U);
}

TEST(LeaksKml, HasAPlacemarkEach) {
  const std::string kml = leaks_kml(kFindings, kDatum);
  EXPECT_THAT(kml, HasSubstr("<Placemark id=\"leak1\"><name>Leak 1: moderate</name>"));
  EXPECT_THAT(kml, HasSubstr("<Point><altitudeMode>absolute</altitudeMode><coordinates>-5.79"));
  EXPECT_THAT(kml, HasSubstr("<Placemark id=\"leak2\">"));
  EXPECT_EQ(kml.find("<Point>"), kml.rfind("<Point>"));
  EXPECT_THAT(kml, HasSubstr("<Data name=\"length_m\"><value></value></Data>"));
  EXPECT_THAT(kml, HasSubstr("</Document>\n</kml>\n"));
  EXPECT_THAT(leaks_kml(kFindings, std::nullopt), Not(HasSubstr("<Point>")));
}

TEST(LeaksCsv, HasAsManyFieldsInEachLine) {
  std::istringstream csv(leaks_csv(kFindings, kDatum));
  std::vector<std::string> lines;
  for (std::string line; std::getline(csv, line);) {
    lines.push_back(line);
  }
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_THAT(lines[0], ::testing::StartsWith("id,state,severity,probability,first_time"));
  for (const std::string& line : lines) {
    EXPECT_EQ(std::count(line.begin(), line.end(), ','),
              std::count(lines[0].begin(), lines[0].end(), ','));
  }
  EXPECT_THAT(lines[1], ::testing::StartsWith("1,raised,moderate,0.97,2013-10-09T06:27:40.000Z"));
  EXPECT_THAT(lines[2], ::testing::EndsWith(",,,"));
  EXPECT_THAT(leaks_csv({}, kDatum), HasSubstr("id,state"));
}

TEST(IsoTime, IsUtcToTheMillisecond) {
  EXPECT_EQ(iso_time(0), "1970-01-01T00:00:00.000Z");
  EXPECT_EQ(iso_time(1366143146.104), "2013-04-16T20:12:26.104Z");
  EXPECT_EQ(iso_time(-0.25), "1969-12-31T23:59:59.750Z");
  EXPECT_EQ(iso_time(0.9999), "1970-01-01T00:00:01.000Z");
  EXPECT_EQ(iso_time(NAN), "");
  EXPECT_EQ(iso_time(1e18), "");
}

}  // namespace
}  // namespace pipescout
