// SPDX-License-Identifier: Apache-2.0
// Measures what "supported by a group of sensors" may mean, and prints the figures that
// docs/decisions/majority-support-rule.md quotes.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "pipescout/odometry/consensus_fusion.hpp"
#include "rival_rules.hpp"

namespace pipescout::odometry {
namespace {

constexpr int kTrials = 4000;
constexpr std::uint64_t kSeed = 2008;
constexpr double kSigma = 0.056;  // m, of the paper's odometers
constexpr double kWrong = 0.1;    // m; an answer farther off than this is counted as wrong
constexpr double kEpsilon = 0.75;

enum class Slip {
  kAlone,     // each slipping wheel for itself, 0.1 to 1 m short
  kCreeping,  // each for itself, 0.05 to 0.3 m short: the groups run into each other
  kTogether,  // all slipping wheels 0.5 m short: a wet stretch of pipe
  kPrecise,   // the wheel with the smallest sigma is 0.2 m short
};

struct Scenario {
  const char* name;
  std::size_t odometers;
  std::size_t slipping;
  Slip slip;
  bool mixed;      // sigmas from 0.015 to 0.12 m in a geometric series, else all kSigma
  double scatter;  // true standard deviation / sigma: sigmas are often stated with a margin
};

enum Rule : std::size_t {
  kMajority,
  kMutualMajority,
  kMutualGroup,
  kMutualGroupMajority,
  kConnectedGroup,
  kConnectedGroupMajority,
  kRuleCount
};
constexpr std::array<const char*, kRuleCount> kRuleNames = {
    "majority",  "mutual majority",    "largest mutual group", "same, with majority",
    "connected", "same, with majority"};

OdometerSet apply(Rule rule, const ConfidenceDistanceMatrix& distances,
                  const RelationMatrix& relation) {
  const auto if_majority = [&](const OdometerSet& group) {
    return 2 * group.count() > static_cast<std::size_t>(relation.rows()) ? group : OdometerSet();
  };
  switch (rule) {
    case kMajority:
      return fusion_set(relation, SupportRule::kMajority);
    case kMutualMajority:
      return fusion_set(relation, SupportRule::kMutualMajority);
    case kMutualGroup:
      return test::largest_mutual_group(distances, relation);
    case kMutualGroupMajority:
      return if_majority(test::largest_mutual_group(distances, relation));
    case kConnectedGroup:
      return test::largest_connected_group(relation);
    case kConnectedGroupMajority:
      return if_majority(test::largest_connected_group(relation));
    case kRuleCount:
      break;
  }
  return {};
}

struct Outcome {
  double rms = 0.0;    // m, of the answers
  double none = 0.0;   // share of the trials without an answer
  double wrong = 0.0;  // share of the trials with an answer more than kWrong off
};
using Outcomes = std::array<Outcome, kRuleCount>;

std::vector<OdometerReading> draw(const Scenario& scenario, std::mt19937_64& engine) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> alone(0.1, 1.0);
  std::uniform_real_distribution<double> creeping(0.05, 0.3);
  const auto m = scenario.odometers;
  std::vector<double> sigmas(m, kSigma);
  if (scenario.mixed) {
    for (std::size_t i = 0; i < m; ++i) {
      sigmas[i] = 0.015 * std::pow(8.0, static_cast<double>(i) / static_cast<double>(m - 1));
    }
    if (scenario.slip != Slip::kPrecise) {
      std::shuffle(sigmas.begin(), sigmas.end(), engine);
    }
  }
  std::vector<OdometerReading> readings;
  for (std::size_t i = 0; i < m; ++i) {
    double error = scenario.scatter * sigmas[i] * normal(engine);
    if (i < scenario.slipping) {
      error -= scenario.slip == Slip::kAlone      ? alone(engine)
               : scenario.slip == Slip::kCreeping ? creeping(engine)
               : scenario.slip == Slip::kTogether ? 0.5
                                                  : 0.2;
    }
    readings.push_back({.distance = error, .standard_deviation = sigmas[i]});
  }
  return readings;
}

Outcomes measure(const Scenario& scenario) {
  std::mt19937_64 engine(kSeed);
  Outcomes outcomes;
  std::array<int, kRuleCount> answers{};
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto readings = draw(scenario, engine);
    const auto distances = confidence_distance_matrix(readings);
    const auto relation = relation_matrix(distances, kEpsilon);
    for (std::size_t rule = 0; rule < kRuleCount; ++rule) {
      const auto members = apply(static_cast<Rule>(rule), distances, relation);
      if (members.none()) {
        outcomes[rule].none += 1.0 / kTrials;
        continue;
      }
      const double error =
          fuse_members(readings, {}, members, Weighting::kMaximumLikelihood).distance;
      outcomes[rule].rms += error * error;
      outcomes[rule].wrong += std::abs(error) > kWrong ? 1.0 / kTrials : 0.0;
      ++answers[rule];
    }
  }
  for (std::size_t rule = 0; rule < kRuleCount; ++rule) {
    outcomes[rule].rms =
        answers[rule] == 0 ? std::nan("") : std::sqrt(outcomes[rule].rms / answers[rule]);
  }
  return outcomes;
}

void print_head() {
  std::printf(
      "RMS error of the answers in mm / no answer in %% / answer more than %.0f mm off in %%\n",
      1000.0 * kWrong);
  std::printf("(%d trials each, seed %llu)\n\n| m | slipping | scenario |", kTrials,
              static_cast<unsigned long long>(kSeed));
  for (const char* name : kRuleNames) {
    std::printf(" %s |", name);
  }
  std::printf("\n|---|---|---|%s\n", "---|---|---|---|---|---|");
}

void print_row(const Scenario& scenario, const Outcomes& outcomes) {
  std::printf("| %zu | %zu | %s |", scenario.odometers, scenario.slipping, scenario.name);
  for (const auto& outcome : outcomes) {
    if (std::isnan(outcome.rms)) {
      std::printf(" - / 100 / 0 |");
    } else {
      std::printf(" %.0f / %.0f / %.1f |", 1000.0 * outcome.rms, 100.0 * outcome.none,
                  100.0 * outcome.wrong);
    }
  }
  std::printf("\n");
}

TEST(SupportRuleStudy, FiguresOfTheDecision) {
  const std::vector<Scenario> scenarios = {
      {"none slips", 3, 0, Slip::kAlone, false, 1.0},
      {"none slips", 8, 0, Slip::kAlone, false, 1.0},
      {"none slips", 16, 0, Slip::kAlone, false, 1.0},
      {"each alone", 3, 1, Slip::kAlone, false, 1.0},
      {"each alone", 5, 2, Slip::kAlone, false, 1.0},
      {"each alone", 8, 3, Slip::kAlone, false, 1.0},
      {"each alone, sigma with margin 2", 5, 2, Slip::kAlone, false, 0.5},
      {"each alone, sigma with margin 2", 8, 3, Slip::kAlone, false, 0.5},
      {"all together, split in half", 4, 2, Slip::kTogether, false, 1.0},
      {"all together", 5, 2, Slip::kTogether, false, 1.0},
      {"all together, split in half", 16, 8, Slip::kTogether, false, 1.0},
      {"all together", 16, 7, Slip::kTogether, false, 1.0},
      {"creeping, sigma with margin 2", 16, 7, Slip::kCreeping, false, 0.5},
      {"none slips, mixed sigmas", 3, 0, Slip::kAlone, true, 1.0},
      {"none slips, mixed sigmas", 5, 0, Slip::kAlone, true, 1.0},
      {"the most precise slips", 3, 1, Slip::kPrecise, true, 1.0},
      {"the most precise slips", 5, 1, Slip::kPrecise, true, 1.0},
      {"more than half, each alone", 5, 3, Slip::kAlone, false, 1.0},
  };
  print_head();
  for (const auto& scenario : scenarios) {
    const auto outcomes = measure(scenario);
    print_row(scenario, outcomes);
    const auto& majority = outcomes[kMajority];
    SCOPED_TRACE(std::string(scenario.name) + ", m = " + std::to_string(scenario.odometers));

    if (!scenario.mixed) {  // support is symmetric: the two rules are one
      EXPECT_EQ(majority.none, outcomes[kMutualMajority].none);
      EXPECT_EQ(majority.wrong, outcomes[kMutualMajority].wrong);
    }
    if (2 * scenario.slipping < scenario.odometers && scenario.slip != Slip::kPrecise) {
      EXPECT_LT(majority.wrong, 0.025);
      EXPECT_LT(majority.rms, 0.050);
    }
    if (scenario.scatter < 1.0) {  // a margin in the sigmas buys answers
      EXPECT_LT(majority.none, 0.1);
    }
    if (scenario.slip == Slip::kTogether) {  // the largest group is not the true one often enough
      EXPECT_LT(majority.wrong, 0.01);
      EXPECT_GT(outcomes[kMutualGroup].wrong, 0.03);
    }
    if (scenario.slip == Slip::kCreeping) {  // support handed on takes the slipping wheels along
      EXPECT_GT(outcomes[kConnectedGroup].rms, 2.0 * majority.rms);
      EXPECT_GT(outcomes[kConnectedGroupMajority].rms, 2.0 * majority.rms);
    }
    if (scenario.slipping == 0 && !scenario.mixed) {  // refuses sound readings least
      EXPECT_LT(majority.none, 0.1);
      EXPECT_LE(majority.rms, outcomes[kMutualGroup].rms);
    }
    if (scenario.slipping == 0 && !scenario.mixed && scenario.odometers >= 8) {
      EXPECT_GT(outcomes[kMutualGroupMajority].none, 0.25);
    }
    if (scenario.slipping == 0 && scenario.mixed) {  // what weak support is worth
      EXPECT_LT(majority.none, 0.1);
      EXPECT_GT(outcomes[kMutualMajority].none, 0.25);
    }
    if (scenario.slip == Slip::kPrecise) {  // and what it costs
      EXPECT_GT(majority.wrong, outcomes[kMutualMajority].wrong);
    }
  }
}

TEST(SupportRuleStudy, SupportHandedOnAdmitsWhatNoSoundOdometerSupports) {
  // Nine sound readings at 0, seven creeping away in steps that each next one still supports.
  std::vector<OdometerReading> readings(16, {.distance = 0.0, .standard_deviation = kSigma});
  for (std::size_t i = 0; i < 7; ++i) {
    readings[i].distance = -0.06 * static_cast<double>(i + 1);
  }
  const auto distances = confidence_distance_matrix(readings);
  const auto relation = relation_matrix(distances, kEpsilon);
  const auto majority = apply(kMajority, distances, relation);
  const auto connected = apply(kConnectedGroupMajority, distances, relation);
  EXPECT_EQ(connected.count(), 16U);
  EXPECT_EQ(majority.count(), 10U);  // the sound ones and the one that they support
  const auto error_of = [&](const OdometerSet& members) {
    return std::abs(fuse_members(readings, {}, members, Weighting::kMaximumLikelihood).distance);
  };
  std::printf("creeping chain: majority %.0f mm off, connected group %.0f mm off\n",
              1000.0 * error_of(majority), 1000.0 * error_of(connected));
  EXPECT_LT(error_of(majority), 0.01);
  EXPECT_GT(error_of(connected), 0.1);
}

}  // namespace
}  // namespace pipescout::odometry
