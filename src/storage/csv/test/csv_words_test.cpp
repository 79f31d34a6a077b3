// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_words.hpp"

#include <gtest/gtest.h>

namespace pipescout {
namespace {

TEST(CsvWords, UnitsByNameAndSymbol) {
  EXPECT_EQ(metres_per_list_unit("mm"), 1e-3);
  EXPECT_EQ(metres_per_list_unit("feet"), 0.3048);
  EXPECT_EQ(metres_per_list_unit("miles"), std::nullopt);
  EXPECT_EQ(list_unit_names(),
            "metres (m), millimetres (mm), centimetres (cm), kilometres (km), feet (ft)");
  EXPECT_EQ(bracketed("Log distance [m]"), "m");
  EXPECT_EQ(bracketed("Weg (mm)"), "mm");
  EXPECT_EQ(bracketed("Weg"), "");
  EXPECT_TRUE(is_unit_word("[mm]"));
  EXPECT_TRUE(is_unit_word("°C"));
  EXPECT_FALSE(is_unit_word("Weld"));
}

TEST(CsvWords, DelimitersAndDecimalMarks) {
  EXPECT_EQ(list_delimiter("tab"), '\t');
  EXPECT_EQ(list_delimiter("blank"), ' ');
  EXPECT_EQ(list_delimiter(";"), ';');
  for (const char* word : {"", ";;", "x", " "}) {
    EXPECT_EQ(list_delimiter(word), std::nullopt) << word;
  }
  EXPECT_EQ(decimal_mark(","), ',');
  EXPECT_EQ(decimal_mark(";"), std::nullopt);
}

TEST(CsvWords, FoldsWhiteSpace) {
  EXPECT_EQ(folded(" Log\r\n distance\xC2\xA0 [m] "), "Log distance [m]");
  EXPECT_EQ(quoted_list({"a", "b"}), "'a', 'b'");
}

}  // namespace
}  // namespace pipescout
