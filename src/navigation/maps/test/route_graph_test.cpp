// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigation_maps/route_graph.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>

#include "pipescout/navigation_maps/hybrid_map.hpp"

namespace pipescout::navigation {
namespace {

std::vector<RouteNode> three_nodes() {
  return {{.id = 10, .position = {1, 1}},
          {.id = 20, .position = {4, 1}},
          {.id = 30, .position = {4, 5}}};
}

std::string error_of(std::vector<RouteNode> nodes, std::vector<RouteEdge> edges) {
  try {
    const RouteGraph graph(std::move(nodes), std::move(edges));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(RouteGraph, FindsWhatItHolds) {
  const RouteGraph graph(three_nodes(), {{.id = 1, .from = 0, .to = 1},
                                         {.id = 2, .from = 1, .to = 0},
                                         {.id = 3, .from = 1, .to = 2}});
  EXPECT_EQ(graph.node_of_id(20), 1U);
  EXPECT_EQ(graph.edge_of_id(4), std::nullopt);
  EXPECT_EQ(graph.opposite(0), 1U);
  EXPECT_EQ(graph.opposite(2), std::nullopt);
  EXPECT_EQ(graph.outgoing(1).size(), 2U);
  EXPECT_DOUBLE_EQ(graph.length(2), 4);
  EXPECT_EQ(graph.strong_parts(), (std::vector<std::uint32_t>{0, 0, 1}));
  EXPECT_EQ(graph.nearest_node({4, 4}), 2U);
  EXPECT_EQ(RouteGraph().nearest_node({0, 0}), std::nullopt);
}

TEST(RouteGraph, EdgesOfOneIdAreOneRoadOrAMistake) {
  auto nodes = three_nodes();
  EXPECT_EQ(error_of(nodes, {{.id = 1, .from = 0, .to = 1}, {.id = 1, .from = 1, .to = 0}}),
            "edge 1: two edges have this id, from node 10 to node 20 and from node 20 to node 10");
  nodes.push_back({.id = 40, .position = nodes[1].position});
  const RouteGraph graph(nodes, {{.id = 1, .from = 0, .to = 1}, {.id = 1, .from = 0, .to = 3}});
  EXPECT_EQ(graph.edge_of_id(1), std::nullopt);
}

TEST(RouteGraph, NamesWhatIsWrong) {
  EXPECT_EQ(error_of(three_nodes(), {{.id = 7, .from = 0, .to = 3}}),
            "edge 7: a node that it joins is not there");
  EXPECT_EQ(error_of({{.id = 1}, {.id = 1}}, {}), "node 1: its id occurs twice");
  EXPECT_EQ(error_of(three_nodes(), {{.id = 7, .from = 0, .to = 1, .speed = 0}}),
            "edge 7: speed is 0; it must be within (0, 100]");
  EXPECT_EQ(error_of({{.id = 1, .position = {NAN, 0}}}, {}), "node 1: its position is not finite");
}

TEST(HybridMap, SaysWhatBlocks) {
  HybridMap map{
      RouteGraph(three_nodes(), {{.id = 1, .from = 0, .to = 1}, {.id = 2, .from = 1, .to = 0}}),
      OccupancyGrid({.resolution = 0.1, .width = 60, .height = 45}, CellState::kFree)};
  map.grid.set({25, 12}, CellState::kOccupied);
  const auto problems = check_map(map, Footprint::rectangle(0.5, 0.5, 0.6));
  ASSERT_EQ(problems.size(), 4U);
  EXPECT_EQ(problems[0].text, "node 30 at (4, 5) m is outside the grid");
  EXPECT_EQ(problems[1].kind, MapProblem::Kind::kEdgeBlocked);
  EXPECT_EQ(problems[3].text, "node 30 cannot be reached from node 10 and left again");
  EXPECT_EQ(check_map(map, Footprint::rectangle(0.5, 0.5, 0.3)).size(), 2U);
}

}  // namespace
}  // namespace pipescout::navigation
