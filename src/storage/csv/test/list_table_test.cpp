// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/list_table.hpp"

#include <gtest/gtest.h>

namespace pipescout {
namespace {

TEST(ListTable, UnitsByNameAndSymbol) {
  EXPECT_EQ(metres_per_list_unit("mm"), 1e-3);
  EXPECT_EQ(metres_per_list_unit("feet"), 0.3048);
  EXPECT_EQ(metres_per_list_unit("miles"), std::nullopt);
  EXPECT_EQ(list_unit_names(),
            "metres (m), millimetres (mm), centimetres (cm), kilometres (km), feet (ft)");
}

TEST(ListTable, DelimitersByWord) {
  EXPECT_EQ(list_delimiter("tab"), '\t');
  EXPECT_EQ(list_delimiter(";"), ';');
  EXPECT_EQ(list_delimiter(""), std::nullopt);
  EXPECT_EQ(list_delimiter(";;"), std::nullopt);
  EXPECT_EQ(list_delimiter("x"), std::nullopt);
}

TEST(ListTable, FoldsWhiteSpace) {
  EXPECT_EQ(folded(" Log\r\n distance\xC2\xA0 [m] "), "Log distance [m]");
  EXPECT_EQ(quoted_list({"a", "b"}), "'a', 'b'");
}

}  // namespace
}  // namespace pipescout
