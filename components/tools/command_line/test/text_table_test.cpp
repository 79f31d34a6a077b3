// SPDX-License-Identifier: Apache-2.0
#include "pipescout/command_line/text_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

namespace pipescout::command_line {
namespace {

std::string printed(const TextTable& table) {
  std::ostringstream out;
  table.print(out);
  return out.str();
}

TEST(TextTable, AlignsTextsAndNumbers) {
  TextTable table({"name", "n", "x [m]"});
  table.add_row({std::string("a"), std::int64_t{5}, 1.5});
  table.add_row({std::string("f\xc3\xbcnf"), std::int64_t{12}, -0.125});
  table.add_row({std::monostate{}, std::monostate{}, std::int64_t{2}});
  EXPECT_EQ(printed(table),
            "name   n   x [m]\n"
            "----  --  ------\n"
            "a      5   1.500\n"
            "f\xc3\xbcnf  12  -0.125\n"
            "-      -   2.000\n");
}

TEST(TextTable, ShowsNumbersThatAreTooLongOrNone) {
  TextTable table({"x"});
  table.add_row({std::numeric_limits<double>::quiet_NaN()});
  table.add_row({1e300});
  table.add_row({1e-9});
  table.add_row({0.1 + 0.2});
  table.add_row({0.0});
  EXPECT_EQ(printed(table),
            "          x\n"
            "-----------\n"
            "        nan\n"
            "     1e+300\n"
            "      1e-09\n"
            "0.300000000\n"
            "0.000000000\n");
}

TEST(TextTable, RefusesARowOfAnotherLength) {
  TextTable table({"x", "y"});
  EXPECT_THROW(table.add_row({true}), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::command_line
