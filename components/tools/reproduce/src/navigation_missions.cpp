// SPDX-License-Identifier: Apache-2.0
#include "navigation_missions.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <ctime>
#include <functional>
#include <numbers>
#include <string>

#include "each_seed.hpp"
#include "pipescout/move_base/global_planner.hpp"
#include "pipescout/navigation_study/mission.hpp"
#include "pipescout/navigation_study/primitive_replay.hpp"
#include "pipescout/statistics/draw.hpp"

namespace pipescout::reproduce {
namespace {

using navigation_study::MissionScore;
using navigation_study::MissionSettings;

constexpr double kMissionMilliseconds = 1e3;
constexpr double kMissionDegrees = 180 / std::numbers::pi;

/// s, processor time of this thread: other seeds are driven at the same time.
double processor_time() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  constexpr double kNanosecond = 1e-9;
  return static_cast<double>(time.tv_sec) + kNanosecond * static_cast<double>(time.tv_nsec);
}

double worst_mission(const std::vector<MissionScore>& scores,
                     const std::function<double(const MissionScore&)>& value) {
  double result = 0;
  for (const MissionScore& score : scores) {
    result = std::max(result, value(score));
  }
  return result;
}

double mission_quantile(std::vector<double> values, double share) {
  if (values.empty()) {
    return 0;
  }
  std::sort(values.begin(), values.end());
  const auto last = static_cast<double>(values.size() - 1);
  return values[static_cast<std::size_t>(std::lround(share * last))];
}

/// Of the missions that reached their goal.
double goal_quantile(const std::vector<MissionScore>& scores, double share,
                     const std::function<double(const MissionScore&)>& value) {
  std::vector<double> values;
  for (const MissionScore& score : scores) {
    if (score.reached) {
      values.push_back(value(score));
    }
  }
  return mission_quantile(std::move(values), share);
}

void add_pose_missions(const std::vector<std::uint64_t>& seeds, FigureRows& rows,
                       StageProgress& progress) {
  const auto scores = for_each_seed(progress, "missions", seeds, [](std::uint64_t seed) {
    return navigation_study::run_mission({}, seed, processor_time);
  });
  double collisions = 0;
  double reached = 0;
  std::vector<double> typical;
  for (const MissionScore& score : scores) {
    collisions += score.collisions > 0 ? 1 : 0;
    reached += score.reached ? 1 : 0;
    typical.push_back(score.typical_cycle_time);
  }
  const auto distance = [](const MissionScore& score) { return score.goal_distance; };
  const auto heading = [](const MissionScore& score) {
    return kMissionDegrees * score.goal_heading;
  };
  rows.add_study(
      "Missions in drawn plants with moving obstacles, " + std::to_string(scores.size()),
      {{"missions with a contact, checked at 1 kHz", collisions, {}, kNone, "collisions"},
       {"goals reached, %",
        100 * reached / static_cast<double>(scores.size()),
        {},
        at_least(99),
        "reached_percent"},
       {"distance from the goal, m, 95 %",
        goal_quantile(scores, 0.95, distance),
        {},
        kSmallIsGood,
        "goal_distance_p95_m"},
       {"distance from the goal, m, worst",
        goal_quantile(scores, 1, distance),
        {},
        at_most(0.10),
        "goal_distance_worst_m"},
       {"heading from the goal's, degrees, worst",
        goal_quantile(scores, 1, heading),
        {},
        at_most(3),
        "goal_heading_worst_deg"},
       {"between two commands, ms, worst",
        kMissionMilliseconds *
            worst_mission(scores, [](const MissionScore& score) { return score.gap; }),
        {},
        at_most(100),
        "command_gap_ms"},
       {"control cycle, ms of processor time, median",
        kMissionMilliseconds * mission_quantile(typical, 0.5),
        {},
        at_most(1),
        "control_cycle_ms"},
       {"the same, worst",
        kMissionMilliseconds *
            worst_mission(scores, [](const MissionScore& score) { return score.cycle_time; }),
        {},
        kSmallIsGood,
        "control_cycle_worst_ms"}});
}

/// With a localisation as GPS and an IMU give it, instead of one by landmarks. What the robot takes
/// for its goal is then as far from it as that errs.
void add_gps_missions(const std::vector<std::uint64_t>& seeds, const NavigationExtent& extent,
                      FigureRows& rows, StageProgress& progress) {
  const MissionSettings usual{.position_sigma = 0.2, .heading_sigma = 0.01};
  const auto missions = for_each_seed(
      progress, "missions by GPS", drawn_seeds(seeds, extent.missions), [&](std::uint64_t seed) {
        return navigation_study::run_mission(usual, seed, processor_time);
      });
  const auto tours = for_each_seed(
      progress, "tours by GPS", drawn_seeds(seeds, extent.inspections), [&](std::uint64_t seed) {
        MissionSettings settings = usual;
        settings.time_limit = 3000;
        settings.tour = true;
        return navigation_study::run_mission(settings, seed, processor_time);
      });
  double contacts = 0;
  double reached = 0;
  for (const MissionScore& score : missions) {
    contacts += score.collisions > 0 ? 1 : 0;
    reached += score.reached ? 1 : 0;
  }
  double tour_contacts = 0;
  double completed = 0;
  double seen = 0;
  double metres = 0;
  for (const MissionScore& score : tours) {
    tour_contacts += score.collisions > 0 ? 1 : 0;
    completed += score.reached ? 1 : 0;
    seen += score.seen_percent * score.pipe_metres;
    metres += score.pipe_metres;
  }
  rows.add_study("The same with a localisation that errs by 0.2 m, " +
                     std::to_string(missions.size()) + " missions, " +
                     std::to_string(tours.size()) + " tours",
                 {{"missions with a contact", contacts, {}, kNone, "gps_collisions"},
                  {"goals reached, %",
                   100 * reached / static_cast<double>(missions.size()),
                   {},
                   at_least(99),
                   "gps_reached_percent"},
                  {"distance from the goal, m, 95 %",
                   goal_quantile(missions, 0.95,
                                 [](const MissionScore& score) { return score.goal_distance; }),
                   {},
                   kSmallIsGood,
                   "gps_goal_distance_p95_m"},
                  {"tours with a contact", tour_contacts, {}, kNone, "gps_tour_collisions"},
                  {"tours completed, %",
                   100 * completed / static_cast<double>(tours.size()),
                   {},
                   at_least(99),
                   "gps_tour_reached_percent"},
                  {"of the toured metres, seen sharp, %",
                   metres > 0 ? seen / metres : 0,
                   {},
                   at_least(99.5),
                   "gps_pipe_seen_percent"}});
}

void add_primitive_replay(FigureRows& rows) {
  constexpr double kCentimetres = 100;
  const navigation::GlobalPlannerParameters planner;
  const auto replay = navigation_study::replay_primitives(
      navigation::generate_primitives(planner.turning_radius, planner.spacing));
  rows.add_study("Primitives of the lattice driven by the simulated vehicle, " +
                     std::to_string(replay.primitives),
                 {{"end from where the primitive says, cm, worst",
                   kCentimetres * replay.position,
                   {},
                   at_most(1),
                   "primitive_replay_cm"},
                  {"heading from the primitive's, degrees, worst",
                   kMissionDegrees * replay.heading,
                   {},
                   at_most(0.5),
                   "primitive_replay_deg"}});
}

/// One with the usual exposure time, one with twice as much.
void add_inspection_tours(const std::vector<std::uint64_t>& seeds, FigureRows& rows,
                          StageProgress& progress) {
  for (const double factor : {1.0, 2.0}) {
    const auto scores =
        for_each_seed(progress, "tours of inspection", seeds, [&](std::uint64_t seed) {
          MissionSettings settings{.time_limit = 3000, .tour = true};
          settings.exposure *= factor;
          return navigation_study::run_mission(settings, seed, processor_time);
        });
    double seen = 0;
    double metres = 0;
    double collisions = 0;
    double reached = 0;
    double speed = 0;
    for (const MissionScore& score : scores) {
      seen += score.seen_percent * score.pipe_metres;
      metres += score.pipe_metres;
      collisions += score.collisions > 0 ? 1 : 0;
      reached += score.reached ? 1 : 0;
      speed += score.speed / static_cast<double>(scores.size());
    }
    const bool usual = factor == 1;
    const std::string suffix = usual ? "" : "_double_exposure";
    rows.add_study(
        "Tours of inspection, " + std::to_string(scores.size()) +
            (usual ? "" : ", exposure time doubled"),
        {{"of the toured metres, seen sharp, %",
          metres > 0 ? seen / metres : 0,
          {},
          at_least(99.5),
          "pipe_seen_percent" + suffix},
         {"mean speed along pipes, m/s", speed, {}, kLargeIsGood, "inspection_speed" + suffix},
         {"tours with a contact", collisions, {}, kNone, "tour_collisions" + suffix},
         {"tours completed, %",
          100 * reached / static_cast<double>(scores.size()),
          {},
          at_least(99),
          "tour_reached_percent" + suffix}});
  }
}

}  // namespace

std::vector<std::uint64_t> drawn_seeds(const std::vector<std::uint64_t>& seeds, std::size_t count) {
  constexpr std::uint64_t kStream = 22;
  std::vector<std::uint64_t> result;
  const std::size_t each = std::max<std::size_t>(1, count / seeds.size());
  for (const std::uint64_t seed : seeds) {
    statistics::Draw draw(seed, kStream);
    for (std::size_t i = 0; i < each; ++i) {
      result.push_back(draw.seed());
    }
  }
  return result;
}

void add_navigation_missions(const std::vector<std::uint64_t>& seeds,
                             const NavigationExtent& extent, FigureRows& rows,
                             StageProgress& progress) {
  add_primitive_replay(rows);
  add_pose_missions(drawn_seeds(seeds, extent.missions), rows, progress);
  add_inspection_tours(drawn_seeds(seeds, extent.inspections), rows, progress);
  add_gps_missions(seeds, extent, rows, progress);
}

}  // namespace pipescout::reproduce
