// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_format.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace pipescout {
namespace {

using ::testing::StrEq;
using ::testing::ThrowsMessage;

TEST(CsvFormat, TakesWordsOfUsers) {
  CsvFormat format;
  format.set("delimiter", "tab");
  format.set("decimal_mark", ",");
  format.set("time_unit", "ms");
  EXPECT_EQ(format.delimiter, '\t');
  EXPECT_EQ(format.decimal_mark, ',');
  EXPECT_EQ(format.time_unit, TimeUnit::kMilliseconds);
  format.set("delimiter", "");
  EXPECT_FALSE(format.delimiter);
  EXPECT_THAT(
      [&] { format.set("decimal_mark", ";"); },
      ThrowsMessage<std::invalid_argument>(StrEq("decimal_mark must be '.' or ',', not ';'")));
  EXPECT_THAT([&] { format.set("delimiter", "x"); },
              ThrowsMessage<std::invalid_argument>(
                  StrEq("delimiter must be ',', ';', '|', tab or blank, not 'x'")));
  EXPECT_THROW(format.set("colour", "red"), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout
