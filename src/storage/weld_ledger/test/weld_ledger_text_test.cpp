// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>

#include "pipescout/csv/testing/german_excel.hpp"
#include "pipescout/weld_ledger/weld_ledger_text.hpp"
#include "weld_runs.hpp"

namespace pipescout::odometry {
namespace {

WeldLedger make_ledger(MapFrame frame) {
  std::mt19937_64 engine(5);
  const test::Pipe pipe = test::laid_pipe(40, engine);
  const auto drive = [&] { return test::make_run(pipe, 0, pipe.size(), {}, engine).welds; };
  LedgerUpdate update = build_ledger({.name = "crawler, \"old\"", .date = "2025"}, drive());
  update = merge_run(update.ledger, {.name = "MFL", .date = ""}, drive());
  EXPECT_TRUE(update.accepted);
  if (frame == MapFrame::kNone) {
    return update.ledger;
  }
  const auto point = [](double a, double b, double c) {
    return SurveyedPoint{.position = {.coordinates = {a, b, c}, .standard_deviation = 0.1}};
  };
  // Ends before the pipe does: the last welds have no position.
  return lay_along(update.ledger,
                   frame == MapFrame::kGeodetic
                       ? CentreLine(frame, {point(59.0, 5.0, 10.0), point(59.003, 5.001, 12.0)})
                       : CentreLine(frame, {point(0.0, 0.0, 0.0), point(300.0, 30.0, 1.0)}));
}

WeldLedger from_text(std::string_view text, double default_standard_deviation = 0.05) {
  return ledger_from_csv(CsvTable(text, "l.csv"), default_standard_deviation);
}

bool same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) ||
         (std::isnan(a) && std::isnan(b));
}

TEST(LedgerText, CsvBringsBackEveryBit) {
  for (const MapFrame frame : {MapFrame::kNone, MapFrame::kGeodetic, MapFrame::kLocal}) {
    const WeldLedger ledger = make_ledger(frame);
    const std::string text = to_csv(ledger);
    const WeldLedger back = from_text(text);
    EXPECT_EQ(back.frame, ledger.frame);
    EXPECT_EQ(back.runs, ledger.runs);
    ASSERT_EQ(back.welds.size(), ledger.welds.size());
    for (std::size_t k = 0; k < back.welds.size(); ++k) {
      const LedgerWeld& one = back.welds[k];
      const LedgerWeld& other = ledger.welds[k];
      EXPECT_EQ(one.id, other.id);
      EXPECT_TRUE(same(one.chainage, other.chainage));
      EXPECT_TRUE(same(one.standard_deviation, other.standard_deviation));
      EXPECT_TRUE(same(one.joint_length, other.joint_length));
      EXPECT_TRUE(same(one.joint_standard_deviation, other.joint_standard_deviation));
      EXPECT_EQ(one.position, other.position);
      EXPECT_EQ(one.sightings, other.sightings);
    }
    EXPECT_EQ(to_csv(back), text);
  }
}

TEST(LedgerText, LedgersOfPoorRunsReadBack) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 engine(seed);
    test::Pipe pipe;
    for (const double weld : test::laid_pipe(60, engine)) {
      pipe.push_back(weld);
      if (pipe.size() % 9 == 4) {
        pipe.push_back(weld + 0.35);  // as short as a sighting is uncertain
      }
    }
    const test::RunFaults poor = {.missed = 0.06,
                                  .spurious = 0.06,
                                  .detection_sigma = 0.1,
                                  .slip_share = 0.1,
                                  .largest_slip = 3.0};
    const auto drive = [&] { return test::make_run(pipe, 0, pipe.size(), poor, engine).welds; };
    WeldLedger ledger = build_ledger({.name = "run 0"}, drive()).ledger;
    for (std::size_t run = 1; run < 6; ++run) {
      ledger = merge_run(ledger, {.name = "run " + std::to_string(run)}, drive()).ledger;
      const std::string text = to_csv(ledger);
      EXPECT_EQ(to_csv(from_text(text)), text) << "seed " << seed;
    }
  }
}

TEST(LedgerText, TallyNeedsOnlyIdsAndLengths) {
  const WeldLedger ledger = from_text("id,joint_length_m\r\nA,12.1\r\n\r\nB,11.9\r\nC,\r\n", 0.1);
  ASSERT_EQ(ledger.welds.size(), 3U);
  EXPECT_DOUBLE_EQ(ledger.welds[2].chainage, 24.0);
  EXPECT_DOUBLE_EQ(ledger.welds[1].standard_deviation, 0.1);
  EXPECT_EQ(ledger.runs[0].name, "tally");
  EXPECT_EQ(ledger.welds[1].sightings.size(), 1U);
  const WeldLedger by_chainage = from_text("id,chainage_m\nA,5\nB,17.5\n");
  EXPECT_DOUBLE_EQ(by_chainage.welds[0].joint_length, 12.5);
}

TEST(LedgerText, AGermanExcelsExportIsTheSameLedger) {
  const std::string text =
      "id,kind,chainage_m,chainage_sd_m,run Molch ä|2020 chainage_m,run Molch ä|2020 sd_m\n"
      "Naht-Süd 1,,0,0.01,100.25,0.02\n\"V;1\",valve,3.5,0.3,,\n24\" tee,weld,1012.125,0.01,1112.5,"
      "0.02\n";
  for (const auto as : pipescout::testing::kExcelExports) {
    EXPECT_EQ(to_csv(from_text(pipescout::testing::german_excel(text, as))),
              to_csv(from_text(text)));
  }
}

TEST(LedgerText, SpreadsheetsMarkAndInchesAreRead) {
  const WeldLedger ledger = from_text("\xEF\xBB\xBFid,chainage_m\n24\" tee,0\n\"a \"\"b\"\"\",5\n");
  ASSERT_EQ(ledger.welds.size(), 2U);
  EXPECT_EQ(ledger.welds[0].id, "24\" tee");
  EXPECT_EQ(ledger.welds[1].id, "a \"b\"");
}

struct BadText {
  const char* name;
  const char* text;
  const char* error;
};

class LedgerTextErrors : public ::testing::TestWithParam<BadText> {};

TEST_P(LedgerTextErrors, NameLineAndField) {
  try {
    (void)from_text(GetParam().text);
    ADD_FAILURE() << "accepted";
  } catch (const CsvError& error) {
    EXPECT_STREQ(error.what(), GetParam().error);
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, LedgerTextErrors,
    ::testing::Values(
        BadText{"Empty", "", "l.csv: is empty; a header line is needed"},
        BadText{"NoId", "joint_length_m,seen\n1,1\n",
                "l.csv:1: column 'id': the column is missing"},
        BadText{"NoLength", "id,seen\nA,1\n",
                "l.csv:1: column 'joint_length_m': the column is missing, and chainage_m too"},
        BadText{"Unknown", "id,lenght\nA,1\n",
                "l.csv:1: column 'lenght': is not a column of a ledger"},
        BadText{"Twice", "id,id\nA,1\n", "l.csv:1: column 'id': duplicate column"},
        BadText{"Short", "id,joint_length_m\nA\n", "l.csv:2: 1 cells in a table of 2 columns"},
        BadText{"Negative", "id,joint_length_m\nA,3\nB,-3\nC,\n",
                "l.csv:3: column 'joint_length_m': -3 is not above 0"},
        BadText{"Zero", "id,joint_length_m\nA,0\nB,\n",
                "l.csv:2: column 'joint_length_m': 0 is not above 0"},
        BadText{"Missing", "id,joint_length_m\nA,1\n\nB,\nC,\n",
                "l.csv:4: column 'joint_length_m': is missing"},
        BadText{"Nan", "id,joint_length_m\nA,nan\nB,\n",
                "l.csv:2: column 'joint_length_m': 'nan' is not a finite number"},
        BadText{"Infinite", "id,chainage_m\nA,inf\nB,3\n",
                "l.csv:2: column 'chainage_m': 'inf' is not a finite number"},
        BadText{"Word", "id,chainage_m\nA,1x\nB,3\n",
                "l.csv:2: column 'chainage_m': '1x' is not a finite number"},
        BadText{"AfterTheLast", "id,joint_length_m\nA,1\nB,2\n",
                "l.csv:3: column 'joint_length_m': the last weld has no joint after it"},
        BadText{"SameChainage", "id,chainage_m\nA,5\nB,5\n",
                "l.csv:3: column 'chainage_m': 5 is not above 5"},
        BadText{"SameId", "id,chainage_m\nA,5\nA,6\n", "l.csv:3: column 'id': 'A' is a duplicate"},
        BadText{"EmptyId", "id,chainage_m\n,5\nA,6\n", "l.csv:2: column 'id': is missing"},
        BadText{
            "Disagree", "id,chainage_m,joint_length_m\nA,0,12\nB,13,\n",
            "l.csv:2: column 'joint_length_m': 12 is not the distance to the next chainage, 13"},
        BadText{"SigmaZero", "id,chainage_m,chainage_sd_m\nA,0,0\nB,13,1\n",
                "l.csv:2: column 'chainage_sd_m': 0 is not above 0"},
        BadText{"HalfAMap", "id,chainage_m,latitude_deg\nA,0,1\n",
                "l.csv:1: column 'longitude_deg': the column is missing"},
        BadText{"TwoMaps", "id,chainage_m,latitude_deg,x_m\nA,0,1,1\n",
                "l.csv:1: column 'x_m': latitude_deg is given too: a ledger has one map"},
        BadText{"Latitude",
                "id,chainage_m,latitude_deg,longitude_deg,height_m,position_sd_m\nA,0,91,1,1,1\n",
                "l.csv:2: column 'latitude_deg': 91 is outside [-90, 90]"},
        BadText{"HalfAPosition", "id,chainage_m,x_m,y_m,z_m,position_sd_m\nA,0,1,,1,1\n",
                "l.csv:2: column 'y_m': is missing"},
        BadText{"HalfARun", "id,chainage_m,run a|b chainage_m\nA,0,1\n",
                "l.csv:1: column 'run a|b sd_m': the column is missing"},
        BadText{"BarInDate", "id,chainage_m,run a|b|c chainage_m,run a|b|c sd_m\nA,0,1,1\n",
                "l.csv:1: column 'run a|b|c chainage_m': the name or the date of a run holds '|' "
                "or a line "
                "break"},
        BadText{"RunTurns",
                "id,chainage_m,run a|b chainage_m,run a|b sd_m\nA,0,1,1\nB,5,6,1\nC,9,4,1\n",
                "l.csv:4: column 'run a|b chainage_m': 4 does not continue from 6"},
        BadText{"HalfASighting", "id,chainage_m,run a|b chainage_m,run a|b sd_m\nA,0,1,\nB,5,6,1\n",
                "l.csv:2: column 'run a|b sd_m': is missing"},
        BadText{"Quote", "id,chainage_m\n\"A,5\n",
                "l.csv:2: a quotation mark of this row is not closed"}),
    [](const auto& bad) { return std::string(bad.param.name); });

TEST(LedgerText, LengthsThatMayBeThousandsAreAskedAbout) {
  EXPECT_THROW((void)from_text("id;joint_length_m\nA;12,125\nB;9,250\nC;\n"), CsvError);
}

TEST(LedgerText, DefaultStandardDeviationIsChecked) {
  EXPECT_THROW((void)from_text("id,chainage_m\nA,5\n", 0.0), std::invalid_argument);
}

TEST(LedgerText, GeoJsonHasLongitudeFirst) {
  const WeldLedger ledger = from_text(
      "id,chainage_m,latitude_deg,longitude_deg,height_m,position_sd_m\n"
      "\"a\"\"b\",0,59.5,5.25,10,0.5\nB,12,59.75,5.5,11,0.5\nC,24,,,,\n");
  const std::string text = to_geojson(ledger);
  EXPECT_THAT(text, ::testing::StartsWith("{\"type\":\"FeatureCollection\",\"features\":["));
  EXPECT_THAT(text, ::testing::HasSubstr("{\"type\":\"LineString\",\"coordinates\":"
                                         "[[5.25,59.5,10],[5.5,59.75,11]]}"));
  EXPECT_THAT(text, ::testing::HasSubstr("{\"type\":\"Point\",\"coordinates\":[5.25,59.5,10]}"));
  EXPECT_THAT(text, ::testing::HasSubstr("\"id\":\"a\\\"b\""));
  EXPECT_THAT(text, ::testing::HasSubstr("\"geometry\":null,\"properties\":{\"id\":\"C\""));
  EXPECT_THAT(text, ::testing::HasSubstr("\"joint_length_m\":null"));
  EXPECT_THAT(text, ::testing::HasSubstr("\"runs\":[\"tally\"]"));
  EXPECT_THAT(to_geojson({}), ::testing::HasSubstr("\"features\":[\n\n]"));
}

TEST(LedgerText, GeoJsonCutsTheLineAtTheAntimeridian) {
  const WeldLedger ledger = from_text(
      "id,chainage_m,latitude_deg,longitude_deg,height_m,position_sd_m\n"
      "A,0,-16.5,179.75,4,0.5\nB,12,-16.5,-179.75,6,0.5\n");
  EXPECT_THAT(to_geojson(ledger),
              ::testing::HasSubstr("{\"type\":\"MultiLineString\",\"coordinates\":["
                                   "[[179.75,-16.5,4],[180,-16.5,5]],"
                                   "[[-180,-16.5,5],[-179.75,-16.5,6]]]}"));
}

TEST(LedgerText, GeoJsonKeepsLocalCoordinatesAsProperties) {
  const std::string text = to_geojson(make_ledger(MapFrame::kLocal));
  EXPECT_THAT(text, ::testing::HasSubstr("\"geometry\":null"));
  EXPECT_THAT(text, ::testing::HasSubstr("\"x_m\":"));
  EXPECT_THAT(text, ::testing::Not(::testing::HasSubstr("Point")));
}

TEST(LedgerText, VerdictsHaveNames) {
  EXPECT_STREQ(to_string(WeldVerdict::kConfirmed), "confirmed");
  EXPECT_STREQ(to_string(WeldVerdict::kSingle), "single");
  EXPECT_STREQ(to_string(WeldVerdict::kDoubtful), "doubtful");
  EXPECT_STREQ(to_string(static_cast<WeldVerdict>(9)), "unknown");
}

TEST(WeldLedgerText, LandmarksKeepTheirKindAndSightings) {
  const WeldLedger tally =
      from_text("id,kind,chainage_m\nA,,0\nV1,valve,3.5\nB,weld,12\nM1,marker,15\nC,weld,24\n");
  ASSERT_EQ(tally.welds.size(), 3U);
  EXPECT_EQ(tally.welds[1].joint_length, 12.0);
  ASSERT_EQ(tally.landmarks.size(), 2U);
  EXPECT_EQ(tally.landmarks[0].kind, odometry::LandmarkKind::kValve);
  EXPECT_EQ(tally.landmarks[1].chainage, 15.0);
  const std::string text = to_csv(tally);
  EXPECT_EQ(to_csv(from_text(text)), text);
  const auto error = [](const char* csv) -> std::string {
    try {
      (void)from_text(csv);
    } catch (const CsvError& refused) {
      return refused.what();
    }
    return "accepted";
  };
  EXPECT_EQ(error("id,kind,chainage_m\nA,weld,0\nX,pump,3\nB,weld,12\n"),
            "l.csv:3: column 'kind': 'pump' is none of weld, marker, valve, tee, bend");
  EXPECT_EQ(error("id,kind,chainage_m\nA,weld,0\nV,valve,\nB,weld,12\n"),
            "l.csv:3: column 'chainage_m': is missing");
  EXPECT_EQ(error("id,kind,chainage_m\nA,weld,0\nA,valve,1\nB,weld,12\n"),
            "l.csv:3: column 'id': 'A' is a duplicate");
  EXPECT_EQ(error("id,kind,joint_length_m\nA,weld,12\nV,valve,\nB,weld,\n"),
            "l.csv:1: column 'chainage_m': the column is missing, and landmarks need it");
}

TEST(WeldLedgerText, BendsKeepTheirAngle) {
  const std::string rows =
      "id,kind,angle_deg,chainage_m\nA,weld,,0\nB1,bend,12,3.5\nB2,bend,,5\nB,weld,,12\nC,,,24\n";
  const WeldLedger tally = from_text(rows);
  ASSERT_EQ(tally.landmarks.size(), 2U);
  EXPECT_NEAR(tally.landmarks[0].angle, 0.2094395, 1e-7);
  EXPECT_TRUE(std::isnan(tally.landmarks[1].angle));
  const std::string text = to_csv(tally);
  EXPECT_THAT(text, ::testing::HasSubstr("\nB1,bend,12,3.5,"));
  EXPECT_EQ(to_csv(from_text(text)), text);
  const auto error = [](const char* row) -> std::string {
    try {
      (void)from_text("id,kind,angle_deg,chainage_m\nA,weld,,0\n" + std::string(row) +
                      "\nB,weld,,12\n");
    } catch (const CsvError& refused) {
      return refused.what();
    }
    return "accepted";
  };
  EXPECT_EQ(error("V,valve,90,3"), "l.csv:3: column 'angle_deg': a valve has no angle");
  EXPECT_EQ(error("B1,bend,190,3"), "l.csv:3: column 'angle_deg': 190 is above 180");
  EXPECT_EQ(error("B1,bend,0,3"), "l.csv:3: column 'angle_deg': 0 is not above 0");
  EXPECT_EQ(error("B1,bend,steep,3"),
            "l.csv:3: column 'angle_deg': 'steep' is not a finite number");
}

}  // namespace
}  // namespace pipescout::odometry
