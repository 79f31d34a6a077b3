// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/files/whole_file.hpp"
#include "pipescout/map_files/grid_file.hpp"
#include "pipescout/map_files/lattice_file.hpp"
#include "pipescout/map_files/route_graph_file.hpp"

namespace pipescout {
namespace {

using navigation::CellState;
using navigation::OccupancyGrid;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string error_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

class MapFiles : public ::testing::Test {
 protected:
  std::vector<std::string> remarks_;

  [[nodiscard]] std::filesystem::path file(const std::string& name) const {
    return folder_.path() / name;
  }
  void write(const std::string& name, const std::string& text) const {
    replace_file(file(name), text);
  }
  void expect_error(const std::function<void()>& call, const std::string& part) const {
    const std::string error = error_of(call);
    EXPECT_NE(error.find(part), std::string::npos) << error;
    EXPECT_NE(error.find(folder_.path().string()), std::string::npos) << error;
  }

 private:
  testing::TemporaryFolder folder_;
};

constexpr const char* kYaml =
    "image: map.pgm\nresolution: 0.5\norigin: [1.0, -2.0, 0.1]\nnegate: 0\n"
    "occupied_thresh: 0.65\nfree_thresh: 0.25\n";

TEST_F(MapFiles, AnImageAloneHasTheThresholdsOfRos1) {
  write("map.pgm", "P2\n3 1\n255\n254 205 0\n");
  const OccupancyGrid grid = read_grid_image(file("map.pgm"), 0.1);
  EXPECT_EQ(grid.at({0, 0}), CellState::kFree);
  EXPECT_EQ(grid.at({1, 0}), CellState::kUnknown);
  EXPECT_EQ(grid.at({2, 0}), CellState::kOccupied);
  EXPECT_EQ(grid.resolution(), 0.1);
  expect_error([&] { (void)read_grid_image(file("none.pgm"), 0.1); }, "none.pgm");
  EXPECT_THROW((void)read_grid_image(file("map.pgm"), 0), std::invalid_argument);
}

TEST_F(MapFiles, GridsOfAllModesComeBack) {
  OccupancyGrid grid({.resolution = 0.05, .origin = {-3, 4, 0.5}, .width = 3, .height = 2},
                     CellState::kUnknown);
  grid.set({0, 0}, CellState::kOccupied);
  grid.set({2, 1}, CellState::kFree);
  for (const GridMode mode : {GridMode::kTrinary, GridMode::kScale, GridMode::kRaw}) {
    write_grid(file("map.yaml"), grid, mode);
    EXPECT_EQ(read_grid(file("map.yaml"), remarks_), grid);
  }
}

TEST_F(MapFiles, TheLastRowOfTheImageIsTheFirstOfTheGrid) {
  write("map.yaml", kYaml);
  write("map.pgm", "P2 # made by hand\n2 2\n255\n0 254\n128 254\n");
  const OccupancyGrid grid = read_grid(file("map.yaml"), remarks_);
  EXPECT_EQ(grid.at({0, 1}), CellState::kOccupied);
  EXPECT_EQ(grid.at({0, 0}), CellState::kUnknown);
  EXPECT_EQ(grid.at({1, 0}), CellState::kFree);
  EXPECT_EQ(grid.geometry().origin, (navigation::Pose2d{1, -2, 0.1}));
}

TEST_F(MapFiles, GridErrorsNameTheField) {
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = kYaml;
    text.replace(text.find(from), from.size(), to);
    write("map.yaml", text);
    return [this] { (void)read_grid(file("map.yaml"), remarks_); };
  };
  expect_error(with("map.pgm", "missing.pgm"), "missing.pgm' cannot be read");
  write("map.pgm", "P5\n2 2\n255\nabc");
  expect_error(with("map.pgm", "map.pgm"), "truncated: 4 pixels expected, 3 found");
  write("map.pgm", "P5\n2 2\n255\nabcd");
  expect_error(with("0.25", "0.7"), "free_thresh must be below occupied_thresh");
  expect_error(with("0.65", "65"), "occupied_thresh is 65; it must be within [0, 1]");
  expect_error(with("0.5", "0"), "resolution must be within");
  expect_error(with("0.5", ".nan"), "resolution must be a finite number");
  expect_error(with("origin", "origins"), "key 'origin' is missing");
  expect_error(with("negate: 0", "negate: 0\nmode: ternary"), "mode must be");
  write("map.yaml", kYaml);
  expect_error([&] { (void)read_grid(file("map.yaml"), remarks_, 0.1); },
               "resolution is 0.5 m; it must be 0.1 m here");
  expect_error([&] { (void)read_grid(file("none.yaml"), remarks_); }, "none.yaml");
}

/// An image of one row, as OpenCV writes it by the name.
void write_image(const std::filesystem::path& path, int type, const std::vector<cv::Scalar>& row) {
  cv::Mat image(1, static_cast<int>(row.size()), type);
  for (int k = 0; k < image.cols; ++k) {
    image.col(k).setTo(row[static_cast<std::size_t>(k)]);
  }
  ASSERT_TRUE(cv::imwrite(path.string(), image));
}

std::string yaml_of(const std::string& image, const std::string& more = "") {
  std::string text = kYaml;
  text.replace(text.find("map.pgm"), 7, image);
  return text + more;
}

std::vector<CellState> row_of(const OccupancyGrid& grid) {
  std::vector<CellState> cells;
  for (int k = 0; k < grid.width(); ++k) {
    cells.push_back(grid.at({k, 0}));
  }
  return cells;
}

constexpr CellState kFree = CellState::kFree;
constexpr CellState kOccupied = CellState::kOccupied;
constexpr CellState kUnknown = CellState::kUnknown;

TEST_F(MapFiles, ImagesOfOtherKindsAreTheSameGrid) {
  const auto grey = [](double v) { return cv::Scalar(v, v, v); };
  write_image(file("map.png"), CV_8UC1, {grey(0), grey(254), grey(128)});
  write_image(file("map.bmp"), CV_8UC3, {grey(0), grey(254), grey(128)});
  write_image(file("deep.png"), CV_16UC1, {grey(0), grey(65000), grey(32768)});
  for (const char* image : {"map.png", "map.bmp", "deep.png"}) {
    write("map.yaml", yaml_of(image));
    EXPECT_THAT(row_of(read_grid(file("map.yaml"), remarks_)),
                ElementsAre(kOccupied, kFree, kUnknown))
        << image;
  }
  EXPECT_THAT(remarks_, IsEmpty());
}

TEST_F(MapFiles, AlphaIsTakenAsNav2TakesIt) {
  // Black and white, opaque and transparent.
  write_image(file("map.png"), CV_8UC4,
              {{0, 0, 0, 255}, {255, 255, 255, 255}, {0, 0, 0, 0}, {255, 255, 255, 0}});
  write("map.yaml", yaml_of("map.png"));
  // The mean with alpha: 64, 255, 0 and 191 of 255, so 0.75, 0, 1 and 0.25 occupied.
  EXPECT_THAT(row_of(read_grid(file("map.yaml"), remarks_)),
              ElementsAre(kOccupied, kFree, kOccupied, kUnknown));
  write("map.yaml", yaml_of("map.png", "mode: scale\n"));
  EXPECT_THAT(row_of(read_grid(file("map.yaml"), remarks_)),
              ElementsAre(kOccupied, kFree, kUnknown, kUnknown));
  write("map.yaml", yaml_of("map.png", "mode: raw\n"));
  EXPECT_THAT(row_of(read_grid(file("map.yaml"), remarks_)),
              ElementsAre(kFree, kUnknown, kFree, kUnknown));
}

TEST_F(MapFiles, WhatWasSavedAsUnknownAndIsReadAsFreeIsRemarked) {
  write("map.yaml", kYaml);
  write("map.pgm", "P2\n4 1\n255\n0 254 205 205\n");
  EXPECT_THAT(row_of(read_grid(file("map.yaml"), remarks_)),
              ElementsAre(kOccupied, kFree, kFree, kFree));
  EXPECT_THAT(remarks_, ElementsAre(::testing::AllOf(
                            HasSubstr("map.yaml:6:14: 2 of 4 pixels have the grey 205"),
                            HasSubstr("with a free_thresh of 0.196"))));
  // As it says, and without such pixels nothing is said.
  remarks_.clear();
  std::string text = kYaml;
  text.replace(text.find("0.25"), 4, "0.196");
  write("map.yaml", text);
  EXPECT_THAT(row_of(read_grid(file("map.yaml"), remarks_)),
              ElementsAre(kOccupied, kFree, kUnknown, kUnknown));
  write("map.yaml", kYaml);
  write("map.pgm", "P2\n2 1\n255\n0 254\n");
  (void)read_grid(file("map.yaml"), remarks_);
  EXPECT_THAT(remarks_, IsEmpty());
}

TEST_F(MapFiles, AnOpaqueAlphaMakesUnknownFree) {
  write_image(file("map.png"), CV_8UC4, {{205, 205, 205, 255}, {0, 0, 0, 255}});
  std::string text = yaml_of("map.png");
  text.replace(text.find("0.25"), 4, "0.196");
  write("map.yaml", text);
  EXPECT_THAT(row_of(read_grid(file("map.yaml"), remarks_)), ElementsAre(kFree, kOccupied));
  EXPECT_THAT(remarks_, ElementsAre(HasSubstr("with a free_thresh of 0.147")));
  text.replace(text.find("0.196"), 5, "0.147");
  write("map.yaml", text);
  EXPECT_THAT(row_of(read_grid(file("map.yaml"), remarks_)), ElementsAre(kUnknown, kOccupied));
  expect_error([&] { (void)read_grid_image(file("map.png"), 0.1); }, "map.png: 1 of 2 pixels");
}

TEST_F(MapFiles, ImagesThatCannotBeReadAreNamed) {
  write("map.yaml", yaml_of("map.png"));
  const auto read = [&] { (void)read_grid(file("map.yaml"), remarks_); };
  write("map.png", "");
  expect_error(read, "map.png: it is no image");
  write("map.png", "no image");
  expect_error(read, "map.png: it is no image");
  write_image(file("whole.png"), CV_8UC1, std::vector<cv::Scalar>(1000, cv::Scalar(7)));
  std::filesystem::copy_file(file("whole.png"), file("map.png"),
                             std::filesystem::copy_options::overwrite_existing);
  std::filesystem::resize_file(file("map.png"), std::filesystem::file_size(file("map.png")) / 2);
  expect_error(read, "map.png: ");
}

TEST_F(MapFiles, GraphsComeBack) {
  const navigation::RouteGraph graph(
      {{.id = 4, .position = {1, 2}}, {.id = 9, .position = {5.5, 2}}},
      {{.id = 10,
        .from = 0,
        .to = 1,
        .cost = 7,
        .speed = 1.5,
        .width = 4,
        .pipe_side = navigation::PipeSide::kLeft,
        .one_way = true,
        .closed_until = std::numeric_limits<double>::infinity(),
        .line = {{1, 2}, {3, 3}, {5.5, 2}}},
       {.id = 11, .from = 1, .to = 0, .closed_until = 12}});
  write_route_graph(file("graph.geojson"), graph);
  const navigation::RouteGraph read = read_route_graph(file("graph.geojson"), remarks_);
  ASSERT_EQ(read.edges().size(), 2U);
  EXPECT_EQ(read.nodes()[1].id, 9);
  EXPECT_EQ(read.edges()[0].line, graph.edges()[0].line);
  EXPECT_EQ(read.edges()[0].cost, 7);
  EXPECT_EQ(read.edges()[0].speed, 1.5);
  EXPECT_EQ(read.edges()[0].pipe_side, navigation::PipeSide::kLeft);
  EXPECT_TRUE(read.edges()[0].one_way);
  EXPECT_EQ(read.edges()[0].closed_until, std::numeric_limits<double>::infinity());
  EXPECT_EQ(read.edges()[1].closed_until, 12);
  EXPECT_EQ(read.edges()[1].cost, std::nullopt);
}

TEST_F(MapFiles, GraphErrorsNameTheFeature) {
  const auto edge = [&](const std::string& properties) {
    write(
        "g.geojson",
        R"({"features": [{"properties": {"id": 1}, "geometry": {"type": "Point", "coordinates": [0, 0]}},
             {"properties": {"id": 2}, "geometry": {"type": "Point", "coordinates": [1, 0]}},
             {"properties": {)" +
            properties +
            R"(}, "geometry": {"type": "LineString", "coordinates": [[0, 0], [1, 0]]}}]})");
    return [this] { (void)read_route_graph(file("g.geojson"), remarks_); };
  };
  expect_error(edge(R"("id": 5, "startid": 1, "endid": 3)"),
               "edge 5: endid is 3; no such node is there");
  expect_error(edge(R"("id": 5, "startid": 1)"), "edge 5: endid must be a whole number");
  expect_error(edge(R"("id": 5, "startid": 1, "endid": 2, "cost": -1)"), "edge 5: cost is -1");
  expect_error(edge(R"("id": 5, "startid": 1, "endid": 2, "metadata": {"pipe_side": "up"})"),
               "edge 5: pipe_side must be");
  write("g.geojson", "{");
  expect_error([&] { (void)read_route_graph(file("g.geojson"), remarks_); }, "parse error");
  write("g.geojson", R"({"features": []})");
  EXPECT_TRUE(read_route_graph(file("g.geojson"), remarks_).nodes().empty());
}

/// Two nodes at (0, 0) and (4, 0), a third on the second, and edges.
std::string graph_of(const std::string& edges) {
  return R"({"type": "FeatureCollection", "features": [
    {"properties": {"id": 1}, "geometry": {"type": "Point", "coordinates": [0, 0]}},
    {"properties": {"id": 2, "operations": {"stop": {"type": "stop", "trigger": "NODE"}}},
     "geometry": {"type": "Point", "coordinates": [4, 0]}},
    {"properties": {"id": 3}, "geometry": {"type": "Point", "coordinates": [4, 0]}},)" +
         edges + "]}";
}

std::string edge_of(const std::string& properties, const std::string& geometry) {
  return R"({"properties": {)" + properties + R"(}, "geometry": {)" + geometry + "}}";
}

TEST_F(MapFiles, GraphsAsNav2WritesThem) {
  // Its saver writes no coordinates, a cost of 0 that may be overridden, and operations by name.
  write(
      "g.geojson",
      graph_of(
          edge_of(R"("id": 5, "startid": 1, "endid": 2, "cost": 0.0, "overridable": true,
                         "metadata": {"abs_speed_limit": 0.85, "aisle": 14, "speed_limit": 80},
                         "operations": {"door": {"type": "open_door", "trigger": "ON_ENTER"}})",
                  R"("type": "MultiLineString")") +
          "," +
          edge_of(R"("id": 6, "startid": 2, "endid": 1, "cost": 7, "overridable": false)",
                  R"("type": "LineString", "coordinates": [[[4, 0], [2, 1]], [[2, 1], [0, 0]]])") +
          "," +
          edge_of(R"("id": 7, "startid": 2, "endid": 2)",
                  R"("type": "LineString", "coordinates": [[4, 0], [0, 0], [4, 0]])") +
          "," +
          edge_of(R"("id": 6, "startid": 3, "endid": 1, "cost": 3, "overridable": true)",
                  R"("type": "MultiLineString", "coordinates": [[[4, 0], [0, 0]]])")));
  const auto graph = read_route_graph(file("g.geojson"), remarks_);
  ASSERT_EQ(graph.edges().size(), 3U);
  EXPECT_EQ(graph.edges()[0].cost, std::nullopt);
  EXPECT_EQ(graph.edges()[0].speed, 0.85);
  EXPECT_DOUBLE_EQ(graph.length(0), 4);
  EXPECT_EQ(graph.edges()[1].cost, 7);
  EXPECT_EQ(graph.edges()[1].line, (std::vector<navigation::Point2d>{{4, 0}, {2, 1}, {0, 0}}));
  EXPECT_THAT(
      remarks_,
      ElementsAre(HasSubstr("g.geojson: not used of the edges' metadata, with the number of "
                            "edges: aisle (1), speed_limit (1)"),
                  HasSubstr("give abs_speed_limit in m/s"),
                  HasSubstr("not carried out, with their number: open_door (1), stop (1)"),
                  HasSubstr("edges from a node to itself are left out: 7 (1)"),
                  HasSubstr("ids of several edges between the same places: 6 (2)"),
                  HasSubstr("the cost of 1 edges does not count, since overridable is true")));
}

TEST_F(MapFiles, EdgesOfOneIdBetweenDifferentPlacesAreRefused) {
  write("g.geojson", graph_of(edge_of(R"("id": 5, "startid": 1, "endid": 2)",
                                      R"("type": "LineString", "coordinates": [[0, 0], [4, 0]])") +
                              "," +
                              edge_of(R"("id": 5, "startid": 2, "endid": 1)",
                                      R"("type": "LineString", "coordinates": [[4, 0], [0, 0]])")));
  expect_error([&] { (void)read_route_graph(file("g.geojson"), remarks_); },
               "g.geojson: edge 5: two edges have this id, from node 1 to node 2 and from node 2 "
               "to node 1");
}

TEST_F(MapFiles, LatticesComeBack) {
  const auto lattice = navigation::generate_primitives(0.5, 0.05);
  write_lattice(file("lattice.json"), lattice);
  const auto read = read_lattice(file("lattice.json"));
  ASSERT_EQ(read.primitives.size(), lattice.primitives.size());
  EXPECT_EQ(read.headings, lattice.headings);
  for (std::size_t i = 0; i < read.primitives.size(); ++i) {
    EXPECT_EQ(read.primitives[i].columns, lattice.primitives[i].columns);
    EXPECT_EQ(read.primitives[i].rows, lattice.primitives[i].rows);
    EXPECT_NEAR(read.primitives[i].radius(), lattice.primitives[i].radius(), 1e-9);
  }
}

/// As the generator of Nav2 rounds its poses; one primitive is enough for a heading.
std::string nav2_lattice(const std::string& poses) {
  return R"({"version": 1.0, "lattice_metadata": {"motion_model": "ackermann", "turning_radius": 0.5,
    "grid_resolution": 0.05, "num_of_headings": 1, "heading_angles": [0.0]},
    "primitives": [{"trajectory_id": 0, "start_angle_index": 0, "end_angle_index": 0,
    "poses": )" +
         poses + "}]}";
}

TEST_F(MapFiles, LatticesOfNav2AndFlippedOnes) {
  write("lattice.json", nav2_lattice("[[0.05, 0.0, 0.0], [0.10001, 0.0, 0.0]]"));
  EXPECT_EQ(read_lattice(file("lattice.json")).primitives.front().columns, 2);
  const auto read = [&] { (void)read_lattice(file("lattice.json")); };
  write("lattice.json", nav2_lattice("[[0.05, 0.0, 0.0], [0.1, 0.0, 3.14159]]"));
  expect_error(read, "primitive 0: poses end at a heading of 3.14159 rad");
  write("lattice.json", nav2_lattice("[[0.05, 0.0, 3.14159], [0.1, 0.0, 0.0]]"));
  expect_error(read, "primitive 0: pose 0 is not on the way forwards");
  write("lattice.json", nav2_lattice("[[-0.05, 0.0, 0.0], [-0.1, 0.0, 0.0]]"));
  expect_error(read, "no arc forwards leads");
}

}  // namespace
}  // namespace pipescout
