// SPDX-License-Identifier: Apache-2.0
#include "run_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "pipescout/csv/csv_file.hpp"
#include "pipescout/csv/csv_table.hpp"
#include "pipescout/csv/testing/german_excel.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"

namespace pipescout::ledger {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr const char* kMapping = R"(distance: log [ft]
unit: feet
kind: event
girth_weld: [Girth Weld, GWD]
clock: o'clock
relative_distance: to weld
)";

class RunFiles : public ::testing::Test {
 protected:
  std::string write(const std::string& text) const {
    std::ofstream(folder_.path() / "run.csv", std::ios::binary) << text;
    return (folder_.path() / "run.csv").string();
  }
  RunFile read(const std::string& text, const std::string& mapping = kMapping) const {
    return read_run(write(text), parse_column_mapping(mapping, "m.yaml"));
  }
  /// What is wrong, with "run.csv" for the whole path.
  template <typename Read>
  std::string error_of(Read read) const {
    try {
      (void)read();
    } catch (const CsvError& error) {
      const std::string text = error.what();
      return text.substr(text.find("run.csv"));
    }
    return "accepted";
  }
  std::string error(const std::string& text, const std::string& mapping = kMapping) const {
    return error_of([&] { return read(text, mapping); });
  }
  std::string survey_error(const std::string& text) const {
    return error_of([&] { return read_survey(write(text), {}); });
  }
  std::string ledger_error(const std::string& text) const {
    return error_of([&] { return read_ledger(write(text), {}); });
  }

  ::pipescout::testing::TemporaryFolder folder_;
};

const std::string kHeader = "event,log [ft],o'clock,to weld,joint\n";

TEST_F(RunFiles, WeldsAndFeaturesInMetres) {
  const auto run = read("\xEF\xBB\xBF" + kHeader +
                        "Valve,-10,,,\r\n"
                        "Girth Weld,0,,,10\r\n"
                        "\"metal \"\"loss\"\", deep\",10.5,09:30,-10,7\r\n"
                        "GWD,\" 40 \",,,20\r\n"
                        "\"bend\nleft\",41,,,\r\n");
  ASSERT_EQ(run.welds.size(), 2U);
  EXPECT_DOUBLE_EQ(run.welds[1].chainage, 40.0 * 0.3048);
  EXPECT_DOUBLE_EQ(run.welds[1].standard_deviation, 0.05);
  EXPECT_DOUBLE_EQ(run.length_noise, 0.01);
  EXPECT_FALSE(run.positions[0]);
  EXPECT_FALSE(run.ledger);
  ASSERT_EQ(run.features.size(), 3U);
  EXPECT_EQ(run.features[0].line, 2U);
  EXPECT_TRUE(std::isnan(run.features[0].from_weld));
  EXPECT_EQ(run.features[1].kind, "metal \"loss\", deep");
  EXPECT_EQ(run.features[1].clock, "09:30");
  EXPECT_DOUBLE_EQ(run.features[1].given_from_weld, 3.048);
  EXPECT_NEAR(run.features[1].from_weld, 10.5 * 0.3048, 1e-12);
  EXPECT_EQ(run.features[2].kind, "bend left");
  EXPECT_TRUE(std::isnan(run.features[2].given_from_weld));
}

TEST_F(RunFiles, PositionsAndDelimiter) {
  const auto run = read("k;d;lat;lon;h\nw;0;59;5;100\nw;5;;;\nw;12;59.1;5.1;110\n",
                        "{delimiter: ;, distance: d, unit: metres, kind: k, girth_weld: w, "
                        "latitude: lat, longitude: lon, height: h, height_unit: feet, "
                        "position_standard_deviation: 3}");
  ASSERT_EQ(run.positions.size(), 3U);
  EXPECT_FALSE(run.positions[1]);
  EXPECT_DOUBLE_EQ(run.positions[2]->coordinates[2], 110 * 0.3048);
  EXPECT_DOUBLE_EQ(run.positions[2]->standard_deviation, 3.0);
}

TEST_F(RunFiles, ErrorsNameFileLineAndColumn) {
  const auto rows = [&](const std::string& text) { return error(kHeader + text); };
  EXPECT_EQ(rows("GWD,5,,,\nGWD,,,,\n"), "run.csv:3: column 'log [ft]': is missing");
  EXPECT_EQ(rows("GWD,5,,,\nGWD,5,,,\n"),
            "run.csv:3: column 'log [ft]': 5 is not above 5, the girth weld before, line 2");
  EXPECT_EQ(rows("GWD,5,,,\nTap,1,,,\n\nGWD,4,,,\n"),
            "run.csv:5: column 'log [ft]': 4 is not above 5, the girth weld before, line 2");
  EXPECT_EQ(rows("GWD,\"1,234\",,,\n"),
            "run.csv:2: column 'log [ft]': '1,234' may be 1.234 or 1234; set 'decimal_mark' in "
            "m.yaml");
  EXPECT_EQ(rows("Tap,nan,,,\n"), "run.csv:2: column 'log [ft]': 'nan' is not a finite number");
  EXPECT_EQ(rows("GWD,1e12,,,\n"), "run.csv:2: column 'log [ft]': '1e12' is out of range");
  EXPECT_EQ(rows("GWD,5,,,\nTap,6,,x,\n"),
            "run.csv:3: column 'to weld': 'x' is not a finite number");
  EXPECT_EQ(rows("GWD,5,,\n"), "run.csv:2: 4 cells in a table of 5 columns");
  EXPECT_EQ(rows("GWD,5,,,\n\"GWD,6,,,\nTap\n"),
            "run.csv:3: a quotation mark of this row is not closed");
  EXPECT_EQ(rows(""), "run.csv: has a header but no rows");
  EXPECT_EQ(error(""), "run.csv: is empty; a header line is needed");
  EXPECT_EQ(error("\xFF\xFE"), "run.csv: is empty; a header line is needed");
  EXPECT_EQ(error(kHeader + std::string("a\0", 2)),
            "run.csv:2: is not text: it contains a zero byte; UTF-16 needs its byte order mark");
  EXPECT_EQ(error("event,log [ft],event,o'clock,to weld\nGWD,1,,,\n"),
            "run.csv:1: two columns are named 'event'");
}

TEST_F(RunFiles, Windows1252IsConvertedAndSaid) {
  const auto run = read(kHeader +
                        "GWD,5,,,\nAu\xDF"
                        "en,6,,,\n");
  EXPECT_EQ(run.features[0].kind, "Außen");
  ASSERT_EQ(run.notes.size(), 1U);
  EXPECT_THAT(run.notes[0],
              EndsWith("run.csv:3: byte 0xdf is not UTF-8; the file is read as Windows-1252"));
  EXPECT_EQ(read_ledger(write("id,joint_length_m\nNaht-S\xFC"
                              "d,12\nB,\n"),
                        {})
                .ledger.welds[0]
                .id,
            "Naht-Süd");
}

TEST_F(RunFiles, AGermanExcelsExportIsTheSameRun) {
  const std::string text = kHeader +
                           "GWD,0.25,,,10\n\"Außenkorrosion, tief; 24\"\"\",10.5,09:30,-10.125,7\n"
                           "GWD,1040.125,,,20\n";
  const auto original = read(text);
  for (const auto as : ::pipescout::testing::kExcelExports) {
    const auto run = read(::pipescout::testing::german_excel(text, as));
    ASSERT_EQ(run.welds.size(), 2U);
    EXPECT_EQ(run.welds[1].chainage, original.welds[1].chainage);
    ASSERT_EQ(run.features.size(), 1U);
    EXPECT_EQ(run.features[0].kind, original.features[0].kind);
    EXPECT_EQ(run.features[0].clock, original.features[0].clock);
    EXPECT_EQ(run.features[0].given_from_weld, original.features[0].given_from_weld);
  }
}

TEST_F(RunFiles, ARowOfUnitsMustAgreeWithTheMapping) {
  const std::string mapping = "distance: d\nkind: k\ngirth_weld: w\nunit: ";
  EXPECT_DOUBLE_EQ(read("d,k\n[mm],\n4000,w\n16120,w\n", mapping + "mm").welds[1].chainage, 16.12);
  EXPECT_EQ(error("d,k\n[mm],\n4000,w\n16120,w\n", mapping + "m"),
            "run.csv:1: column 'd' is in mm, and the unit in m.yaml is another one");
}

TEST_F(RunFiles, HeadersOfSpreadsheetsAreMatchedWithWhiteSpaceFolded) {
  const std::string mapping =
      "distance: log dist. [mm]\nunit: mm\nkind: event  type\n"
      "girth_weld: Girth Weld\n";
  const auto run = read(
      "\"event\ntype\",\"log\r\n dist.\u00A0[mm]\"\n"
      "\"Girth\nWeld\",4000\nGirth  Weld,16120\n",
      mapping);
  ASSERT_EQ(run.welds.size(), 2U);
  EXPECT_DOUBLE_EQ(run.welds[1].chainage, 16.12);
}

TEST_F(RunFiles, ARunThatNoPipeHasIsAskedAbout) {
  const std::string text = "d,k\n4000,w\n130110000,w\n";
  const std::string mapping = "distance: d\nkind: k\ngirth_weld: w\nunit: ";
  EXPECT_EQ(error(text, mapping + "metres"),
            "run.csv: from the first girth weld to the last are 130106 km, and no run is longer "
            "than 5000 km: is the unit of column 'd' right, which m.yaml has?");
  EXPECT_DOUBLE_EQ(read(text, mapping + "mm").welds[1].chainage, 130110);
  EXPECT_DOUBLE_EQ(read(text, mapping + "millimetres").welds[0].chainage, 4);
  EXPECT_DOUBLE_EQ(read("d,k\n4000,w\n4040,w\n", mapping + "ft").welds[0].chainage, 4000 * 0.3048);
}

TEST_F(RunFiles, JointsThatNoPipeHasAreAskedAbout) {
  std::string text = "d,k\n";
  for (int k = 0; k <= 12; ++k) {
    text += std::to_string(11720 * k) + ",w\n";
  }
  const std::string mapping = "distance: d\nkind: k\ngirth_weld: w\nunit: ";
  EXPECT_EQ(error(text, mapping + "metres"),
            "run.csv: from one girth weld to the next are 11720 m (the middle one of 12), and no "
            "joint is longer than 200 m: is the unit of column 'd' right, which m.yaml has?");
  EXPECT_DOUBLE_EQ(read(text, mapping + "mm").welds[1].chainage, 11.72);
}

TEST_F(RunFiles, OtherColumnsAreAnsweredWithWhatThereIs) {
  EXPECT_EQ(error("event,Log [ft],o'clock,to weld\nGWD,1,,\n"),
            "run.csv:1: no column 'log [ft]', which m.yaml:1:11 wants as the distance; did you "
            "mean 'Log [ft]'? The file has 'event', 'Log [ft]', 'o'clock', 'to weld'. The mapping "
            "wants 'log [ft]', 'event', 'o'clock', 'to weld'");
  EXPECT_THAT(error("event;log [ft]\nGWD;1\n"), StartsWith("run.csv:1: no column 'o'clock'"));
  EXPECT_THAT(error(kHeader + "girth weld,1,,,\nTap,2,,,\nTap,3,,,\n"),
              AllOf(StartsWith("run.csv: no girth weld: column 'event' never says 'Girth Weld', "
                               "'GWD' (girth_weld in m.yaml)"),
                    EndsWith("It says 'Tap' (2), 'girth weld' (1)")));
}

TEST_F(RunFiles, LedgersAndTalliesNeedNoMapping) {
  const auto run = read_run(write("id,joint_length_m\nA,12\nB,11\nC,\n"), CsvFormat{});
  ASSERT_EQ(run.welds.size(), 3U);
  EXPECT_DOUBLE_EQ(run.welds[2].chainage, 23.0);
  EXPECT_EQ(run.ledger->welds[1].id, "B");
  EXPECT_TRUE(run.features.empty());
  EXPECT_EQ(ledger_error("event,log\nGWD,1\n"),
            "run.csv:1: column 'event': is not a column of a ledger (a list with other columns "
            "needs --columns)");
  EXPECT_EQ(ledger_error("id,joint_length_m\nA,12\nB,-1\nC,\n"),
            "run.csv:3: column 'joint_length_m': -1 is not above 0");
  EXPECT_EQ(ledger_error("id,joint_length_m\nA\n"), "run.csv:2: 1 cells in a table of 2 columns");
}

TEST_F(RunFiles, SurveysAreReadAndChecked) {
  const auto line =
      read_survey(write("latitude_deg,longitude_deg,height_m,chainage_m,remark\n59,5,0,,a\n"
                        "59.1,5,0,100,\n"),
                  {})
          .line;
  EXPECT_EQ(line.frame(), odometry::MapFrame::kGeodetic);
  EXPECT_EQ(read_survey(write("x_m,y_m,z_m\n0,0,0\n3,4,0\n"), {}).line.length(), 5.0);
  const std::string header = "latitude_deg,longitude_deg,height_m,position_sd_m,chainage_m\n";
  const auto rows = [&](const std::string& text) { return survey_error(header + text); };
  EXPECT_EQ(rows("59,5,0,1,\n91,5,0,1,\n"),
            "run.csv:3: column 'latitude_deg': 91 is outside [-90, 90] degrees");
  EXPECT_EQ(rows("59,5,0,1,\n59,5,0,1,\n"),
            "run.csv:3: column 'latitude_deg': the point coincides with the previous one");
  EXPECT_EQ(rows("59,5,0,-1,\n"), "run.csv:2: column 'position_sd_m': -1 is below 0");
  EXPECT_EQ(rows("59,5,0,1,7\n59,6,0,1,\n59,7,0,1,7\n"),
            "run.csv:4: column 'chainage_m': 7 is not above 7");
  EXPECT_EQ(rows("59,,0,1,7\n"), "run.csv:2: column 'longitude_deg': is missing");
  EXPECT_EQ(rows("59,5,0,1,7\n"), "run.csv: a survey needs at least 2 points");
  EXPECT_THAT(survey_error("lat,lon\n1,2\n"),
              AllOf(StartsWith("run.csv:1: a survey has columns latitude_deg"),
                    EndsWith("the file has 'lat', 'lon'")));
  EXPECT_THAT(survey_error("x_m,y_m\n1,2\n"), StartsWith("run.csv:1: no column 'z_m'"));
}

TEST_F(RunFiles, UnreadableAndHugeFilesAreErrors) {
  const auto path = (folder_.path() / "run.csv").string();
  EXPECT_EQ(error_of([&] { return read_ledger(path, {}); }), "run.csv: No such file or directory");
  (void)write("id\n");
  std::filesystem::resize_file(path, kMaxCsvFileSize + 1);
  EXPECT_THAT(error_of([&] { return read_ledger(path, {}); }),
              StartsWith("run.csv: is larger than "));
  std::filesystem::remove(path);
  std::filesystem::create_directory(path);
  EXPECT_EQ(error_of([&] { return read_ledger(path, {}); }), "run.csv: is not a regular file");
}

}  // namespace
}  // namespace pipescout::ledger
