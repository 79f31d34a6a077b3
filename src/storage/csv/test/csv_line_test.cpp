// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_line.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <limits>
#include <string>

namespace pipescout {
namespace {

TEST(CsvLine, NumbersReadBackAsTheyWere) {
  const std::string text = CsvLine(Stamp{} + std::chrono::milliseconds(12500))
                               .add(0.1)
                               .add(-0.0)
                               .add(std::uint64_t{18446744073709551615U})
                               .add(true)
                               .add(false)
                               .add(std::numeric_limits<double>::quiet_NaN())
                               .text();
  EXPECT_EQ(text, "12.500000000,0.1,0,18446744073709551615,1,0,nan");
}

TEST(CsvLine, ShortNumbersHaveTheDigitsOfAFloat) {
  const std::array values{0.1, 1.0 / 3.0};
  EXPECT_EQ(CsvLine({}).add_each_short(values).text(), "0.000000000,0.1,0.33333334");
  EXPECT_EQ(CsvLine({}).add_short(std::numeric_limits<double>::quiet_NaN()).text(),
            "0.000000000,nan");
  EXPECT_EQ(CsvLine({}).add_each(std::array{0.5, 2.0}).text(), "0.000000000,0.5,2");
}

TEST(CsvLine, TextStaysOneCellOfOneLine) {
  EXPECT_EQ(CsvLine({}).add("plain").add("").text(), "0.000000000,plain,");
  EXPECT_EQ(CsvLine({}).add("a \"b\",\nc").text(), "0.000000000,\"a \"\"b\"\", c\"");
  EXPECT_EQ(CsvLine({}).add(std::string(100000, 'a')).text(),
            "0.000000000," + std::string(200, 'a'));
}

TEST(CsvLine, EmptyCells) {
  EXPECT_EQ(CsvLine({}).add_empty().add(1.0).add_empty(2).text(), "0.000000000,,1,,");
}

}  // namespace
}  // namespace pipescout
