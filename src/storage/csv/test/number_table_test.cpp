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

TEST(NumberTable, CommasAndBlanksSeparate) {
  EXPECT_THAT(number_table("t, x\r\n1, 2.5\r\n\n+3\t-4e1\n", "data.csv", true, 2),
              ElementsAre(ElementsAre(1, 2.5), ElementsAre(3, -40)));
  EXPECT_TRUE(number_table("", "data.csv", false, 2).empty());
}

TEST(NumberTable, ErrorsNameFileAndLine) {
  EXPECT_THAT([] { (void)number_table("1 2\n3 x\n", "data.csv", false, 2); },
              ThrowsMessage<std::runtime_error>(StrEq("data.csv:2: 'x' is not a number")));
  EXPECT_THAT([] { (void)number_table("1 2\n3\n", "data.csv", false, 2); },
              ThrowsMessage<std::runtime_error>(StrEq("data.csv:2: 1 numbers; expected 2")));
}

}  // namespace
}  // namespace pipescout
