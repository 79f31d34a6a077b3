// SPDX-License-Identifier: Apache-2.0
#include "pipescout/crawler_simulation/route_file.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <string>

#include "pipescout/csv/csv_file.hpp"
#include "pipescout/csv/testing/german_excel.hpp"

namespace pipescout {
namespace {

using ::testing::HasSubstr;

TEST(RouteFile, StretchesBendEvenly) {
  const auto pieces = parse_route("climb,length,turn\n0,10,90\n-5,4,0\n", "route.csv");
  ASSERT_EQ(pieces.size(), 2U);
  EXPECT_EQ(pieces[0].length, 10);
  EXPECT_NEAR(pieces[0].heading_rate, M_PI / 20, 1e-15);
  EXPECT_EQ(pieces[0].pitch_rate, 0);
  EXPECT_NEAR(pieces[1].pitch_rate, -5 * M_PI / 180 / 4, 1e-15);
}

void expect_refused(const std::string& text, const std::string& reason) {
  try {
    (void)parse_route(text, "route.csv");
    FAIL() << "not refused: " << text;
  } catch (const CsvError& error) {
    EXPECT_THAT(error.what(), HasSubstr("route.csv"));
    EXPECT_THAT(error.what(), HasSubstr(reason));
  }
}

TEST(RouteFile, RefusesWhatIsNoRoute) {
  expect_refused("length,turn\n1,0\n", "no column 'climb'");
  expect_refused("length,turn,climb\n0,0,0\n", "a positive number");
  expect_refused("length,turn,climb\n1,nan,0\n", "route.csv:2");
  EXPECT_THROW((void)read_route("/does/not/exist.csv"), CsvError);
}

TEST(RouteFile, AGermanExcelsExportIsTheSameRoute) {
  const std::string text = read_csv_text(ROUTE_FILE);
  const auto original = parse_route(text, ROUTE_FILE);
  for (const auto as : testing::kExcelExports) {
    const auto saved = parse_route(testing::german_excel(text, as), "saved.csv");
    ASSERT_EQ(saved.size(), original.size());
    for (std::size_t k = 0; k < saved.size(); ++k) {
      EXPECT_EQ(saved[k].length, original[k].length);
      EXPECT_EQ(saved[k].heading_rate, original[k].heading_rate);
      EXPECT_EQ(saved[k].pitch_rate, original[k].pitch_rate);
    }
  }
}

/// What the crawler's robot is given is the line that it really follows.
TEST(RouteFile, CentreLineIsThatOfTheRoute) {
  const simulation::PipeRoute route(read_route(ROUTE_FILE), 0.5);
  std::string expected = "x,y,z\n";
  for (const Eigen::Vector3d& point : route.polyline(1.0)) {
    for (int axis = 0; axis < 3; ++axis) {
      // To the millimetre, as a survey gives it.
      expected += format_csv_number(std::round(point(axis) * 1e3) / 1e3 + 0.0);
      expected += axis < 2 ? ',' : '\n';
    }
  }
  EXPECT_EQ(read_csv_text(CENTRE_LINE_FILE), expected) << "expected:\n" << expected;
}

}  // namespace
}  // namespace pipescout
