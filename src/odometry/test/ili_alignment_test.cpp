// SPDX-License-Identifier: Apache-2.0
// Two inspection runs of one 17.5 km pipeline, eight years apart, by different tools. The joint
// numbers of the lists score the result and have no other part in it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "ili_lists.hpp"
#include "pipescout/odometry/weld_alignment.hpp"
#include "pipescout/odometry/weld_ledger.hpp"

namespace pipescout::odometry {
namespace {

using test::InspectionList;
using test::InspectionRuns;
using test::ListedFeature;

// The lists give no uncertainty; they print hundredths of a foot.
constexpr double kDetectionSigma = 0.03;  // m

std::vector<WeldPosition> welds(const InspectionList& list) {
  std::vector<WeldPosition> positions;
  for (const auto& weld : list.welds) {
    positions.push_back({.chainage = weld.chainage, .standard_deviation = kDetectionSigma});
  }
  return positions;
}

/// What tells a fixed feature from others of its kind in the same joint: o'clock of a tap or tee,
/// direction of a bend ("5.8D - 45° - Right"; radius and angle are each tool's estimate).
std::string mark(const ListedFeature& feature) {
  if (feature.kind == "bend") {
    return feature.comment.substr(feature.comment.rfind(' ') + 1);
  }
  return feature.clock;
}

/// Features that the answer key proves to be one: same kind, same mark, same joint number, and the
/// same number of such features in that joint in both runs (then in order). No distance enters, so
/// that nothing hides an error. Kinds are those that stay where they are for years; markers above
/// ground are put down anew for each run, and metal loss grows and is split differently.
std::vector<std::pair<double, double>> common_features(const InspectionRuns& runs) {
  const std::set<std::string> kinds = {"bend",   "tap",     "valve", "tee",
                                       "flange", "support", "magnet"};
  using Place = std::tuple<std::string, std::string, std::string>;
  std::map<Place, std::pair<std::vector<double>, std::vector<double>>> places;
  for (const ListedFeature& feature : runs.run_2007.features) {
    if (kinds.contains(feature.kind)) {
      places[{feature.key, feature.kind, mark(feature)}].first.push_back(feature.chainage);
    }
  }
  for (const ListedFeature& feature : runs.run_2015.features) {
    if (kinds.contains(feature.kind)) {
      places[{feature.key, feature.kind, mark(feature)}].second.push_back(feature.chainage);
    }
  }
  std::vector<std::pair<double, double>> common;
  for (const auto& [place, chainages] : places) {
    if (chainages.first.size() == chainages.second.size()) {
      for (std::size_t k = 0; k < chainages.first.size(); ++k) {
        common.emplace_back(chainages.first[k], chainages.second[k]);
      }
    }
  }
  return common;
}

class InspectionRunsTest : public testing::Test {
 protected:
  void SetUp() override {
    runs_ = test::load_inspection_runs();
    if (!runs_) {
      GTEST_SKIP() << "NOT TESTED on real inspection runs: PIPESCOUT_SHARED_DATA names no folder "
                      "with ili_pipeline/2007.csv and 2015.csv";
    }
  }
  std::optional<InspectionRuns> runs_;
};

TEST_F(InspectionRunsTest, CommonWeldsAreMatchedByTheirJointLengths) {
  const WeldAlignment alignment = align_welds(welds(runs_->run_2007), welds(runs_->run_2015));
  ASSERT_EQ(alignment.status, AlignmentStatus::kOk);
  std::set<std::string> in_2015;
  for (const auto& weld : runs_->run_2015.welds) {
    in_2015.insert(weld.key);
  }
  const auto common = std::count_if(runs_->run_2007.welds.begin(), runs_->run_2007.welds.end(),
                                    [&](const auto& weld) { return in_2015.contains(weld.key); });
  int right = 0;
  int wrong = 0;
  for (const WeldMatch& match : alignment.matches) {
    const bool same = runs_->run_2007.welds[match.a].key == runs_->run_2015.welds[match.b].key;
    ++(same ? right : wrong);
  }
  const double percent = 100.0 * right / static_cast<double>(common);
  std::printf("welds: %td common, ili_welds_matched_percent %.3f, ili_welds_wrong %d\n", common,
              percent, wrong);
  EXPECT_GE(percent, 99.5);
  EXPECT_EQ(wrong, 0);
}

TEST_F(InspectionRunsTest, OtherFeaturesFallOnEachOther) {
  const WeldAlignment alignment = align_welds(welds(runs_->run_2007), welds(runs_->run_2015));
  std::vector<double> errors;
  std::vector<double> raw;
  for (const auto& [then, later] : common_features(*runs_)) {
    errors.push_back(std::abs(alignment.a_to_b.map(then).chainage - later));
    raw.push_back(std::abs(then - later));
  }
  ASSERT_GE(errors.size(), 80U);
  std::sort(errors.begin(), errors.end());
  std::sort(raw.begin(), raw.end());
  const double p95 = errors[(errors.size() * 95) / 100];
  std::printf(
      "features: %zu common, median %.3f m, ili_feature_p95_m %.3f, worst %.3f m "
      "(unaligned: median %.1f m, worst %.1f m)\n",
      errors.size(), errors[errors.size() / 2], p95, errors.back(), raw[raw.size() / 2],
      raw.back());
  EXPECT_LE(p95, 0.5);
}

/// Keys of a run's welds by their chainage, which the ledger keeps bit by bit.
std::map<double, std::string> keys(const InspectionList& list) {
  std::map<double, std::string> result;
  for (const auto& weld : list.welds) {
    result.emplace(weld.chainage, weld.key);
  }
  return result;
}

TEST_F(InspectionRunsTest, LedgerReadBackHoldsWeldsAndFeaturesOfBothRuns) {
  LedgerUpdate update = build_ledger({.name = "2007"}, welds(runs_->run_2007));
  update = merge_run(update.ledger, {.name = "2015"}, welds(runs_->run_2015));
  ASSERT_TRUE(update.accepted);
  const WeldLedger ledger = from_csv(to_csv(update.ledger));
  EXPECT_EQ(to_csv(ledger), to_csv(update.ledger));
  const auto keys_2007 = keys(runs_->run_2007);
  const auto keys_2015 = keys(runs_->run_2015);
  int right = 0;
  int wrong = 0;
  for (const LedgerWeld& weld : ledger.welds) {
    if (weld.sightings.size() == 2) {
      const bool same =
          keys_2007.at(weld.sightings[0].chainage) == keys_2015.at(weld.sightings[1].chainage);
      ++(same ? right : wrong);
    }
  }
  const ChainageMap from_2007 = run_to_ledger(ledger, 0);
  const ChainageMap from_2015 = run_to_ledger(ledger, 1);
  std::vector<double> errors;
  for (const auto& [then, later] : common_features(*runs_)) {
    errors.push_back(std::abs(from_2007.map(then).chainage - from_2015.map(later).chainage));
  }
  std::sort(errors.begin(), errors.end());
  const double p95 = errors[(errors.size() * 95) / 100];
  std::printf("ledger: %zu welds, %d seen by both runs, %d wrong, %zu added, features p95 %.3f m\n",
              ledger.welds.size(), right, wrong, update.added, p95);
  // By the answer key 1603 welds of 2007 are all in 2015 too, which has 1607.
  EXPECT_GE(right, 1595);  // 99.5 %
  EXPECT_EQ(wrong, 0);
  EXPECT_LE(ledger.welds.size(), 1610U);
  EXPECT_LE(p95, 0.5);
}

}  // namespace
}  // namespace pipescout::odometry
