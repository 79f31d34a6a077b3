// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "map_picture.hpp"
#include "pipescout/command_line/command.hpp"
#include "pipescout/command_line/results.hpp"
#include "pipescout/map_files/grid_file.hpp"
#include "pipescout/map_files/route_graph_file.hpp"

namespace pipescout::map {
namespace {

using command_line::Action;
using command_line::kExitError;
using command_line::kExitOk;
using navigation::Footprint;

struct Arguments {
  std::string grid;
  std::string graph;
  std::string out;
  std::vector<double> footprint{1.0, 0.4, 0.8};
  int scale = 4;
};

MapPicture read_map(const Arguments& arguments) {
  std::vector<std::string> remarks;
  MapPicture picture{{}, read_grid(arguments.grid, remarks), std::nullopt, {}};
  if (!arguments.graph.empty()) {
    const auto footprint = Footprint::rectangle(arguments.footprint[0], arguments.footprint[1],
                                                arguments.footprint[2]);
    navigation::HybridMap map{read_route_graph(arguments.graph, remarks), std::move(picture.grid)};
    picture.problems = check_map(map, footprint);
    picture.graph = std::move(map.graph);
    picture.grid = std::move(map.grid);
  }
  picture.remarks = std::move(remarks);
  return picture;
}

/// "12 cells", with the share that they are of all.
std::string share(const MapPicture& picture, navigation::CellState state) {
  constexpr double kPercent = 100;
  const auto& cells = picture.grid.cells();
  const auto count = std::count(cells.begin(), cells.end(), state);
  return std::to_string(std::lround(kPercent * static_cast<double>(count) /
                                    static_cast<double>(cells.size()))) +
         " %";
}

void print_map(const MapPicture& picture) {
  using navigation::CellState;
  for (const auto& remark : picture.remarks) {
    std::cerr << "warning: " << remark << '\n';
  }
  const auto& grid = picture.grid;
  std::cout << "grid: " << grid.width() << " x " << grid.height() << " cells of "
            << grid.resolution() << " m; free " << share(picture, CellState::kFree) << ", occupied "
            << share(picture, CellState::kOccupied) << ", unknown "
            << share(picture, CellState::kUnknown) << '\n';
  if (picture.graph) {
    std::cout << "graph: " << picture.graph->nodes().size() << " nodes, "
              << picture.graph->edges().size() << " edges\n";
  }
  for (const auto& problem : picture.problems) {
    std::cout << "problem: " << problem.text << '\n';
  }
  std::cout << (picture.problems.empty() ? "no problems"
                                         : std::to_string(picture.problems.size()) + " problems")
            << '\n';
}

void add_inputs(CLI::App& command, const std::shared_ptr<Arguments>& arguments) {
  command.add_option("grid", arguments->grid, "Occupancy grid: YAML file of map_server")
      ->required()
      ->check(CLI::ExistingFile);
  command
      .add_option("--graph", arguments->graph, "Route graph: GeoJSON file of Nav2's route server")
      ->check(CLI::ExistingFile);
  command
      .add_option("--footprint", arguments->footprint,
                  "Rectangle of the robot that drives the edges: m before its origin, m behind it, "
                  "and width in m")
      ->expected(3)
      ->capture_default_str();
}

void add_commands(CLI::App& app, Action& action) {
  app.require_subcommand(1);
  auto arguments = std::make_shared<Arguments>();
  auto* check = app.add_subcommand(
      "check", "Say what keeps a robot from using a map; exits 1 if something does");
  add_inputs(*check, arguments);
  check->callback([=, &action] {
    action = [=] {
      const MapPicture picture = read_map(*arguments);
      print_map(picture);
      return picture.problems.empty() ? kExitOk : kExitError;
    };
  });
  auto* show = app.add_subcommand("show", "Draw grid, graph and problems into a picture");
  add_inputs(*show, arguments);
  show->add_option("--out", arguments->out, "Picture to write, for example map.png")->required();
  constexpr int kLargestScale = 100;
  show->add_option("--scale", arguments->scale, "Pixels along the edge of a cell")
      ->check(CLI::Range(1, kLargestScale))
      ->capture_default_str();
  show->callback([=, &action] {
    action = [=] {
      command_line::require_new_file(arguments->out);
      const MapPicture picture = read_map(*arguments);
      print_map(picture);
      draw_map(arguments->out, picture, arguments->scale);
      std::cout << arguments->out << '\n';
      return kExitOk;
    };
  });
}

}  // namespace
}  // namespace pipescout::map

int main(int argc, char** argv) {
  return pipescout::command_line::command_main(PIPESCOUT_SUMMARY, "pipescout map",
                                               pipescout::map::add_commands, argc, argv);
}
