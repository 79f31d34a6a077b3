// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <limits>
#include <string>

#include "pipescout/csv/csv_table.hpp"

namespace pipescout {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string error_of(std::string_view text, const CsvFormat& format = {}) {
  try {
    const CsvTable table(text, "file.csv", format);
    for (std::size_t row = 0; row < table.rows(); ++row) {
      for (std::size_t column = 0; column < table.columns().size(); ++column) {
        (void)table.any_number(row, column);
      }
    }
  } catch (const CsvError& error) {
    return error.what();
  }
  return "no error";
}

/// Rows of numbers.
std::vector<std::vector<double>> numbers_of(std::string_view text, const CsvFormat& format = {}) {
  const CsvTable table(text, "file.csv", format);
  std::vector<std::vector<double>> rows(table.rows());
  for (std::size_t row = 0; row < rows.size(); ++row) {
    for (std::size_t column = 0; column < table.columns().size(); ++column) {
      rows[row].push_back(table.any_number(row, column));
    }
  }
  return rows;
}

TEST(CsvTable, ReadsHeaderAndRows) {
  const CsvTable table("a,b\n1,2\n3, four \n", "file.csv");
  EXPECT_EQ(table.path(), "file.csv");
  EXPECT_THAT(table.columns(), ElementsAre("a", "b"));
  ASSERT_EQ(table.rows(), 2U);
  EXPECT_EQ(table.line(1), 3U);
  EXPECT_EQ(table.cell(1, 1), "four");
  EXPECT_EQ(table.find_column("b"), 1U);
  EXPECT_EQ(table.find_column("c"), std::nullopt);
  EXPECT_THAT(table.notes(), IsEmpty());
}

TEST(CsvTable, LineEndsOfAllSystems) {
  const auto rows = ElementsAre(ElementsAre(1, 2), ElementsAre(3, 4));
  EXPECT_THAT(numbers_of("\xEF\xBB\xBF"
                         "a,b\r\n1,2\r\n3,4\r\n\r\n"),
              rows);
  EXPECT_THAT(numbers_of("a,b\r1,2\r3,4\r"), rows);
  EXPECT_THAT(numbers_of("a,b\n1,2\n\n3,4"), rows);
  EXPECT_THAT(numbers_of("a,b\n1,2\n3,4\n,\n ,\n,,,\n"), rows) << "empty rows at the end";
}

TEST(CsvTable, QuotesAreOfTheWholeCell) {
  const CsvTable table("k,\"d\n[m]\"\n\"a \"\"b\"\", c\",\" 1 \"\n24\" tee, \"2\"\n", "file.csv");
  EXPECT_THAT(table.columns(), ElementsAre("k", "d [m]"));
  EXPECT_EQ(table.cell(0, 0), "a \"b\", c");
  EXPECT_EQ(table.required(0, 1), 1);
  EXPECT_EQ(table.cell(1, 0), "24\" tee");
  EXPECT_EQ(table.required(1, 1), 2);
  EXPECT_EQ(table.line(1), 4U);
  EXPECT_EQ(table.numbers().unit(1), "m");
}

TEST(CsvTable, EmptyCellsAreMissing) {
  const CsvTable table("a,b\n,1\n,\n2,3\n", "file.csv");
  ASSERT_EQ(table.rows(), 3U);
  EXPECT_EQ(table.number(0, 0), std::nullopt);
  EXPECT_TRUE(std::isnan(table.any_number(0, 0)));
}

TEST(CsvTable, ErrorsNameFileAndLine) {
  EXPECT_EQ(error_of(""), "file.csv: is empty; a header line is needed");
  EXPECT_EQ(error_of("\n\n"), "file.csv: is empty; a header line is needed");
  EXPECT_EQ(error_of("a,b\n"), "file.csv: has a header but no rows");
  EXPECT_EQ(error_of("a,b\n1,2\n1\n"), "file.csv:3: 1 cells in a table of 2 columns");
  EXPECT_EQ(error_of("a,b\n1,2,3\n"), "file.csv:2: 3 cells in a table of 2 columns");
  EXPECT_EQ(error_of("a,b\n1,2\n,,\n3,4\n"), "file.csv:3: 3 cells in a table of 2 columns");
  EXPECT_EQ(error_of("a,b\n1,\"2\n"), "file.csv:2: a quotation mark of this row is not closed");
  EXPECT_EQ(error_of("a,b\n1,x\n"), "file.csv:2: column 'b': 'x' is not a finite number");
  EXPECT_EQ(error_of("a,b\n1,1e12\n"), "file.csv:2: column 'b': '1e12' is out of range");
  EXPECT_EQ(error_of(std::string_view("a,b\n1,\0002\n", 9)),
            "file.csv:2: is not text: it contains a zero byte; UTF-16 needs its byte order mark");
  const CsvTable table("a,b,a\n1,2,3\n", "file.csv");
  EXPECT_THROW((void)table.find_column("a"), CsvError);
}

TEST(CsvTable, HasALimitOfColumns) {
  std::string header = "c1";
  for (std::size_t i = 2; i <= kMaxCsvColumns; ++i) {
    header += ",c" + std::to_string(i);
  }
  EXPECT_EQ(error_of(header), "file.csv: has a header but no rows");
  EXPECT_EQ(error_of(header + ",more"), "file.csv:1: 1025 columns; there may be 1024");
  EXPECT_EQ(error_of("a,b\n" + std::string(5000, ',') + "1"),
            "file.csv:2: 5001 cells in a table of 2 columns");
}

TEST(CsvReader, GoesFromRowToRowWithoutACopy) {
  const std::string text = "a,b\n1, 2\n3,4\n\n";
  CsvReader reader(text, "file.csv");
  EXPECT_EQ(reader.rows(), 2U);
  ASSERT_TRUE(reader.next());
  EXPECT_EQ(reader.line(), 2U);
  EXPECT_THAT(reader.cells(), ElementsAre("1", "2"));
  EXPECT_EQ(reader.cells()[0].data(), text.data() + 4);
  ASSERT_TRUE(reader.next());
  try {
    reader.refuse(1, "a colour");
    FAIL() << "not refused";
  } catch (const CsvError& error) {
    EXPECT_STREQ(error.what(), "file.csv:3: column 'b': '4' is not a colour");
  }
  EXPECT_FALSE(reader.next());
}

TEST(CsvDelimiter, IsRecognised) {
  const auto rows = ElementsAre(ElementsAre(1, 2.5), ElementsAre(3, 4));
  EXPECT_THAT(numbers_of("a;b\n1;2.5\n3;4\n"), rows);
  EXPECT_THAT(numbers_of("a\tb\n1\t2,5\n3\t4\n"), rows);
  EXPECT_THAT(numbers_of("a|b\n1|2.5\n3|4\n"), rows);
  EXPECT_THAT(numbers_of("a,\tb\n1,\t2.5\n3,\t4\n"), rows) << "tabs for the eye";
  EXPECT_THAT(numbers_of("a  b\n1  2.5\n3\t4\n", {.delimiter = ' '}), rows);
  EXPECT_THAT(numbers_of("1;2,5\n3;4\n", {.header = false}), rows);
  EXPECT_THAT(numbers_of("Weg, m;Signal, V\n1;2,5\n3;4\n"), rows);
  EXPECT_THAT(numbers_of("Weg, m;Signal, V\n1,5;2,5\n3,5;4,5\n"),
              ElementsAre(ElementsAre(1.5, 2.5), ElementsAre(3.5, 4.5)));
  EXPECT_THAT(numbers_of("a\n1,5\n2\n"), ElementsAre(ElementsAre(1.5), ElementsAre(2)))
      << "one column has no delimiter";
}

TEST(CsvDelimiter, IsAskedForInDoubt) {
  const std::string text = "a,b;c\nx,y;z\n";
  EXPECT_EQ(error_of(text, {.settings = "m.yaml"}),
            "file.csv:1: the columns may be separated by ',' or by ';'; set 'delimiter' in m.yaml");
  EXPECT_EQ(
      error_of(text),
      "file.csv:1: the columns may be separated by ',' or by ';'; say it in a first line such "
      "as sep=;");
  EXPECT_EQ(CsvTable(text, "", {.delimiter = ','}).cell(0, 1), "y;z");
}

TEST(CsvDelimiter, SeparatorLinesAreUnderstood) {
  const auto rows = ElementsAre(ElementsAre(1, 2));
  EXPECT_THAT(numbers_of("sep=,\na,b\n1,2\n"), rows);
  EXPECT_THAT(numbers_of("SEP=;\r\na;b\r\n1;2\r\n"), rows);
  EXPECT_THAT(numbers_of("\"sep=\t\"\na\tb\n1\t2\n"), rows);
  EXPECT_EQ(error_of("sep=,\na,b\n1,x\n"), "file.csv:3: column 'b': 'x' is not a finite number");
  EXPECT_THAT(error_of("sep=x\naxb\n1x2\n"), HasSubstr("the delimiter must be"));
  EXPECT_EQ(error_of("sep=;\na;b\n1;2\n", {.delimiter = ',', .settings = "m.yaml"}),
            "file.csv:1: the file says sep=;, and 'delimiter' in m.yaml says ','");
  EXPECT_EQ(error_of("sep=;\n"), "file.csv: is empty; a header line is needed");
}

TEST(CsvDecimalMark, IsProvedByOneCell) {
  EXPECT_THAT(numbers_of("a;b\n1,234;0,5\n"), ElementsAre(ElementsAre(1.234, 0.5)));
  EXPECT_THAT(numbers_of("a;b\n1.234;0.5\n"), ElementsAre(ElementsAre(1.234, 0.5)));
  EXPECT_THAT(numbers_of("a;b\n1.234,5;-1,5e-3\n"), ElementsAre(ElementsAre(1234.5, -1.5e-3)));
  EXPECT_THAT(numbers_of("a,b\n\"1,234.5\",2\n\"1,234\",3\n"),
              ElementsAre(ElementsAre(1234.5, 2), ElementsAre(1234, 3)));
  EXPECT_THAT(numbers_of("a,b\n1.234,+2\n"), ElementsAre(ElementsAre(1.234, 2)))
      << "commas separate columns";
  EXPECT_THAT(numbers_of("a,b\n\"1,5\",2\n"), ElementsAre(ElementsAre(1.5, 2)));
  EXPECT_THAT(numbers_of("a;b\n1.234;2\n", {.decimal_mark = '.'}),
              ElementsAre(ElementsAre(1.234, 2)));
  EXPECT_THAT(numbers_of("a;b\n1.234;2\n", {.decimal_mark = ','}),
              ElementsAre(ElementsAre(1234, 2)));
  EXPECT_THAT(numbers_of("a,b,c\n\"1,5\",1.234,0.5\n"), ElementsAre(ElementsAre(1.5, 1.234, 0.5)))
      << "commas separate columns, but for those in quotes";
  // A text column proves nothing of the others.
  const CsvTable table("note;d\n1.5;0,25\nx;0,5\n", "file.csv");
  EXPECT_EQ(table.required(0, 1), 0.25);
}

TEST(CsvDecimalMark, IsAskedForInDoubt) {
  EXPECT_EQ(error_of("a;b\n7;1,234\n", {.settings = "m.yaml"}),
            "file.csv:2: column 'b': '1,234' may be 1.234 or 1234; set 'decimal_mark' in m.yaml");
  EXPECT_EQ(error_of("a;b\n7;1.234\n", {.settings = "--"}),
            "file.csv:2: column 'b': '1.234' may be 1.234 or 1234; give --decimal-mark");
  EXPECT_EQ(error_of("a,b\n7,\"1,234\"\n"),
            "file.csv:2: column 'b': '1,234' may be 1.234 or 1234; write numbers with a decimal "
            "point and without marks between thousands");
  EXPECT_THAT(error_of("a;b\n0,5;1.234\n"), HasSubstr("'1.234' may be 1.234 or 1234"))
      << "b may come from another program than a";
  EXPECT_THAT(error_of("a;b\n0,5;1\n0.5;2\n"),
              HasSubstr("line 3 has a decimal point and line 2 a decimal comma"));
  for (const char* text : {"1.2.3", "29.11.2026", "1,23,456", "1.234.56", "12.34,5", "1,2.3"}) {
    EXPECT_EQ(error_of("a;b\n" + std::string(text) + ";2\n"),
              "file.csv:2: column 'a': '" + std::string(text) + "' is not a finite number");
  }
}

TEST(CsvDecimalMark, IsSaid) {
  EXPECT_THAT(CsvTable("a;b\n0,5;1\n", "file.csv").notes(),
              ElementsAre("file.csv: numbers have a decimal comma"));
}

TEST(CsvUnits, OfARowBelowTheHeader) {
  const CsvTable table("stamp;left;note\n[s];mm;\n1;5;x\n", "file.csv");
  ASSERT_EQ(table.rows(), 1U);
  EXPECT_EQ(table.numbers().unit(1), "mm");
  EXPECT_EQ(table.numbers().unit(2), "");
  EXPECT_EQ(table.line(0), 3U);
  EXPECT_THAT(table.notes(), ElementsAre("file.csv:2: is taken for a row of units"));
  for (const char* names : {"id,joint\nA,1\nB,2\n", "id,joint\nA,\nB,2\n", "k,d\nm,\nV,2\n"}) {
    EXPECT_EQ(CsvTable(names, "").rows(), 2U) << "names that are units elsewhere: " << names;
  }
  EXPECT_EQ(error_of("a,b\nmetres,wide\n1,2\n"),
            "file.csv:2: column 'a': 'metres' is not a finite number");
}

TEST(CsvEncoding, OfSpreadsheets) {
  const auto with = [](std::string_view bytes) {
    const CsvTable table(bytes, "file.csv");
    return table.columns().front() + "|" + table.cell(0, 0);
  };
  EXPECT_EQ(with("Länge,b\n€,2\n"), "Länge|€");
  EXPECT_EQ(with("L\xE4nge,b\n\x80,2\n"), "Länge|€");
  EXPECT_EQ(with(std::string_view("\xFF\xFEL\0\xE4\0,\0b\0\n\0\xAC\x20,\0002\0\n\0", 20)), "Lä|€");
  EXPECT_EQ(with(std::string_view("\xFE\xFF\0L\0\xE4\0,\0b\0\n\xD8\x3D\xDE\x00\0,\0002\0\n", 22)),
            "Lä|\U0001F600");
  EXPECT_THAT(CsvTable("a,b\nS\xFC"
                       "d,2\n",
                       "file.csv")
                  .notes(),
              ElementsAre("file.csv:2: byte 0xfc is not UTF-8; the file is read as Windows-1252"));
  EXPECT_EQ(error_of("a,b\n\x81,2\n"),
            "file.csv:2: is neither UTF-8 nor Windows-1252: byte 0x81; save it as UTF-8, for "
            "example with iconv -f ENCODING -t UTF-8");
  EXPECT_EQ(error_of("ä,b\n\xFC,2\n"),
            "file.csv:2: is not UTF-8: byte 0xfc, and other lines are; save it as UTF-8");
  EXPECT_THAT(error_of(std::string_view("\xFF\xFE"
                                        "a",
                                        3)),
              HasSubstr("in the middle of a character"));
  EXPECT_THAT(error_of(std::string_view("\xFF\xFE\x00\xD8"
                                        "a\0",
                                        6)),
              HasSubstr("half a character"));
}

/// Of the first row, and the note.
std::pair<std::int64_t, std::string> time_of(std::string_view text, const CsvFormat& format = {}) {
  CsvReader reader(text, "f.csv", format);
  EXPECT_TRUE(reader.next());
  const auto time = reader.time(0);
  return {time ? time->count() : -1, reader.numbers()->time_note(0)};
}

TEST(CsvTimes, InTheUnitThatTheirSizeSays) {
  using ::testing::Pair;
  constexpr std::int64_t kTime = 1'700'000'000'015'000'000;
  EXPECT_THAT(time_of("t,x\n1700000000.015,1\n"), Pair(kTime, ""));
  EXPECT_THAT(time_of("t,x\n1700000000015,1\n"),
              Pair(kTime, "f.csv: column 't': times are in ms, by their size"));
  EXPECT_THAT(time_of("t,x\n1700000000015000,1\n"),
              Pair(kTime, "f.csv: column 't': times are in us, by their size"));
  EXPECT_THAT(time_of("t,x\n1700000000015000000,1\n"),
              Pair(kTime, "f.csv: column 't': times are in ns, by their size"));
  EXPECT_THAT(time_of("t;x\n1700000000,015;1\n"), Pair(kTime, ""));
  EXPECT_THAT(time_of("t_ms,x\n250,1\n"),
              Pair(250'000'000, "f.csv: column 't_ms': times are in ms"));
  EXPECT_THAT(time_of("t,x\nms,m\n250,1\n"),
              Pair(250'000'000, "f.csv: column 't': times are in ms"));
  EXPECT_THAT(time_of("t,x\n250,1\n", {.time_unit = TimeUnit::kMilliseconds}),
              Pair(250'000'000, ""));
  EXPECT_THAT(time_of("t,x\n-0.036,1\n"), Pair(-36'000'000, ""));
  EXPECT_THAT(time_of("t,x\n1.5e1,1\n"), Pair(15'000'000'000, ""));
  EXPECT_THAT(time_of("t,x\n2023-11-14T22:13:20.015Z,1\n"), Pair(kTime, ""));
  EXPECT_THAT(time_of("t,x\n2023-11-14 22:13:20.015,1\n"),
              Pair(kTime, "f.csv: column 't': times without a zone are taken for UTC"));
  EXPECT_THAT(time_of("t,x\n2023-1-4 2:13:20,1\n"), Pair(-1, ""));
}

TEST(CsvTimes, AskForTheUnitInDoubt) {
  const auto error = [](std::string_view text, const CsvFormat& format = {}) -> std::string {
    try {
      (void)time_of(text, format);
    } catch (const CsvError& refused) {
      return refused.what();
    }
    return "no error";
  };
  EXPECT_EQ(error("t,x\n0,1\n100000000000,1\n", {.settings = "m.yaml"}),
            "f.csv:3: column 't': a time of 12 digits is beyond what a time in s can be; set "
            "'time_unit' in m.yaml");
  EXPECT_EQ(error("t,x\n1700000000,1\n1700000000015,1\n"),
            "f.csv:3: column 't': a time of 13 digits is beyond what a time in s can be; name the "
            "column's unit in brackets, as in 't [ns]'");
  EXPECT_THAT(error("t_s,x\n1700000000015,1\n"), HasSubstr("in s can be"));
}

TEST(CsvReader, RowsOfSeveralKinds) {
  CsvReader reader("# made by hand\nimu,1,2\ngps,3\n", "f.csv",
                   {.header = false, .comments = true, .ragged = true});
  ASSERT_TRUE(reader.next());
  EXPECT_THAT(reader.cells(), ElementsAre("imu", "1", "2"));
  EXPECT_EQ(reader.line(), 2U);
  ASSERT_TRUE(reader.next());
  EXPECT_THAT(reader.cells(), ElementsAre("gps", "3"));
  EXPECT_FALSE(reader.next());
}

TEST(CsvReader, ALastLineThatWasCutIsLeftOutOnRequest) {
  const CsvFormat format{.cut_end = true};
  CsvReader reader("a,b\n1,2\n3", "f.csv", format);
  EXPECT_EQ(reader.rows(), 1U);
  EXPECT_THAT(reader.notes(), ElementsAre("f.csv:3: the last line is truncated: ignored"));
  EXPECT_EQ(CsvReader("a,b\n1,2\n3,4", "f.csv", format).rows(), 2U);
  EXPECT_EQ(error_of("a,b\n1\n3,4\n", format), "file.csv:2: 1 cells in a table of 2 columns");
}

TEST(CsvTable, AnyTextIsATableOrACsvError) {
  rc::check([] {
    // Few characters, so that tables come up too.
    const auto text = *rc::gen::container<std::string>(
        rc::gen::elementOf(std::string("ab1,,\n\n\r \t\"\0\xEF\xBB\xBF\xFF;.", 18)));
    try {
      const CsvTable table(text, "fuzz");
      RC_ASSERT(!table.columns().empty());
      RC_ASSERT(table.rows() > 0);
      for (std::size_t row = 0; row < table.rows(); ++row) {
        (void)table.cell(row, table.columns().size() - 1);
        try {
          (void)table.any_number(row, 0);
        } catch (const CsvError&) {
        }
      }
      CsvReader reader(text, "fuzz");
      std::size_t rows = 0;
      while (reader.next()) {
        ++rows;
        RC_ASSERT(reader.cells().size() == reader.columns().size());
      }
      RC_ASSERT(rows == reader.rows());
    } catch (const CsvError& error) {
      RC_ASSERT(std::string(error.what()).starts_with("fuzz"));
    }
  });
}

}  // namespace
}  // namespace pipescout
