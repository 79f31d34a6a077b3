// SPDX-License-Identifier: Apache-2.0
// A table that a German Excel has read and saved is the same table.
#include "pipescout/csv/testing/german_excel.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "pipescout/csv/csv_file.hpp"

namespace pipescout {
namespace {

using testing::ExcelExport;
using testing::german_excel;
using testing::kExcelExports;

TEST(GermanExcel, WritesAsItIsKnownTo) {
  EXPECT_EQ(german_excel("a,b\n1.50,\"x;y\"\n1e-7,ä\n", ExcelExport::kCsv),
            "a;b\r\n1,5;\"x;y\"\r\n1E-07;\xE4\r\n");
  EXPECT_EQ(german_excel("a,b\n1.50,ä\n", ExcelExport::kCsvUtf8),
            "\xEF\xBB\xBF"
            "a;b\r\n1,5;ä\r\n");
  EXPECT_EQ(german_excel("a\n1.5\n", ExcelExport::kUnicodeText), std::string("\xFF\xFE"
                                                                             "a\0\r\0\n\0"
                                                                             "1\0,\0"
                                                                             "5\0\r\0\n\0",
                                                                             18));
}

/// Numbers as instruments write them: some decimals, many of them three.
std::string any_number_text() {
  const int decimals = *rc::gen::elementOf(std::vector<int>{0, 1, 2, 3, 3, 3, 6});
  const double value = *rc::gen::inRange(-2'000'000, 2'000'000);
  return format_csv_number(value / std::pow(10.0, decimals));
}

TEST(GermanExcel, GivesTheSameTable) {
  rc::check([] {
    const auto columns = static_cast<std::size_t>(*rc::gen::inRange(1, 5));
    std::vector<bool> is_text;
    std::string csv;
    for (std::size_t column = 0; column < columns; ++column) {
      is_text.push_back(*rc::gen::inRange(0, 4) == 0);
      csv += (column > 0 ? "," : "") + std::string(is_text.back() ? "Bemerkung " : "Länge ") +
             std::to_string(column);
    }
    const int rows = *rc::gen::inRange(1, 12);
    for (int row = 0; row < rows; ++row) {
      for (std::size_t column = 0; column < columns; ++column) {
        csv += (column > 0 ? "," : "\n");
        csv += is_text[column] ? csv_cell(*rc::gen::elementOf(std::vector<std::string>{
                                     "Rundnaht", "Außen, 24\"", "a;b", "06:10", "x"}))
                               : any_number_text();
      }
    }
    const CsvTable original(csv + "\n", "original.csv");
    for (const ExcelExport as : kExcelExports) {
      const CsvTable saved(german_excel(csv, as), "saved.csv");
      RC_ASSERT(saved.columns() == original.columns());
      RC_ASSERT(saved.rows() == original.rows());
      for (std::size_t row = 0; row < saved.rows(); ++row) {
        for (std::size_t column = 0; column < columns; ++column) {
          if (is_text[column]) {
            RC_ASSERT(saved.cell(row, column) == original.cell(row, column));
            continue;
          }
          try {
            RC_ASSERT(saved.required(row, column) == original.required(row, column));
          } catch (const CsvError& error) {
            // Never another number: "1,234" alone is asked about.
            RC_ASSERT(std::string(error.what()).find(" may be ") != std::string::npos);
          }
        }
      }
    }
  });
}

/// Every table that the repository has, so that none of its examples fails a user who has looked at
/// it in Excel.
TEST(GermanExcel, GivesTheSameExamples) {
  namespace fs = std::filesystem;
  std::size_t tables = 0;
  for (const char* part : {"src", "components", "docs", "launch_scripts"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(REPOSITORY) / part)) {
      if (entry.path().extension() != ".csv") {
        continue;
      }
      ++tables;
      const std::string name = entry.path().string();
      const std::string csv = read_csv_text(name);
      const CsvTable original(csv, name);
      for (const ExcelExport as : kExcelExports) {
        const CsvTable saved(german_excel(csv, as), name);
        ASSERT_EQ(saved.columns(), original.columns()) << name;
        ASSERT_EQ(saved.rows(), original.rows()) << name;
        for (std::size_t row = 0; row < saved.rows(); ++row) {
          for (std::size_t column = 0; column < saved.columns().size(); ++column) {
            const auto value = parse_csv_number(original.cell(row, column));
            if (value && std::isfinite(*value)) {
              ASSERT_EQ(saved.required(row, column), *value) << name << ":" << saved.line(row);
            } else {
              ASSERT_EQ(saved.cell(row, column), original.cell(row, column)) << name;
            }
          }
        }
      }
    }
  }
  EXPECT_GE(tables, 6U) << "the examples are not where this test looks for them";
}

}  // namespace
}  // namespace pipescout
