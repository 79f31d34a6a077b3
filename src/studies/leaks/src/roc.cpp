// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_study/roc.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "pipescout/statistics/draw.hpp"

namespace pipescout::leak_study {
namespace {

/// m, from leak to leak: three tubes, as from post to post, so that all are half-way between joints
/// and none is behind a post.
constexpr double kApart = 3 * simulation::kAbsorberLength;
constexpr double kFirst = 1.5 * simulation::kAbsorberLength;  // m
constexpr std::uint64_t kOfRoc = 3;

/// A row with leaks or decoys, evenly.
SequencePlan plan_row(double netd, std::size_t places, statistics::Draw& draw) {
  const CampaignSettings one{.sequences = 1,
                             .faint_leaks = 0,
                             .other_leaks = 0,
                             .decoys = 0,
                             .netd_least = netd,
                             .netd_most = netd,
                             .length = kFirst + kApart * static_cast<double>(places) + kApart};
  return plan_campaign(one, draw.seed()).front();
}

double place_of(std::size_t i) {
  return kFirst + kApart * static_cast<double>(i);
}

}  // namespace

std::vector<RocScores> run_roc(const RocSettings& roc, const InspectionSettings& settings,
                               std::uint64_t seed) {
  if (roc.leaks < 1 || roc.leaks > 100 || roc.rises.empty()) {
    throw std::invalid_argument("leaks: must be 1 to 100, of one rise at least");
  }
  InspectionSettings keen = settings;
  keen.detector.profile.leak_delta = roc.least_delta;
  keen.detector.profile.split_delta = std::min(keen.detector.profile.split_delta, roc.least_delta);
  std::vector<RocScores> result;
  statistics::Draw draw(seed, kOfRoc);
  for (const double netd : roc.netds) {
    RocScores scores{.netd = netd};
    scores.of_leaks.resize(roc.rises.size());
    const std::size_t places = roc.leaks * roc.rises.size();
    SequencePlan plan = plan_row(netd, places, draw);
    for (std::size_t i = 0; i < places; ++i) {
      plan.patrol.scene.leaks.push_back(
          {.place = place_of(i), .length = 0.3, .rise = roc.rises[i % roc.rises.size()]});
    }
    SequenceScore score = run_sequence(plan, keen, draw.seed());
    std::vector<double> deltas(places, 0.0);
    const auto take = [&](const SequenceScore& each) {
      for (const FindingScore& finding : each.findings) {
        if (finding.leak) {
          deltas[*finding.leak] = std::max(deltas[*finding.leak], finding.mean_delta);
        } else {
          scores.of_others.push_back(finding.mean_delta);
        }
      }
      scores.metres += each.metres;
    };
    take(score);
    for (std::size_t i = 0; i < places; ++i) {
      scores.of_leaks[i % roc.rises.size()].push_back(deltas[i]);
    }
    if (roc.decoys > 0) {
      plan = plan_row(netd, roc.decoys, draw);
      for (std::size_t i = 0; i < roc.decoys; ++i) {
        const auto kind =
            static_cast<simulation::ThermalDecoyKind>(i % simulation::kThermalDecoyKinds);
        plan.patrol.scene.decoys.push_back(draw_decoy(kind, place_of(i), draw.seed()));
      }
      take(run_sequence(plan, keen, draw.seed()));
    }
    result.push_back(scores);
  }
  return result;
}

std::vector<RocPoint> roc_curve(std::span<const double> leaks, std::span<const double> others,
                                double metres, std::span<const double> thresholds) {
  std::vector<RocPoint> points;
  for (const double threshold : thresholds) {
    const auto above = [threshold](double delta) { return delta >= threshold; };
    const auto found = static_cast<double>(std::ranges::count_if(leaks, above));
    const auto wrong = static_cast<double>(std::ranges::count_if(others, above));
    points.push_back(
        {.threshold = threshold,
         .found_percent = leaks.empty() ? 0 : 100 * found / static_cast<double>(leaks.size()),
         .false_per_km = metres > 0 ? 1000 * wrong / metres : 0});
  }
  return points;
}

double roc_area(std::span<const double> leaks, std::span<const double> others) {
  if (others.empty()) {
    return 1;
  }
  double sum = 0;
  for (const double leak : leaks) {
    for (const double other : others) {
      sum += leak > other ? 1 : leak == other ? 0.5 : 0;
    }
  }
  return sum / static_cast<double>(leaks.size() * others.size());
}

}  // namespace pipescout::leak_study
