// SPDX-License-Identifier: Apache-2.0
#include "pipescout/planning/tour.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>

namespace pipescout::navigation {
namespace {

/// `count` rows of 100 m between two roads, 20 m apart; edges 2 i and 2 i + 1 are row i.
std::shared_ptr<const RouteGraph> rows_of_collectors(std::uint32_t count) {
  std::vector<RouteNode> nodes;
  std::vector<RouteEdge> edges;
  const auto join = [&](std::uint32_t a, std::uint32_t b) {
    const auto id = static_cast<std::int64_t>(edges.size());
    edges.push_back({.id = id, .from = a, .to = b});
    edges.push_back({.id = id + 1, .from = b, .to = a});
  };
  for (std::uint32_t i = 0; i < count; ++i) {
    nodes.push_back({.id = 2 * i, .position = {20.0 * i, 0}});
    nodes.push_back({.id = 2 * i + 1, .position = {20.0 * i, 100}});
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    join(2 * i, 2 * i + 1);
  }
  for (std::uint32_t i = 0; i + 1 < count; ++i) {
    join(2 * i, 2 * i + 2);
    join(2 * i + 1, 2 * i + 3);
  }
  return std::make_shared<const RouteGraph>(std::move(nodes), std::move(edges));
}

std::vector<std::uint32_t> all_rows(std::uint32_t count) {
  std::vector<std::uint32_t> edges(2 * count);
  std::iota(edges.begin(), edges.end(), 0);
  return edges;
}

const auto kNever = [] { return false; };

void expect_tour(const Tour& tour, RoutePlanner& planner, std::uint32_t start,
                 const std::vector<TourRow>& rows) {
  ASSERT_EQ(tour.status, TourStatus::kFound);
  std::uint32_t at = start;
  double cost = 0;
  for (const std::uint32_t edge : tour.edges) {
    EXPECT_EQ(planner.graph().edges()[edge].from, at);
    at = planner.graph().edges()[edge].to;
    cost += planner.cost(edge);
  }
  EXPECT_EQ(at, start);
  EXPECT_NEAR(cost, tour.cost, 1e-6);
  EXPECT_GE(tour.cost, tour.lower_bound - 1e-6);
  for (const TourRow& row : rows) {
    EXPECT_TRUE(std::any_of(tour.edges.begin(), tour.edges.end(), [&](std::uint32_t edge) {
      return edge == row.edge || edge == row.opposite;
    }));
  }
}

TEST(Tour, BackAndForthIsTheBest) {
  RoutePlanner planner(rows_of_collectors(6), length_cost());
  const auto rows = tour_rows(planner.graph(), all_rows(6), RowSides::kOne);
  ASSERT_EQ(rows.size(), 6U);
  const Tour tour = plan_tour(planner, 0, rows, kNever);
  expect_tour(tour, planner, 0, rows);
  // Six rows, five times to the next, and back along the road.
  EXPECT_NEAR(tour.cost, 600 + 100 + 100, 1e-6);
  EXPECT_LE(tour.cost, 1.15 * tour.lower_bound);
}

TEST(Tour, BothSidesAreThereAndBack) {
  RoutePlanner planner(rows_of_collectors(4), length_cost());
  const auto rows = tour_rows(planner.graph(), all_rows(4), RowSides::kBoth);
  ASSERT_EQ(rows.size(), 8U);
  const Tour tour = plan_tour(planner, 0, rows, kNever);
  expect_tour(tour, planner, 0, rows);
  EXPECT_NEAR(tour.cost, 800 + 120, 1e-6);
}

TEST(Tour, OneSidedCamerasNeedTheDirectionsThatAreGiven) {
  RoutePlanner planner(rows_of_collectors(3), length_cost());
  // The first row there and back, and the last one only back.
  const std::vector<std::uint32_t> given{0, 1, 5, 0};
  const auto rows = tour_rows(planner.graph(), given, RowSides::kAsGiven);
  ASSERT_EQ(rows.size(), 3U);
  const Tour tour = plan_tour(planner, 0, rows, kNever);
  for (const std::uint32_t edge : {0U, 1U, 5U}) {
    EXPECT_EQ(std::ranges::count(tour.edges, edge), 1) << edge;
  }
}

TEST(Tour, ClosedRowsAreNamed) {
  RoutePlanner planner(rows_of_collectors(3), length_cost());
  const auto rows = tour_rows(planner.graph(), all_rows(3), RowSides::kOne);
  planner.close(2);
  expect_tour(plan_tour(planner, 0, rows, kNever), planner, 0, rows);
  planner.close(3);
  const Tour tour = plan_tour(planner, 0, rows, kNever);
  EXPECT_EQ(tour.status, TourStatus::kRowUnreachable);
  ASSERT_EQ(tour.unreachable.size(), 1U);
  EXPECT_EQ(tour.unreachable[0].edge, 2U);
}

TEST(Tour, StopsWhenToldAndNeedsNoRows) {
  RoutePlanner planner(rows_of_collectors(8), length_cost());
  const auto rows = tour_rows(planner.graph(), all_rows(8), RowSides::kOne);
  expect_tour(plan_tour(planner, 5, rows, [] { return true; }), planner, 5, rows);
  EXPECT_TRUE(plan_tour(planner, 5, {}, kNever).edges.empty());
  EXPECT_THROW((void)tour_rows(planner.graph(), std::vector<std::uint32_t>{1000}, RowSides::kOne),
               std::invalid_argument);
}

TEST(Tour, ManyRowsAreBoundedByTrees) {
  RoutePlanner planner(rows_of_collectors(20), length_cost());
  const auto rows = tour_rows(planner.graph(), all_rows(20), RowSides::kOne);
  const Tour tour = plan_tour(planner, 0, rows, kNever);
  expect_tour(tour, planner, 0, rows);
  EXPECT_GE(tour.lower_bound, 0.97 * tour.cost);
}

/// Two fields far apart: matchings of ends would leave the way between them out.
TEST(Tour, TheBoundCountsTheWayBetweenFields) {
  std::vector<RouteNode> nodes;
  std::vector<RouteEdge> edges;
  const auto join = [&](std::uint32_t a, std::uint32_t b) {
    const auto id = static_cast<std::int64_t>(edges.size());
    edges.push_back({.id = id, .from = a, .to = b});
    edges.push_back({.id = id + 1, .from = b, .to = a});
  };
  for (const double x : {0.0, 1000.0}) {
    const auto first = static_cast<std::uint32_t>(nodes.size());
    for (std::uint32_t i = 0; i < 4; ++i) {
      nodes.push_back({.id = first + i, .position = {x + 20 * (i / 2), 100.0 * (i % 2)}});
    }
    join(first, first + 1);
    join(first + 2, first + 3);
    join(first, first + 2);
    join(first + 1, first + 3);
  }
  join(2, 4);
  RoutePlanner planner(std::make_shared<const RouteGraph>(nodes, edges), length_cost());
  const std::vector<std::uint32_t> driven{0, 2, 8, 10};
  const auto rows = tour_rows(planner.graph(), driven, RowSides::kOne);
  const Tour tour = plan_tour(planner, 0, rows, kNever);
  expect_tour(tour, planner, 0, rows);
  EXPECT_NEAR(tour.cost, 400 + 2 * 980 + 80, 1e-6);
  EXPECT_NEAR(tour.lower_bound, tour.cost, 1e-6);
}

}  // namespace
}  // namespace pipescout::navigation
