// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "pipescout/csv/csv_table.hpp"
#include "pipescout/csv/utf8.hpp"

namespace pipescout {
namespace {

class CsvFile : public ::testing::Test {
 protected:
  CsvFile()
      : file_(std::filesystem::temp_directory_path() /
              ("csv_file_" + std::to_string(::getpid()) + ".csv")) {}
  ~CsvFile() override { std::filesystem::remove(file_); }

  /// What is wrong, behind the path; empty where nothing is.
  std::string error_of(const std::string& text) const {
    std::ofstream(file_, std::ios::binary) << text;
    try {
      EXPECT_EQ(read_csv_text(file_.string()), text);
    } catch (const CsvError& error) {
      return std::string(error.what()).substr(file_.string().size());
    }
    return "";
  }

  std::filesystem::path file_;
};

TEST_F(CsvFile, Utf8IsRead) {
  EXPECT_EQ(error_of("a,b\n1,2\n"), "");
  EXPECT_EQ(error_of("\xEF\xBB\xBF"
                     "Au\u00DFen,\u20AC,\U0001F600\n"),
            "");
  EXPECT_EQ(error_of(""), "");
}

TEST_F(CsvFile, OtherEncodingsAreNamedWithTheirLine) {
  EXPECT_EQ(error_of("a,b\nBeule,S\xFC"
                     "d\n"),
            ":2: is not UTF-8: byte 0xfc; save it as UTF-8, for example with iconv -f WINDOWS-1252 "
            "-t UTF-8");
  EXPECT_EQ(error_of(std::string("\xFF\xFE"
                                 "a\0",
                                 4)),
            ": is UTF-16; save it as UTF-8");
  EXPECT_EQ(error_of(std::string("\xFE\xFF\0a", 4)), ": is UTF-16; save it as UTF-8");
}

TEST(Utf8, OnlyItsShortestFormsCount) {
  for (const char* bad :
       {"\x80", "\xC0\x80", "\xC1\xBF", "\xE0\x80\x80", "\xED\xA0\x80", "\xF0\x80\x80\x80",
        "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "\xC3", "\xE2\x82", "\xE2\x28\xA1", "\xFF"}) {
    EXPECT_EQ(first_byte_not_utf8(std::string("ab") + bad), 2U);
  }
  for (const char* good : {"\xC2\x80", "\xED\x9F\xBF", "\xEE\x80\x80", "\xF4\x8F\xBF\xBF"}) {
    EXPECT_EQ(first_byte_not_utf8(good), std::string_view::npos);
  }
}

}  // namespace
}  // namespace pipescout
