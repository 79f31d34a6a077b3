// SPDX-License-Identifier: Apache-2.0
#include "pipescout/state_estimator/centre_line_file.hpp"

#include <gmock/gmock.h>

#include <string>

#include "pipescout/csv/testing/german_excel.hpp"

namespace pipescout {
namespace {

using ::testing::HasSubstr;

TEST(CentreLineFile, ReadsPointsInTheirOrder) {
  const auto line = parse_centre_line("name,z,y,x\na,1,2,3\nb,1,2,13\nc,1,12,13\n", "route.csv", 5);
  EXPECT_EQ(line.first_chainage(), 5);
  EXPECT_DOUBLE_EQ(line.last_chainage(), 25);
  ASSERT_TRUE(line.at(10));
  EXPECT_EQ(line.at(10)->position, Eigen::Vector3d(8, 2, 1));
}

TEST(CentreLineFile, AGermanExcelsExportIsTheSameLine) {
  const std::string text = "x,y,z\n0,0,0\n10.5,0,0.25\n1010.5,4.125,0\n";
  const auto original = parse_centre_line(text, "route.csv", 5);
  for (const auto as : testing::kExcelExports) {
    const auto saved = parse_centre_line(testing::german_excel(text, as), "route.csv", 5);
    EXPECT_EQ(saved.last_chainage(), original.last_chainage());
    EXPECT_EQ(saved.at(500)->position, original.at(500)->position);
  }
}

void expect_refused(const std::string& text, const std::string& reason) {
  try {
    (void)parse_centre_line(text, "route.csv", 0);
    FAIL() << "not refused: " << text;
  } catch (const CsvError& error) {
    EXPECT_THAT(error.what(), HasSubstr("route.csv"));
    EXPECT_THAT(error.what(), HasSubstr(reason));
  }
}

TEST(CentreLineFile, RefusesWhatIsNoLine) {
  expect_refused("x,y\n0,0\n1,0\n", "no column 'z'");
  expect_refused("x,y,z\n0,0,0\n1,north,0\n", "route.csv:3");
  expect_refused("x,y,z\n0,0,nan\n1,0,0\n", "finite");
  expect_refused("x,y,z\n0,0,0\n", "2");
  expect_refused("x,y,z\n0,0,0\n0,0,0\n", "segment");
  expect_refused("", "route.csv");
  EXPECT_THROW((void)read_centre_line("/does/not/exist.csv", 0), CsvError);
}

}  // namespace
}  // namespace pipescout
