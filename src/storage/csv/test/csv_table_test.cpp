// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <bit>
#include <cmath>
#include <limits>
#include <string>

namespace pipescout {
namespace {

using ::testing::ElementsAre;

std::string error_of(std::string_view text) {
  try {
    (void)parse_csv(text, "file.csv");
  } catch (const CsvError& error) {
    return error.what();
  }
  return "no error";
}

TEST(CsvTable, ReadsHeaderAndRows) {
  const CsvTable table = parse_csv("a,b\n1,2\n3, four \n", "file.csv");
  EXPECT_EQ(table.path, "file.csv");
  EXPECT_THAT(table.columns, ElementsAre("a", "b"));
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_EQ(table.rows[1].line, 3U);
  EXPECT_THAT(table.rows[1].cells, ElementsAre("3", "four"));
  EXPECT_EQ(table.find_column("b"), 1U);
  EXPECT_EQ(table.find_column("c"), std::nullopt);
}

TEST(CsvTable, TakesWhatSpreadsheetsWrite) {
  const CsvTable table = parse_csv(
      "\xEF\xBB\xBF"
      "a,b\r\n1,2\r\n\r\n",
      "file.csv");
  EXPECT_THAT(table.columns, ElementsAre("a", "b"));
  ASSERT_EQ(table.rows.size(), 1U);
  EXPECT_THAT(table.rows[0].cells, ElementsAre("1", "2"));
}

TEST(CsvTable, LastLineNeedsNoLineEnd) {
  EXPECT_EQ(parse_csv("a\n1\n2", "").rows.size(), 2U);
}

TEST(CsvTable, EmptyCellsAreCells) {
  EXPECT_THAT(parse_csv("a,b,c\n,,\n", "").rows[0].cells, ElementsAre("", "", ""));
}

TEST(CsvTable, ErrorsNameFileAndLine) {
  EXPECT_EQ(error_of(""), "file.csv: is empty; a header line is needed");
  EXPECT_EQ(error_of("\n\n"), "file.csv: is empty; a header line is needed");
  EXPECT_EQ(error_of("a,b\n"), "file.csv: has a header but no rows");
  EXPECT_EQ(error_of("a,b\n1,2\n1\n"), "file.csv:3: 1 cells in a table of 2 columns");
  EXPECT_EQ(error_of("a,b\n1,2,3\n"), "file.csv:2: 3 cells in a table of 2 columns");
  EXPECT_EQ(error_of("a,b\n1,2\n\n3,4\n"), "file.csv:3: empty line");
  EXPECT_EQ(error_of("a,,c\n1,2,3\n"), "file.csv:1: column 2 has no name");
  EXPECT_EQ(error_of("a,b,a\n1,2,3\n"), "file.csv:1: two columns are named 'a'");
  EXPECT_EQ(error_of("a;b\n1;2\n"), "file.csv:1: columns must be separated by commas");
  EXPECT_EQ(error_of("a,b\n1,\"2\"\n"), "file.csv:2: quotes are not supported");
  EXPECT_EQ(error_of("a,b\n1,2\r3,4\n"), "file.csv:2: control character 13");
  EXPECT_EQ(error_of(std::string_view("a,b\n1,\0002\n", 9)), "file.csv:2: control character 0");
  EXPECT_EQ(error_of("\xFF\xFE"
                     "a"),
            "file.csv: is UTF-16; save it as UTF-8");
}

TEST(CsvTable, HasALimitOfColumns) {
  std::string header = "c1";
  for (std::size_t i = 2; i <= kMaxCsvColumns; ++i) {
    header += ",c" + std::to_string(i);
  }
  EXPECT_EQ(error_of(header), "file.csv: has a header but no rows");
  EXPECT_EQ(error_of(header + ",more"), "file.csv:1: 1025 columns; there may be 1024");
  EXPECT_EQ(error_of("a,b\n" + std::string(5000, ',')),
            "file.csv:2: 5001 cells in a table of 2 columns");
}

TEST(CsvReader, GoesFromRowToRowWithoutACopy) {
  const std::string text = "a,b\n1, 2\n3,4\n\n";
  CsvReader reader(text, "file.csv");
  EXPECT_THAT(reader.columns(), ElementsAre("a", "b"));
  EXPECT_EQ(reader.maximum_rows_left(), 2U);
  ASSERT_TRUE(reader.next());
  EXPECT_EQ(reader.line(), 2U);
  EXPECT_THAT(reader.cells(), ElementsAre("1", "2"));
  EXPECT_EQ(reader.cells()[0].data(), text.data() + 4);
  ASSERT_TRUE(reader.next());
  EXPECT_EQ(reader.maximum_rows_left(), 0U);
  try {
    reader.refuse(1, "a colour");
    FAIL() << "not refused";
  } catch (const CsvError& error) {
    EXPECT_STREQ(error.what(), "file.csv:3: column 'b': '4' is not a colour");
  }
  EXPECT_FALSE(reader.next());
}

TEST(CsvTable, AnyTextIsATableOrACsvError) {
  rc::check([] {
    // Few characters, so that tables come up too.
    const auto text = *rc::gen::container<std::string>(
        rc::gen::elementOf(std::string("ab1,,\n\n\r \t\"\0\xEF\xBB\xBF\xFF;", 17)));
    try {
      const CsvTable table = parse_csv(text, "fuzz");
      RC_ASSERT(!table.columns.empty());
      RC_ASSERT(!table.rows.empty());
      for (const auto& row : table.rows) {
        RC_ASSERT(row.cells.size() == table.columns.size());
      }
    } catch (const CsvError& error) {
      RC_ASSERT(std::string(error.what()).starts_with("fuzz"));
    }
  });
}

TEST(CsvNumber, WholeCellsOnly) {
  EXPECT_EQ(parse_csv_number("5.45"), 5.45);
  EXPECT_EQ(parse_csv_number("-1e-3"), -1e-3);
  EXPECT_EQ(parse_csv_number("1E3"), 1e3);
  EXPECT_EQ(parse_csv_number("INF"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(parse_csv_number("-inf"), -std::numeric_limits<double>::infinity());
  ASSERT_TRUE(parse_csv_number("NaN").has_value());
  EXPECT_TRUE(std::isnan(*parse_csv_number("NaN")));
  for (const char* text : {"", " ", "5,45", "5.4x", "0x10", "nan(1)", "infinity", "-nan", "1e999",
                           "1e", "--1", "5.4 5", "twelve"}) {
    EXPECT_EQ(parse_csv_number(text), std::nullopt) << text;
  }
}

TEST(CsvNumber, FormattedAndReadIsTheSame) {
  rc::check([](std::uint64_t bits) {
    const auto value = std::bit_cast<double>(bits);
    const auto read = parse_csv_number(format_csv_number(value));
    RC_ASSERT(read.has_value());
    const bool same =
        std::isnan(value) ? std::isnan(*read) : std::bit_cast<std::uint64_t>(*read) == bits;
    RC_ASSERT(same);
  });
}

}  // namespace
}  // namespace pipescout
