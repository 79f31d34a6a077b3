// SPDX-License-Identifier: Apache-2.0
#include "arm.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <string>
#include <utility>

#include "each_seed.hpp"
#include "figure_rows.hpp"
#include "pipescout/arm_study/arm_faults.hpp"
#include "seed_values.hpp"

namespace pipescout::reproduce {
namespace {

using arm_study::DriveScore;

/// However many are asked for: each drives 30 km.
constexpr std::size_t kDriveSeeds = 3;

template <class Function>
std::vector<double> values_of_rule(const std::vector<std::vector<DriveScore>>& of_seeds,
                                   std::size_t rule, Function value) {
  std::vector<double> values;
  for (const auto& scores : of_seeds) {
    values.push_back(static_cast<double>(std::invoke(value, scores[rule])));
  }
  return values;
}

void add_road(const arm_study::DriveSettings& settings, const std::string& road, bool figures,
              const std::vector<std::uint64_t>& seeds, FigureRows& rows, StageProgress& progress) {
  const std::string study = "Arm: " + std::to_string(std::lround(settings.length / 1000)) +
                            " km at 20 km/h on a road of class " + road;
  const auto rules = arm_study::arm_rules();
  const auto of_seeds = for_each_seed(progress, study, seeds, [&](std::uint64_t seed) {
    return arm_study::run_drive(settings, rules, seed);
  });
  std::vector<Measure> measures;
  for (std::size_t rule = 0; rule < rules.size(); ++rule) {
    const bool ours = figures && rule + 1 == rules.size();
    const auto add = [&](const std::string& name, auto value, Target target,
                         const std::string& figure) {
      const auto values = values_of_rule(of_seeds, rule, value);
      measures.push_back(
          {rules[rule].name + ": " + name, mean(values), values, target, ours ? figure : ""});
    };
    add("whole width in view, %", &DriveScore::in_view_percent,
        ours ? Target{.least = 99.9} : kLargeIsGood, "in_view_percent");
    add("distance from the middle row, RMS, px", &DriveScore::centre_rms, kSmallIsGood,
        "arm_error_rms_px");
    add("the same, largest, px", &DriveScore::largest_centre, kSmallIsGood, "");
    add(
        "deviation from level, RMS, degrees",
        [](const DriveScore& score) { return score.angle_rms() * 180 / std::numbers::pi; },
        kSmallIsGood, "");
    add("joints commanded to move, % of the time", &DriveScore::moving_percent, kSmallIsGood, "");
    add("commands beyond a limit", &DriveScore::limit_violations, kNone, "arm_limit_violations");
  }
  rows.add_study(study, measures);
}

}  // namespace

void reproduce_arm(const arm_study::DriveSettings& settings,
                   const std::vector<std::uint64_t>& all_seeds, FigureRows& rows,
                   StageProgress& progress) {
  const std::vector<std::uint64_t> seeds(
      all_seeds.begin(),
      all_seeds.begin() + static_cast<std::ptrdiff_t>(std::min(all_seeds.size(), kDriveSeeds)));
  using simulation::RoadClass;
  for (const auto& [road, name] : {std::pair(RoadClass::kC, "C"), std::pair(RoadClass::kD, "D"),
                                   std::pair(RoadClass::kE, "E")}) {
    arm_study::DriveSettings drive = settings;
    drive.road = road;
    add_road(drive, name, road == RoadClass::kD, seeds, rows, progress);
  }
  const std::string study = "Arm: faults during the drive, seed " + std::to_string(seeds.front());
  std::vector<Measure> measures;
  double safe = 0;
  const auto faults = arm_study::run_faults(settings, seeds.front());
  for (const arm_study::FaultScore& score : faults) {
    safe += score.safe ? 1 : 0;
    measures.push_back(
        {score.fault + ": " + to_string(score.state) + ", " + to_string(score.reason) + ": safe",
         score.safe ? 1.0 : 0.0,
         {},
         {.least = 1}});
  }
  measures.push_back({"with a safe final state",
                      safe,
                      {},
                      {.least = static_cast<double>(faults.size())},
                      "arm_safe_states"});
  rows.add_study(study, measures);
}

}  // namespace pipescout::reproduce
