// SPDX-License-Identifier: Apache-2.0
// `pipescout map` on maps written here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/map_files/grid_file.hpp"
#include "pipescout/map_files/route_graph_file.hpp"
#include "pipescout/testing/program.hpp"

namespace pipescout {
namespace {

using ::pipescout::testing::run_program;
using ::testing::AllOf;
using ::testing::HasSubstr;

/// A hall of 20 x 10 m, and a graph of two nodes that an obstacle may stand between.
class MapCommand : public ::testing::Test {
 protected:
  void write_map(bool blocked) {
    navigation::OccupancyGrid grid(
        {.resolution = 0.1, .origin = {-1, -2, 0}, .width = 200, .height = 100},
        navigation::CellState::kFree);
    if (blocked) {
      grid.set({100, 53}, navigation::CellState::kOccupied);
    }
    write_grid(file("map.yaml"), grid);
    write_route_graph(file("graph.geojson"),
                      {{{.id = 7, .position = {2, 3}}, {.id = 8, .position = {16, 3}}},
                       {{.id = 1, .from = 0, .to = 1}, {.id = 2, .from = 1, .to = 0}}});
  }
  [[nodiscard]] std::string file(const std::string& name) const {
    return (folder_.path() / name).string();
  }
  [[nodiscard]] auto run(std::vector<std::string> words) const {
    return run_program(MAP_COMMAND, std::move(words), folder_.path());
  }

 private:
  testing::TemporaryFolder folder_;
};

TEST_F(MapCommand, CheckSaysWhatIsWrong) {
  write_map(false);
  const auto good = run({"check", file("map.yaml"), "--graph", file("graph.geojson")});
  EXPECT_EQ(good.code(), 0) << good.err;
  EXPECT_THAT(good.out, AllOf(HasSubstr("200 x 100 cells of 0.1 m"), HasSubstr("2 nodes, 2 edges"),
                              HasSubstr("no problems")));
  write_map(true);
  const auto bad = run({"check", file("map.yaml"), "--graph", file("graph.geojson")});
  EXPECT_EQ(bad.code(), 1);
  EXPECT_THAT(bad.out, AllOf(HasSubstr("edge 1: the robot collides"), HasSubstr("2 problems")));
  // A robot so narrow that it passes beside the obstacle.
  EXPECT_EQ(run({"check", file("map.yaml"), "--graph", file("graph.geojson"), "--footprint", "0.1",
                 "0.1", "0.01"})
                .code(),
            0);
}

TEST_F(MapCommand, ShowDrawsGridGraphAndProblems) {
  write_map(true);
  const auto shown = run({"show", file("map.yaml"), "--graph", file("graph.geojson"), "--out",
                          file("map.png"), "--scale", "2"});
  EXPECT_EQ(shown.code(), 0) << shown.err;
  const cv::Mat picture = cv::imread(file("map.png"));
  ASSERT_EQ(picture.size(), cv::Size(400, 200));
  EXPECT_EQ(picture.at<cv::Vec3b>(5, 5), cv::Vec3b(255, 255, 255));
  // The edge, and the circle around the first problem.
  cv::Mat coloured;
  cv::inRange(picture, cv::Scalar(190, 90, 20), cv::Scalar(210, 110, 40), coloured);
  EXPECT_GT(cv::countNonZero(coloured), 100);
  cv::inRange(picture, cv::Scalar(0, 0, 220), cv::Scalar(10, 10, 240), coloured);
  EXPECT_GT(cv::countNonZero(coloured), 30);
}

TEST_F(MapCommand, WhatIsProbablyNotMeantIsAWarning) {
  write_map(false);
  cv::Mat image = cv::imread(file("map.pgm"), cv::IMREAD_UNCHANGED);
  image.row(0).setTo(205);
  ASSERT_TRUE(cv::imwrite(file("map.pgm"), image));
  const auto done = run({"check", file("map.yaml")});
  EXPECT_EQ(done.code(), 0) << done.err;
  EXPECT_THAT(done.err,
              AllOf(HasSubstr("warning: "), HasSubstr("200 of 20000 pixels have the grey 205")));
}

TEST_F(MapCommand, ErrorsNameTheFile) {
  write_map(false);
  const auto existing = run({"show", file("map.yaml"), "--out", file("map.yaml")});
  EXPECT_EQ(existing.code(), 1);
  EXPECT_THAT(existing.err, HasSubstr("map.yaml: exists already; results are never overwritten"));
  const auto missing = run({"check", file("other.yaml")});
  EXPECT_EQ(missing.code(), 2);
  EXPECT_THAT(missing.err, HasSubstr("other.yaml"));
  const auto unwritable = run({"show", file("map.yaml"), "--out", file("none/map.png")});
  EXPECT_EQ(unwritable.code(), 1);
  EXPECT_THAT(unwritable.err, HasSubstr("none/map.png"));
  const auto no_image = run({"show", file("map.yaml"), "--out", file("map.nothing")});
  EXPECT_EQ(no_image.code(), 1);
  EXPECT_THAT(no_image.err, HasSubstr("map.nothing"));
}

}  // namespace
}  // namespace pipescout
