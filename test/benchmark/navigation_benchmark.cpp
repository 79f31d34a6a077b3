// SPDX-License-Identifier: Apache-2.0
// Routes compared with Dijkstra's algorithm of the Boost Graph Library, in turns on the same
// queries:
//
//   navigation_benchmark [--json FILE] [--queries N]

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <string>
#include <vector>

#include "boost_routes.hpp"
#include "figures.hpp"
#include "pipescout/navigation_study/drawn_maps.hpp"
#include "pipescout/planning/route_planner.hpp"

namespace pipescout::benchmarks {
namespace {

constexpr std::uint64_t kSeed = 1;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void compare_routes(Figures& figures, const std::string& name, std::uint32_t side, int queries) {
  constexpr std::uint64_t kQueries = 2;
  constexpr double kRounding = 1e-9;
  constexpr double kMilliseconds = 1e3;
  constexpr double kTarget = 5;
  const auto graph = navigation_study::draw_roads(kSeed, side);
  navigation::RoutePlanner planner(graph, navigation::cost_of_file());
  BoostRoutes boost(*graph);
  statistics::Draw draw(kSeed, kQueries);
  std::vector<double> ours;
  std::vector<double> theirs;
  double wrong = 0;
  for (int i = 0; i < queries; ++i) {
    const auto from = static_cast<std::uint32_t>(draw.index(graph->nodes().size()));
    const auto to = static_cast<std::uint32_t>(draw.index(graph->nodes().size()));
    const double begin = now();
    const navigation::Route route = planner.find(from, to);
    const double between = now();
    const double expected = boost.cost(from, to);
    theirs.push_back(now() - between);
    ours.push_back(between - begin);
    const bool found = route.status == navigation::RouteStatus::kFound;
    const bool same = found ? std::abs(route.cost - expected) <= kRounding * (1 + expected)
                            : std::isinf(expected);
    wrong += same ? 0 : 1;
  }
  figures.add("route_speedup_" + name, median(theirs) / median(ours), Figures::Bound::kAtLeast,
              kTarget);
  figures.add("route_costs_wrong_" + name, wrong, Figures::Bound::kAtMost, 0);
  figures.add("route_ms_" + name, kMilliseconds * median(ours));
  figures.add("route_boost_ms_" + name, kMilliseconds * median(theirs));
}

}  // namespace
}  // namespace pipescout::benchmarks

int main(int argc, char** argv) {
  using namespace pipescout::benchmarks;
  CLI::App app("Routes compared with the Boost Graph Library");
  std::string json;
  int queries = 1000;
  app.add_option("--json", json, "Write the figures to this file");
  app.add_option("--queries", queries, "On each graph")->check(CLI::Range(1, 100000));
  CLI11_PARSE(app, argc, argv);
  try {
    Figures figures;
    figures.add_seed(kSeed);
    compare_routes(figures, "10k", 100, queries);
    compare_routes(figures, "100k", 316, queries);
    compare_routes(figures, "1m", 1000, queries);
    figures.print(std::cout);
    if (!json.empty()) {
      figures.write_json(json);
    }
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  return 0;
}
