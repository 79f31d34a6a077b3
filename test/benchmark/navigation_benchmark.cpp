// SPDX-License-Identifier: Apache-2.0
// Routes compared with Dijkstra's algorithm of the Boost Graph Library, and paths compared with the
// Open Motion Planning Library, in turns on the same queries:
//
//   navigation_benchmark [--json FILE] [--queries N] [--path-queries N] [--peer-seconds S]
//                        [--floor IMAGE] [--seed N]

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <string>
#include <vector>

#include "boost_routes.hpp"
#include "figures.hpp"
#include "path_cases.hpp"
#include "pipescout/map_files/grid_file.hpp"
#include "pipescout/navigation_study/drawn_maps.hpp"
#include "pipescout/planning/route_planner.hpp"

namespace pipescout::benchmarks {
namespace {

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

struct Arguments {
  std::string json;
  std::string floor;
  int queries = 1000;
  PathCases paths{};
};

void compare_routes(Figures& figures, const std::string& name, std::uint32_t side,
                    const Arguments& arguments) {
  constexpr std::uint64_t kQueries = 2;
  constexpr double kRounding = 1e-9;
  constexpr double kMilliseconds = 1e3;
  constexpr double kTarget = 5;
  const auto graph = navigation_study::draw_roads(arguments.paths.seed, side);
  navigation::RoutePlanner planner(graph, navigation::cost_of_file());
  BoostRoutes boost(*graph);
  statistics::Draw draw(arguments.paths.seed, kQueries);
  std::vector<double> ours;
  std::vector<double> theirs;
  double wrong = 0;
  for (int i = 0; i < arguments.queries; ++i) {
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

void compare_maps(Figures& figures, const Arguments& arguments) {
  constexpr double kFloorResolution = 0.1;  // m, of the offices that Willow Garage's robots mapped
  const std::uint64_t seed = arguments.paths.seed;
  if (arguments.paths.queries == 0) {
    return;
  }
  if (arguments.floor.empty()) {
    std::cerr << "no --floor: nothing is planned on a real one\n";
  } else {
    compare_paths(figures, "floor", read_grid_image(arguments.floor, kFloorResolution),
                  arguments.paths);
  }
  compare_paths(figures, "plant", navigation_study::draw_plant(seed), arguments.paths);
  compare_paths(figures, "maze", navigation_study::draw_maze(seed), arguments.paths);
}

}  // namespace
}  // namespace pipescout::benchmarks

int main(int argc, char** argv) {
  using namespace pipescout::benchmarks;
  CLI::App app("Routes compared with the Boost Graph Library, paths with OMPL");
  Arguments arguments;
  constexpr int kMostQueries = 100'000;
  app.add_option("--json", arguments.json, "Write the figures to this file");
  app.add_option("--queries", arguments.queries, "Routes on each graph; 0: no graph")
      ->check(CLI::Range(0, kMostQueries));
  app.add_option("--path-queries", arguments.paths.queries, "Paths on each map; 0: no map")
      ->check(CLI::Range(0, kMostQueries));
  app.add_option("--peer-seconds", arguments.paths.peer_seconds,
                 "Time of each peer for a path; its best path then is compared")
      ->check(CLI::Range(arguments.paths.peer_deadline, 1e3));
  app.add_option("--floor", arguments.floor, "Image of a real floor of 0.1 m (PGM, as of ROS 1)")
      ->check(CLI::ExistingFile);
  app.add_option("--seed", arguments.paths.seed, "Of graphs, maps and queries");
  CLI11_PARSE(app, argc, argv);
  try {
    Figures figures;
    figures.add_seed(arguments.paths.seed);
    if (arguments.queries > 0) {
      compare_routes(figures, "10k", 100, arguments);
      compare_routes(figures, "100k", 316, arguments);
      compare_routes(figures, "1m", 1000, arguments);
    }
    compare_maps(figures, arguments);
    figures.print(std::cout);
    if (!arguments.json.empty()) {
      figures.write_json(arguments.json);
    }
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  return 0;
}
