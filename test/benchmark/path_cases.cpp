// SPDX-License-Identifier: Apache-2.0
#include "path_cases.hpp"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <vector>

#include "ompl_paths.hpp"
#include "pipescout/navigation_study/planning_score.hpp"

namespace pipescout::benchmarks {
namespace {

using navigation::PlanStatus;
using navigation_study::PathSample;

constexpr double kPercent = 100;
constexpr double kMilliseconds = 1e3;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// s, of the processor for this thread: what other programs take does not count.
double work() {
  timespec time{};
  (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  constexpr double kNanosecond = 1e-9;
  return static_cast<double>(time.tv_sec) + kNanosecond * static_cast<double>(time.tv_nsec);
}

double median(std::vector<double> values) {
  if (values.empty()) {
    return std::nan("");
  }
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// What a planner did on all queries of a map.
struct Tally {
  double found = 0;
  std::vector<double> first;  ///< s; of a query without a path: the deadline
};

class Comparison {
 public:
  Comparison(const navigation::OccupancyGrid& grid, const PathCases& cases)
      : grid_(grid),
        cases_(cases),
        planner_(navigation_study::shortest_path_planner(grid, robot_)),
        ompl_(grid, robot_.footprint, robot_.turning_radius) {}

  void query(statistics::Draw& draw, Figures& figures, const std::string& name, int number) {
    const auto start = navigation_study::draw_free_pose(draw, grid_, robot_.footprint);
    const auto goal = navigation_study::draw_free_pose(draw, grid_, robot_.footprint);
    const PathSample sample =
        navigation_study::score_path(planner_, robot_, start, goal, cases_.deadline, {now, work});
    const bool found = sample.status == PlanStatus::kFound;
    add(ours_, found ? sample.first : cases_.deadline, cases_.deadline);
    overrun_ = std::max(overrun_, sample.overrun);
    broken_ += sample.curvature_kept && sample.goal_met && sample.free ? 0 : 1;
    nlohmann::json row{{"case", name + " " + std::to_string(number + 1)},
                       {"straight_m", distance(start, goal)},
                       {"status", std::string(text_of(sample.status))},
                       {"first_ms", kMilliseconds * sample.first},
                       {"length_m", sample.length}};
    double best = INFINITY;
    const auto seed = static_cast<std::uint32_t>(number + 1);
    for (const bool rrt : {true, false}) {
      const auto peer =
          ompl_.plan(rrt ? OmplPaths::Algorithm::kRrtStar : OmplPaths::Algorithm::kBitStar, start,
                     goal, cases_.peer_seconds, seed);
      add(rrt ? rrt_star_ : bit_star_, peer.first, cases_.peer_deadline);
      best = std::min(best, peer.length);
      row[rrt ? "rrt_star_first_ms" : "bit_star_first_ms"] =
          std::isfinite(peer.first) ? kMilliseconds * peer.first : -1;
      row[rrt ? "rrt_star_length_m" : "bit_star_length_m"] =
          std::isfinite(peer.length) ? peer.length : -1;
    }
    if (found && std::isfinite(best)) {
      cost_ratios_.push_back(sample.length / best);
    }
    figures.add_row(std::move(row));
  }

  void report(Figures& figures, const std::string& name) const {
    constexpr double kTimeRatio = 0.1;
    constexpr double kCostRatio = 1.03;
    constexpr double kOverrun = 5;  // ms
    using Bound = Figures::Bound;
    const double theirs = std::max(rrt_star_.found, bit_star_.found);
    figures.add("lattice_success_percent_" + name, percent(ours_.found), Bound::kAtLeast,
                percent(theirs));
    figures.add("rrt_star_success_percent_" + name, percent(rrt_star_.found));
    figures.add("bit_star_success_percent_" + name, percent(bit_star_.found));
    const double first = median(ours_.first);
    const double first_of_theirs = std::min(median(rrt_star_.first), median(bit_star_.first));
    figures.add("lattice_time_ratio_" + name, first / first_of_theirs, Bound::kAtMost, kTimeRatio);
    figures.add("lattice_first_ms_" + name, kMilliseconds * first);
    figures.add("ompl_first_ms_" + name, kMilliseconds * first_of_theirs);
    if (!cost_ratios_.empty()) {
      figures.add("lattice_cost_ratio_" + name, median(cost_ratios_), Bound::kAtMost, kCostRatio);
    }
    figures.add("lattice_deadline_overrun_ms_" + name, kMilliseconds * std::max(0.0, overrun_),
                Bound::kAtMost, kOverrun);
    figures.add("lattice_violations_" + name, broken_, Bound::kAtMost, 0);
  }

 private:
  static void add(Tally& tally, double first, double deadline) {
    tally.found += first < deadline ? 1 : 0;
    tally.first.push_back(std::min(first, deadline));
  }
  [[nodiscard]] double percent(double found) const { return kPercent * found / cases_.queries; }

  const navigation::OccupancyGrid& grid_;
  PathCases cases_;
  navigation_study::StudyRobot robot_;
  navigation::LatticePlanner planner_;
  OmplPaths ompl_;
  Tally ours_;
  Tally rrt_star_;
  Tally bit_star_;
  std::vector<double> cost_ratios_;
  double overrun_ = 0;
  double broken_ = 0;
};

}  // namespace

void compare_paths(Figures& figures, const std::string& name, const navigation::OccupancyGrid& grid,
                   const PathCases& cases) {
  constexpr std::uint64_t kPoses = 3;
  statistics::Draw draw(cases.seed, kPoses);
  Comparison comparison(grid, cases);
  for (int i = 0; i < cases.queries; ++i) {
    comparison.query(draw, figures, name, i);
    std::cerr << "paths, " << name << ": " << i + 1 << " of " << cases.queries << '\n';
  }
  comparison.report(figures, name);
}

}  // namespace pipescout::benchmarks
