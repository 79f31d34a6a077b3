// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_cell.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace pipescout {
namespace {

TEST(CsvCell, AreQuotedWhereTheyMustBe) {
  EXPECT_EQ(csv_cell("24\" tee"), "\"24\"\" tee\"");
  EXPECT_EQ(csv_cell("plain text"), "plain text");
  EXPECT_EQ(csv_cell("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_cell(" a"), "\" a\"");
  EXPECT_EQ(csv_cell(""), "");
}

TEST(CsvCell, MissingNumbersAreEmpty) {
  EXPECT_EQ(format_optional_csv_number(std::numeric_limits<double>::quiet_NaN()), "");
  EXPECT_EQ(format_optional_csv_number(0.1), "0.1");
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
