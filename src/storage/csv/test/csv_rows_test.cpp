// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_rows.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace pipescout {
namespace {

TEST(CsvRows, DelimiterAndLinesAreTheCallers) {
  const CsvRows rows = read_csv_rows("a;1,5\r\n\n\"b\nc\";2\nd\n", ';');
  ASSERT_EQ(rows.rows.size(), 3U);
  EXPECT_THAT(rows.rows[0].cells, testing::ElementsAre("a", "1,5"));
  EXPECT_THAT(rows.rows[1].cells, testing::ElementsAre("b\nc", "2"));
  EXPECT_EQ(rows.rows[1].line, 3U);
  EXPECT_EQ(rows.rows[2].line, 5U);
  EXPECT_FALSE(read_csv_rows("a,\"b").closed);
}

TEST(CsvRows, CellsAreQuotedWhereTheyMustBe) {
  EXPECT_EQ(csv_cell("24\" tee"), "\"24\"\" tee\"");
  EXPECT_EQ(csv_cell("plain text"), "plain text");
  EXPECT_EQ(csv_cell("a,b"), "\"a,b\"");
}

TEST(CsvRows, MissingNumbersAreEmptyCells) {
  EXPECT_EQ(format_optional_csv_number(std::numeric_limits<double>::quiet_NaN()), "");
  EXPECT_EQ(format_optional_csv_number(0.1), "0.1");
}

}  // namespace
}  // namespace pipescout
