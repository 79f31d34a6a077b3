// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometer_readings/readings_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "pipescout/csv/testing/german_excel.hpp"

namespace pipescout {
namespace {

using std::chrono::nanoseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string error_of(std::string_view text, const ReadingsCsvSelection& selection = {}) {
  try {
    (void)parse_readings_csv(text, "file.csv", selection);
  } catch (const CsvError& error) {
    return error.what();
  }
  return "no error";
}

TEST(ReadingsCsv, ReadsDistancesInTheFilesOrder) {
  const auto recording =
      parse_readings_csv("reading,left,right\n1,5.45,5.34\n2,5.32,5.27\n", "file.csv");
  EXPECT_THAT(recording.odometers, ElementsAre("left", "right"));
  EXPECT_TRUE(recording.stamps.empty());
  EXPECT_TRUE(recording.standard_deviations.empty());
  ASSERT_EQ(recording.size(), 2U);
  EXPECT_THAT(recording.row(1).distance, ElementsAre(5.32, 5.27));
  EXPECT_THAT(recording.row(1).valid, ElementsAre(true, true));
  EXPECT_TRUE(recording.row(1).standard_deviation.empty());
}

TEST(ReadingsCsv, IgnoredColumnsNeedNotExist) {
  const auto recording = parse_readings_csv(
      "left,right,paper\n1,2,x\n", "", {.odometers = {}, .ignored_columns = {"paper", "other"}});
  EXPECT_THAT(recording.odometers, ElementsAre("left", "right"));
}

TEST(ReadingsCsv, SelectsAndOrdersOdometers) {
  const auto recording =
      parse_readings_csv("note,left,middle,right\nx,1,2,3\n", "",
                         {.odometers = {"right", "left"}, .ignored_columns = {}});
  EXPECT_THAT(recording.odometers, ElementsAre("right", "left"));
  EXPECT_THAT(recording.row(0).distance, ElementsAre(3.0, 1.0));
}

TEST(ReadingsCsv, ReadsStampsSigmasAndValidity) {
  const auto recording = parse_readings_csv(
      "stamp,a,b,a.standard_deviation,b.standard_deviation,b.valid\n"
      "1700000000.123456789,1,2,0.1,-0.2,0\n",
      "");
  ASSERT_EQ(recording.stamps.size(), 1U);
  EXPECT_EQ(recording.row(0).stamp, nanoseconds(1'700'000'000'123'456'789));
  EXPECT_THAT(recording.row(0).standard_deviation, ElementsAre(0.1, -0.2));
  EXPECT_THAT(recording.row(0).valid, ElementsAre(true, false));
}

TEST(ReadingsCsv, ValuesThatAreNoNumbersAreData) {
  const auto recording = parse_readings_csv("a,b,c\nnan,-inf,5\n", "");
  EXPECT_TRUE(std::isnan(recording.row(0).distance[0]));
  EXPECT_EQ(recording.row(0).distance[1], -std::numeric_limits<double>::infinity());
  EXPECT_THAT(recording.row(0).valid, ElementsAre(true, true, true));
}

TEST(ReadingsCsv, ErrorsNameFileAndLine) {
  EXPECT_EQ(error_of("a,b\n1,2\n1,x\n"), "file.csv:3: column 'b': 'x' is not a number");
  EXPECT_EQ(error_of("a,b\n1,\n"), "file.csv:2: column 'b': '' is not a number");
  EXPECT_EQ(error_of("a,a.valid\n1,2\n"), "file.csv:2: column 'a.valid': '2' is not 0 or 1");
  EXPECT_EQ(
      error_of("stamp,a\n-1,2\n"),
      "file.csv:2: column 'stamp': '-1' is not a time in seconds from 0 to 2^31 or one such as "
      "2026-11-29T07:36:05.25Z");
  EXPECT_EQ(
      error_of("stamp,a\nnan,2\n"),
      "file.csv:2: column 'stamp': 'nan' is not a time in seconds from 0 to 2^31 or one such as "
      "2026-11-29T07:36:05.25Z");
  EXPECT_EQ(error_of("stamp,a\n2,1\n1,1\n"),
            "file.csv:3: column 'stamp': '1' is not later than the previous stamp, 2.000000000");
  EXPECT_EQ(error_of("stamp,a\n2,1\n2.0,1\n"),
            "file.csv:3: column 'stamp': '2.0' is not later than the previous stamp, 2.000000000");
  EXPECT_EQ(error_of("reading,a\n1.5,1\n"),
            "file.csv:2: column 'reading': '1.5' is not a whole number");
  EXPECT_EQ(error_of("reading,a\n2,1\n2,1\n"),
            "file.csv:3: column 'reading': '2' is not above the previous number, 2");
  EXPECT_EQ(error_of("reading,stamp\n1,1\n"),
            "file.csv:1: no odometer column; there are 'reading', 'stamp'");
  EXPECT_EQ(error_of("a,b.valid\n1,1\n"),
            "file.csv:1: column 'b.valid' belongs to no odometer column");
  EXPECT_EQ(error_of("a,b,a.standard_deviation\n1,2,0.1\n"),
            "file.csv:1: columns '*.standard_deviation' are there for some odometers but not for "
            "all");
  EXPECT_EQ(error_of("a,b\n1,2\n", {.odometers = {"c"}, .ignored_columns = {}}),
            "file.csv:1: no column 'c'; there are 'a', 'b'");
  EXPECT_EQ(error_of("a,b\n1,2\n", {.odometers = {"a", "a"}, .ignored_columns = {}}),
            "file.csv: an odometer is selected twice: 'a', 'a'");
}

TEST(ReadingsCsv, TakesNoMoreMemoryThanItsNumbers) {
  // The text that makes most numbers of a byte.
  constexpr std::size_t kRows = 100'000;
  std::string text = "a,b\n";
  for (std::size_t i = 0; i < kRows; ++i) {
    text += "1,2\n";
  }
  text += std::string(kRows, '\n');
  const auto recording = parse_readings_csv(text, "");
  EXPECT_EQ(recording.size(), kRows);
  EXPECT_EQ(recording.distances.capacity(), 2 * kRows);
  EXPECT_EQ(recording.standard_deviations.capacity(), 0U);
  EXPECT_EQ(recording.stamps.capacity(), 0U);
}

TEST(ReadingsCsv, ColumnsThatCannotBeToldApartAreRefused) {
  EXPECT_EQ(error_of("a,,c\n1,2,3\n"), "file.csv:1: column 2 has no name");
  EXPECT_EQ(error_of("a,b,a\n1,2,3\n"), "file.csv:1: two columns are named 'a'");
  EXPECT_THAT(parse_readings_csv("a,b,,\n1,2,,\n", "").odometers, ElementsAre("a", "b"))
      << "columns that a spreadsheet left behind";
}

TEST(ReadingsCsv, TablesOfSpreadsheets) {
  const auto recording = parse_readings_csv(
      "sep=;\r\nstamp;left;right\r\ns;mm;mm\r\n12,5;5450;5340,5\r\n13,5;5500;5390\r\n", "file.csv");
  EXPECT_EQ(recording.row(0).stamp, nanoseconds(12'500'000'000));
  EXPECT_DOUBLE_EQ(recording.row(0).distance[0], 5.45);
  EXPECT_DOUBLE_EQ(recording.row(0).distance[1], 5.3405);
  EXPECT_THAT(recording.notes, ElementsAre("file.csv:3: is taken for a row of units",
                                           "file.csv: numbers have a decimal comma",
                                           "file.csv: column 'left' is in mm, converted to m",
                                           "file.csv: column 'right' is in mm, converted to m"));
}

TEST(ReadingsCsv, UnitsInNames) {
  const auto recording =
      parse_readings_csv("t,left [mm],left [mm].standard_deviation\n0,5450,60\n", "file.csv",
                         {.odometers = {"left [mm]"}, .ignored_columns = {}});
  EXPECT_THAT(recording.odometers, ElementsAre("left"));
  EXPECT_DOUBLE_EQ(recording.row(0).distance[0], 5.45);
  EXPECT_DOUBLE_EQ(recording.row(0).standard_deviation[0], 0.06);
  EXPECT_THAT(parse_readings_csv("left (front)\n1\n", "").odometers, ElementsAre("left (front)"));
  EXPECT_EQ(error_of("left [V]\n1\n"),
            "file.csv:1: column 'left [V]' is in 'V', which is no length: metres (m), millimetres "
            "(mm), centimetres (cm), kilometres (km), feet (ft)");
  EXPECT_THAT(error_of("a [mm],a [m]\n1,2\n"), HasSubstr("without its unit"));
}

TEST(ReadingsCsv, StampsInOtherUnits) {
  const auto recording =
      parse_readings_csv("stamp,a\n1700000000015000064,1\n1700000000115000064,2\n", "file.csv");
  EXPECT_EQ(recording.row(0).stamp, nanoseconds(1'700'000'000'015'000'064));
  EXPECT_THAT(recording.notes,
              ElementsAre("file.csv: column 'stamp': times are in ns, by their size"));
  EXPECT_EQ(parse_readings_csv("stamp,a\n250,1\n", "",
                               {.odometers = {},
                                .ignored_columns = {},
                                .format = {.time_unit = TimeUnit::kMilliseconds}})
                .row(0)
                .stamp,
            nanoseconds(250'000'000));
  EXPECT_THAT(error_of("stamp,a\n2024-1-5 3:7:2,1\n"), HasSubstr("2026-11-29T07:36:05.25Z"));
}

TEST(ReadingsCsv, AGermanExcelsExportIsTheSameRecording) {
  const std::string text =
      "stamp,reading,links,Räder,links.standard_deviation,Räder.standard_deviation,Räder.valid\n"
      "1700000000.25,1,5.45,5.34,0.06,0.055,1\n1700000000.5,2,nan,1005.44,0.06,0.055,0\n";
  const auto original = parse_readings_csv(text, "");
  for (const auto as : testing::kExcelExports) {
    const auto saved = parse_readings_csv(testing::german_excel(text, as), "");
    EXPECT_EQ(saved.odometers, original.odometers);
    EXPECT_EQ(saved.stamps, original.stamps);
    EXPECT_EQ(format_readings_row(1, saved.row(1)), format_readings_row(1, original.row(1)));
    EXPECT_EQ(saved.distances[0], original.distances[0]);
    EXPECT_EQ(saved.standard_deviations, original.standard_deviations);
  }
}

TEST(ReadingsCsv, AnyTextIsARecordingOrACsvError) {
  rc::check([] {
    const auto tokens = *rc::gen::container<std::vector<std::string>>(rc::gen::elementOf(
        std::vector<std::string>{"a", "b", "stamp", "reading", ".valid", ".standard_deviation", ",",
                                 ",", "\n", "\n", "1", "2", "3.5", "nan", "-", "\r\n", " "}));
    std::string text;
    for (const auto& token : tokens) {
      text += token;
    }
    try {
      const auto recording = parse_readings_csv(text, "fuzz");
      const std::size_t odometers = recording.odometers.size();
      RC_ASSERT(odometers != 0U);
      RC_ASSERT(recording.size() != 0U);
      RC_ASSERT(recording.distances.size() == recording.size() * odometers);
      RC_ASSERT(recording.valid.size() == recording.distances.size());
      RC_ASSERT(recording.standard_deviations.empty() ||
                recording.standard_deviations.size() == recording.distances.size());
      RC_ASSERT(recording.stamps.empty() || recording.stamps.size() == recording.size());
    } catch (const CsvError& error) {
      RC_ASSERT(std::string(error.what()).starts_with("fuzz"));
    }
  });
}

/// Doubles of every kind; NaN has one spelling only, so it is left to its own test.
rc::Gen<double> any_number() {
  return rc::gen::oneOf(
      rc::gen::arbitrary<double>(),
      rc::gen::element(0.0, -0.0, 1e-308, 1e308, std::numeric_limits<double>::infinity(),
                       -std::numeric_limits<double>::infinity()));
}

TEST(ReadingsCsv, WrittenAndReadIsTheSame) {
  rc::check([] {
    const auto names = *rc::gen::suchThat(
        rc::gen::arbitrary<std::vector<std::string>>(),
        [](const std::vector<std::string>& some) { return !some.empty() && some.size() <= 16; });
    const auto columns = odometer_column_names(names);
    RC_ASSERT(columns.size() == names.size());
    const bool with_sigmas = *rc::gen::arbitrary<bool>();
    std::string text = format_readings_header(columns, with_sigmas) + "\n";
    std::vector<ReadingsRow> rows;
    nanoseconds stamp{};
    const int count = *rc::gen::inRange(1, 5);
    for (int i = 0; i < count; ++i) {
      stamp += nanoseconds(*rc::gen::inRange<std::int64_t>(1, 400'000'000'000'000'000));
      ReadingsRow row{.stamp = stamp, .distance = {}, .standard_deviation = {}, .valid = {}};
      row.distance = *rc::gen::container<std::vector<double>>(names.size(), any_number());
      if (with_sigmas) {
        row.standard_deviation =
            *rc::gen::container<std::vector<double>>(names.size(), any_number());
      }
      row.valid = *rc::gen::container<std::vector<bool>>(names.size(), rc::gen::arbitrary<bool>());
      text += format_readings_row(static_cast<std::uint64_t>(i) + 1, row) + "\n";
      rows.push_back(row);
    }
    const auto read = parse_readings_csv(text, "written");
    RC_ASSERT(read.odometers == columns);
    RC_ASSERT(read.size() == rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const ReadingsRow row = read.row(i);
      RC_ASSERT(row.stamp == rows[i].stamp);
      RC_ASSERT(row.distance == rows[i].distance);
      RC_ASSERT(row.standard_deviation == rows[i].standard_deviation);
      RC_ASSERT(row.valid == rows[i].valid);
    }
  });
}

TEST(ReadingsCsv, ColumnNamesAreFitForTheFile) {
  EXPECT_THAT(odometer_column_names(
                  {"left", "a,b", "", "stamp", "left", " x ", "x.valid", "y [mm]", "z\xFF"}),
              ElementsAre("left", "a_b", "odometer_3", "odometer_4", "odometer_5", "_x_", "x_valid",
                          "y _mm_", "z_"));
}

}  // namespace
}  // namespace pipescout
