// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "pipescout/csv/csv_reader.hpp"
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

TEST_F(CsvFile, BytesAreReadAsTheyAre) {
  EXPECT_EQ(error_of("a,b\n1,2\n"), "");
  EXPECT_EQ(error_of("\xFF\xFE\x80"), "");
  EXPECT_EQ(error_of(""), "");
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
