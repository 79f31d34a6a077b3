// SPDX-License-Identifier: Apache-2.0
#include "pipescout/planning/route_planner.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <set>
#include <stdexcept>

namespace pipescout::navigation {
namespace {

/// Roads of a block pattern of `side` x `side` crossings; some are one way, some missing.
std::shared_ptr<const RouteGraph> blocks(int side, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::vector<RouteNode> nodes;
  std::vector<RouteEdge> edges;
  for (int i = 0; i < side * side; ++i) {
    nodes.push_back({.id = i, .position = {10.0 * (i % side), 10.0 * (i / side)}});
  }
  const auto join = [&](int a, int b) {
    const double cost = 10 + static_cast<double>(engine() % 1000) / 100;
    const auto kind = engine() % 10;
    const auto from = static_cast<std::uint32_t>(a);
    const auto to = static_cast<std::uint32_t>(b);
    const auto id = [&] { return static_cast<std::int64_t>(edges.size()); };
    if (kind != 0) {
      edges.push_back({.id = id(), .from = from, .to = to, .cost = cost});
    }
    if (kind > 1) {
      edges.push_back({.id = id(), .from = to, .to = from, .cost = cost});
    }
  };
  for (int i = 0; i < side * side; ++i) {
    if (i % side + 1 < side) {
      join(i, i + 1);
    }
    if (i / side + 1 < side) {
      join(i, i + side);
    }
  }
  return std::make_shared<const RouteGraph>(std::move(nodes), std::move(edges));
}

void expect_valid(const Route& route, const RouteGraph& graph, std::uint32_t from,
                  std::uint32_t to) {
  double cost = 0;
  for (const std::uint32_t edge : route.edges) {
    EXPECT_EQ(graph.edges()[edge].from, from);
    from = graph.edges()[edge].to;
    cost += *graph.edges()[edge].cost;
  }
  EXPECT_EQ(from, to);
  EXPECT_NEAR(route.cost, cost, 1e-9 * (1 + cost));
}

TEST(RoutePlanner, CostsAreDijkstrasWhateverIsClosed) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto graph = blocks(20, seed);
    RoutePlanner planner(graph, cost_of_file(), 8);
    std::mt19937_64 engine(seed);
    const auto node = [&] { return static_cast<std::uint32_t>(engine() % 400); };
    for (int round = 0; round < 60; ++round) {
      const auto edge = static_cast<std::uint32_t>(engine() % graph->edges().size());
      if (round % 3 == 2) {
        planner.open(edge);
      } else {
        planner.close(edge);
      }
      const std::uint32_t from = node();
      const std::uint32_t to = node();
      const Route route = planner.find(from, to);
      const double cost = planner.costs_from(from)[to];
      if (route.status == RouteStatus::kFound) {
        EXPECT_NEAR(route.cost, cost, 1e-9 * (1 + cost));
        expect_valid(route, *graph, from, to);
        for (const std::uint32_t used : route.edges) {
          EXPECT_FALSE(planner.is_closed(used));
        }
      } else {
        EXPECT_EQ(cost, std::numeric_limits<double>::infinity());
      }
    }
  }
}

TEST(RoutePlanner, LandmarksSpareWork) {
  const auto graph = blocks(60, 5);
  RoutePlanner with(graph, cost_of_file(), 16);
  RoutePlanner without(graph, cost_of_file(), 0);
  std::size_t few = 0;
  std::size_t many = 0;
  for (std::uint32_t i = 0; i < 50; ++i) {
    const std::uint32_t from = i * 71 % 3600;
    const std::uint32_t to = (i * 1373 + 500) % 3600;
    EXPECT_NEAR(with.find(from, to).cost, without.find(from, to).cost, 1e-6);
    few += with.expanded();
    many += without.expanded();
  }
  EXPECT_LT(5 * few, many);
}

TEST(RoutePlanner, ClosedUntilItsTimeComes) {
  const auto graph = std::make_shared<const RouteGraph>(
      std::vector<RouteNode>{{.id = 1}, {.id = 2, .position = {5, 0}}},
      std::vector<RouteEdge>{{.id = 3, .from = 0, .to = 1, .speed = 2, .closed_until = 100}});
  RoutePlanner planner(graph, time_cost(1));
  EXPECT_EQ(planner.find(0, 1).status, RouteStatus::kNoWay);
  planner.set_time(99);
  EXPECT_EQ(planner.find(0, 1).status, RouteStatus::kNoWay);
  planner.set_time(100);
  EXPECT_DOUBLE_EQ(planner.find(0, 1).cost, 2.5);
  EXPECT_EQ(planner.find(1, 0).status, RouteStatus::kNoWay);
  EXPECT_TRUE(planner.find(1, 1).edges.empty());
  EXPECT_THROW((void)planner.find(0, 2), std::invalid_argument);
}

TEST(RoutePlanner, AlternativesDifferAndLeaveCostsAlone) {
  const auto graph = blocks(15, 3);
  RoutePlanner planner(graph, cost_of_file());
  const auto routes = planner.alternatives(0, 224, 3);
  ASSERT_GE(routes.size(), 2U);
  for (const Route& route : routes) {
    expect_valid(route, *graph, 0, 224);
    EXPECT_LE(route.cost, 1.5 * routes.front().cost);
  }
  EXPECT_NE(routes[0].edges, routes[1].edges);
  EXPECT_EQ(planner.find(0, 224).cost, routes.front().cost);
}

TEST(RoutePlanner, RefusesBadCosts) {
  const auto graph = blocks(3, 1);
  EXPECT_THROW(RoutePlanner(graph, [](const RouteGraph&, std::uint32_t) { return -1.0; }),
               std::invalid_argument);
  EXPECT_THROW(RoutePlanner(nullptr, length_cost()), std::invalid_argument);
  RoutePlanner empty(std::make_shared<const RouteGraph>(), length_cost());
  EXPECT_THROW((void)empty.find(0, 0), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::navigation
