// SPDX-License-Identifier: Apache-2.0
#include "arm_inspection.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <string>
#include <utility>

#include "each_seed.hpp"
#include "figure_rows.hpp"
#include "pipescout/arm_study/arm_carrier.hpp"

namespace pipescout::reproduce {
namespace {

using leak_study::CampaignScore;
using leak_study::SequencePlan;
using simulation::RoadClass;

/// However many are asked for: each renders all rows twice.
constexpr std::size_t kInspectionSeeds = 2;
/// rad: what six joint zeros come to at the camera.
constexpr double kArmDeviation = 0.01;

constexpr std::array kRoads{std::pair(RoadClass::kC, "C"), std::pair(RoadClass::kD, "D"),
                            std::pair(RoadClass::kE, "E")};

struct Scores {
  CampaignScore fixed;
  CampaignScore arm;

  Scores& operator+=(const Scores& other) {
    fixed += other.fixed;
    arm += other.arm;
    return *this;
  }
};

Scores inspect(const SequencePlan& plan, const arm_study::DriveSettings& drive,
               std::uint64_t seed) {
  Scores scores;
  scores.fixed.add(plan, leak_study::run_sequence(plan, {}, seed));
  arm_study::ArmCarrier carrier({.distance = plan.patrol.distance, .drive = drive},
                                geometry::Camera(plan.patrol.camera.camera), seed);
  leak_study::InspectionSettings settings;
  settings.pose.mounting_deviation = kArmDeviation;
  scores.arm.add(plan, leak_study::run_sequence(plan, settings, seed, &carrier));
  return scores;
}

void add_measures(const std::string& ground, const Scores& scores, bool figures,
                  std::vector<Measure>& measures) {
  for (const auto& [camera, score] :
       {std::pair<std::string, const CampaignScore&>("fixed", scores.fixed),
        std::pair<std::string, const CampaignScore&>("arm", scores.arm)}) {
    const std::string prefix =
        ground + (camera == "arm" ? ", tracker and arm: " : ", fixed camera: ");
    const auto add = [&](const std::string& name, double value, Target target,
                         const std::string& figure) {
      measures.push_back(
          {prefix + name, value, {}, target, figures ? figure + "_" + camera : std::string()});
    };
    add("leaks found, %", score.found_percent(), kLargeIsGood, "leaks_found_percent");
    add("leaks missed, of " + std::to_string(score.leaks),
        static_cast<double>(score.leaks - score.found), kSmallIsGood, "leaks_missed");
    add("tube in view with its whole width, %", score.seen_percent(), kLargeIsGood,
        "tube_seen_percent");
    add("false findings", static_cast<double>(score.false_findings), kSmallIsGood,
        "false_findings");
  }
}

}  // namespace

void reproduce_arm_inspection(const TrackingExtent& extent,
                              const std::vector<std::uint64_t>& all_seeds, FigureRows& rows,
                              StageProgress& progress) {
  const std::size_t seeds = std::min(all_seeds.size(), kInspectionSeeds);
  const std::size_t sequences = extent.inspection.sequences;
  std::vector<SequencePlan> plans;
  for (std::size_t i = 0; i < seeds; ++i) {
    for (SequencePlan& plan : leak_study::plan_campaign(extent.inspection, all_seeds[i])) {
      plan.patrol.terrain.hill_height = extent.arm.hill_height;
      plans.push_back(std::move(plan));
    }
  }
  std::vector<std::uint64_t> all(plans.size());
  std::iota(all.begin(), all.end(), 0);
  const std::string study =
      "Leak inspection with and without tracker and arm: " + std::to_string(plans.size()) +
      " rows of " + std::to_string(std::lround(extent.inspection.length)) + " m, hills of " +
      std::to_string(std::lround(extent.arm.hill_height)) + " m";
  const auto each = for_each_seed(progress, study, all, [&](std::uint64_t i) {
    return inspect(plans[i], extent.arm, all_seeds[i / sequences] * sequences + i % sequences);
  });
  std::vector<Measure> measures;
  Scores total;
  for (const auto& [road, name] : kRoads) {
    Scores of_road;
    for (std::size_t i = 0; i < plans.size(); ++i) {
      if (plans[i].patrol.terrain.roughness == simulation::iso_8608_density(road)) {
        of_road += each[i];
      }
    }
    total += of_road;
    add_measures(std::string("class ") + name, of_road, false, measures);
  }
  add_measures("all", total, true, measures);
  rows.add_study(study, measures);
}

}  // namespace pipescout::reproduce
