// SPDX-License-Identifier: Apache-2.0
#include <time.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "each_seed.hpp"
#include "figure_rows.hpp"
#include "navigation_missions.hpp"
#include "pipescout/map_files/grid_file.hpp"
#include "pipescout/navigation_study/planning_score.hpp"
#include "pipescout/planning/route_planner.hpp"
#include "reproduce.hpp"
#include "stage_progress.hpp"

namespace pipescout::reproduce {
namespace {

using navigation::PlanStatus;
using navigation_study::PathSample;
using navigation_study::StudyRobot;

/// s, of the processor for this thread: what other programs take does not count.
double work_clock() {
  timespec time{};
  (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  constexpr double kNanosecond = 1e-9;
  return static_cast<double>(time.tv_sec) + kNanosecond * static_cast<double>(time.tv_nsec);
}

double middle(std::vector<double> values) {
  if (values.empty()) {
    return 0;
  }
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

class Navigation {
 public:
  Navigation(const ReproduceOptions& options, const NavigationExtent& extent, std::ostream& out)
      : extent_(extent),
        data_(options.data),
        out_(out),
        seeds_(seeds_of(options, options.seeds)),
        rows_(result_, out),
        progress_(options) {
    result_.seeds = seeds_;
  }

  Reproduction run() {
    add_routes();
    add_tours();
    add_floor();
    add_paths("maze of aisles of 3 m", "maze", navigation_study::draw_maze);
    add_paths("plant of 300 x 200 m", "plant", navigation_study::draw_plant);
    add_navigation_missions(seeds_, extent_, rows_, progress_);
    return std::move(result_);
  }

 private:
  /// One after the other: times are measured.
  void add_routes() {
    const auto graph = navigation_study::draw_roads(seeds_.front(), extent_.road_side);
    navigation::RoutePlanner planner(graph, navigation::cost_of_file());
    navigation::RoutePlanner dijkstra(graph, navigation::cost_of_file(), 0);
    constexpr std::uint64_t kQueries = 20;
    constexpr double kRounding = 1e-9;
    statistics::Draw draw(seeds_.front(), kQueries);
    double wrong = 0;
    double time = 0;
    double time_of_dijkstra = 0;
    for (std::size_t i = 0; i < extent_.routes; ++i) {
      const auto from = static_cast<std::uint32_t>(draw.index(graph->nodes().size()));
      const auto to = static_cast<std::uint32_t>(draw.index(graph->nodes().size()));
      const double begin = work_clock();
      const auto route = planner.find(from, to);
      const double between = work_clock();
      const auto expected = dijkstra.find(from, to);
      time_of_dijkstra += work_clock() - between;
      time += between - begin;
      wrong += route.status != expected.status ||
                       std::abs(route.cost - expected.cost) > kRounding * (1 + expected.cost)
                   ? 1
                   : 0;
    }
    rows_.add_study("Routes, " + std::to_string(graph->nodes().size()) + " nodes, " +
                        std::to_string(extent_.routes) + " queries",
                    {{"costs that are not Dijkstra's", wrong, {}, kNone, "route_costs_wrong"},
                     {"speed over Dijkstra's algorithm in the same planner",
                      time_of_dijkstra / std::max(time, kRounding),
                      {},
                      kLargeIsGood,
                      "route_speedup_own_dijkstra"}});
  }

  void add_tours() {
    auto over = for_each_seed(progress_, "tours", drawn_seeds(seeds_, extent_.tours),
                              navigation_study::score_tour);
    const auto incomplete = static_cast<double>(std::erase(over, 0.0));
    if (over.empty()) {
      throw std::runtime_error("no tour of any drawn plant drives along all its rows");
    }
    rows_.add_study(
        "Tours along all rows of drawn plants, " +
            std::to_string(over.size() + static_cast<std::size_t>(incomplete)),
        {{"tours that leave out a row", incomplete, {}, kNone, "tours_incomplete"},
         {"length over lower bound, median", middle(over), over, at_most(1.10), "tour_over_bound"},
         {"the same, worst",
          *std::max_element(over.begin(), over.end()),
          {},
          kSmallIsGood,
          "tour_over_bound_worst"}});
  }

  void add_floor() {
    constexpr double kResolution = 0.1;  // m
    const std::string folder = data_.empty() ? default_data_folder() : data_;
    const std::filesystem::path image = std::filesystem::path(folder) / "maps" / "willow-full.pgm";
    if (!std::filesystem::exists(image)) {
      out_ << "NOT PLANNED on a real floor: no maps/willow-full.pgm\n  in the folder of --data, "
              "$PIPESCOUT_SHARED_DATA or ../shared/data.\n\n";
      return;
    }
    const auto grid = read_grid_image(image, kResolution);
    add_paths("real floor, offices", "floor", [&](std::uint64_t /*seed*/) { return grid; });
  }

  template <typename Draw>
  void add_paths(const std::string& what, const std::string& name, const Draw& draw_map) {
    const StudyRobot robot;
    std::vector<double> first;
    std::vector<double> first_far;
    std::vector<double> bounds;
    std::vector<double> again;
    std::vector<double> before;
    double found = 0;
    double count = 0;
    double broken = 0;
    double overrun = 0;
    progress_.begin("paths, " + name, seeds_.size());
    for (const std::uint64_t seed : seeds_) {
      const auto grid = draw_map(seed);
      auto planner = navigation_study::shortest_path_planner(grid, robot);
      constexpr std::uint64_t kPoses = 21;
      statistics::Draw draw(seed, kPoses);
      for (std::size_t i = 0; i < extent_.paths; ++i) {
        const auto start = navigation_study::draw_free_pose(draw, grid, robot.footprint);
        const auto goal = navigation_study::draw_free_pose(draw, grid, robot.footprint);
        const PathSample sample = navigation_study::score_path(
            planner, robot, start, goal, extent_.deadline, {work_clock, work_clock});
        add_sample(sample, navigation::distance(start, goal), first, first_far);
        found += sample.status == PlanStatus::kFound ? 1 : 0;
        broken += sample.curvature_kept && sample.goal_met && sample.free ? 0 : 1;
        overrun = std::max(overrun, sample.overrun);
        if (sample.status == PlanStatus::kFound) {
          bounds.push_back(sample.suboptimality);
        }
        ++count;
        const auto replan = navigation_study::score_replan(planner, robot, start, goal,
                                                           extent_.deadline, draw, work_clock);
        if (replan.found) {
          before.push_back(replan.first);
          again.push_back(replan.again);
        }
        broken += replan.free ? 0 : 1;
      }
      progress_.step();
    }
    progress_.end();
    constexpr double kMilliseconds = 1e3;
    std::vector<Measure> measures{{"found by the deadline, %",
                                   100 * found / count,
                                   {},
                                   kLargeIsGood,
                                   "lattice_success_percent_" + name},
                                  {"paths that break curvature, goal pose or clearance",
                                   broken,
                                   {},
                                   kNone,
                                   "lattice_violations_" + name},
                                  {"first path, ms, median",
                                   kMilliseconds * middle(first),
                                   {},
                                   kSmallIsGood,
                                   "lattice_first_ms_" + name},
                                  {"worked on after the deadline, ms, worst",
                                   kMilliseconds * std::max(0.0, overrun),
                                   {},
                                   at_most(5),
                                   "lattice_deadline_overrun_ms_" + name},
                                  {"length over its lower bound, median",
                                   middle(bounds),
                                   {},
                                   kSmallIsGood,
                                   "lattice_suboptimality_" + name}};
    if (!again.empty()) {
      measures.push_back({"planned around a new obstacle: time over that of the first path",
                          middle(again) / middle(before),
                          {},
                          at_most(0.05),
                          "lattice_replan_ratio_" + name});
    }
    if (!first_far.empty()) {
      measures.push_back({"first path over 65 to 85 m, ms, median",
                          kMilliseconds * middle(first_far),
                          {},
                          at_most(30),
                          "lattice_75m_first_ms_" + name});
    }
    rows_.add_study(
        "Lattice planner, " + what + ", " + std::to_string(static_cast<int>(count)) + " queries",
        measures);
  }

  static void add_sample(const PathSample& sample, double straight, std::vector<double>& first,
                         std::vector<double>& first_far) {
    constexpr double kNear = 65;  // m
    constexpr double kFar = 85;
    if (sample.status != PlanStatus::kFound) {
      return;
    }
    first.push_back(sample.first);
    if (straight > kNear && straight < kFar) {
      first_far.push_back(sample.first);
    }
  }

  NavigationExtent extent_;
  std::string data_;
  std::ostream& out_;
  std::vector<std::uint64_t> seeds_;
  Reproduction result_;
  FigureRows rows_;
  StageProgress progress_;
};

}  // namespace

Reproduction reproduce_navigation(const ReproduceOptions& options, std::ostream& out) {
  return reproduce_navigation(options, NavigationExtent{}, out);
}

Reproduction reproduce_navigation(const ReproduceOptions& options, const NavigationExtent& extent,
                                  std::ostream& out) {
  return Navigation(options, extent, out).run();
}

}  // namespace pipescout::reproduce
