// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/number_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace pipescout {
namespace {

using ::testing::ElementsAre;
using ::testing::StrEq;
using ::testing::ThrowsMessage;

TEST(NumberTable, CommasOrBlanksSeparate) {
  const auto rows = ElementsAre(ElementsAre(1, 2.5), ElementsAre(3, -40));
  EXPECT_THAT(number_table("t, x\r\n1, 2.5\r\n\n+3,\t-4e1\n", "data.csv", true, 2), rows);
  EXPECT_THAT(number_table(" 1  2.5\n 3\t-4e1\n", "data.txt", false, 2), rows);
}

TEST(NumberTable, ErrorsNameFileAndLine) {
  EXPECT_THAT(
      [] { (void)number_table("1 2\n3 x\n", "data.csv", false, 2); },
      ThrowsMessage<std::runtime_error>(StrEq("data.csv:2: column '2': 'x' is not a number")));
  EXPECT_THAT(
      [] { (void)number_table("1 2\n3\n", "data.csv", false, 2); },
      ThrowsMessage<std::runtime_error>(StrEq("data.csv:2: 1 cells in a table of 2 columns")));
  EXPECT_THAT([] { (void)number_table("1 2\n", "data.csv", false, 3); },
              ThrowsMessage<std::runtime_error>(StrEq("data.csv:1: 2 columns; expected 3")));
  EXPECT_THAT([] { (void)number_table("", "data.csv", false, 2); },
              ThrowsMessage<std::runtime_error>(StrEq("data.csv: is empty")));
}

}  // namespace
}  // namespace pipescout
