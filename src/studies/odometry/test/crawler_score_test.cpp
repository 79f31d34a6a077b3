// SPDX-License-Identifier: Apache-2.0
// Weld positioning on seeds that no parameter was chosen on (those were 1 to 100). All twenty seeds
// are run by `pipescout reproduce in-pipe`.
#include "pipescout/odometry_study/crawler_score.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <span>
#include <vector>

#include "pipescout/odometry_study/quantile.hpp"

namespace pipescout::odometry_study {
namespace {

using odometry::Orientation;
using odometry::TallyJoint;
using odometry::WeldPositioning;
using odometry::WeldPositioningParameters;
using odometry::WeldPositioningStart;

constexpr std::uint64_t kFirstSeed = 1001;
constexpr std::uint64_t kLastSeed = 1004;

struct Study {
  std::vector<CrawlerScore> runs;
  std::vector<double> errors;
  std::vector<double> lock_joints;

  [[nodiscard]] std::size_t sum(std::size_t CrawlerScore::*field) const {
    return std::accumulate(runs.begin(), runs.end(), std::size_t{0},
                           [field](std::size_t s, const CrawlerScore& r) { return s + r.*field; });
  }
  [[nodiscard]] double percent(std::size_t CrawlerScore::*part,
                               std::size_t CrawlerScore::*whole) const {
    return 100.0 * static_cast<double>(sum(part)) / static_cast<double>(sum(whole));
  }
  [[nodiscard]] double coverage() const {
    return percent(&CrawlerScore::inside_band, &CrawlerScore::locked_events);
  }
};

enum class Knowledge { kNothing, kStart, kStartWithoutTally };

/// Every other run faces backwards, and nothing knows which.
Study study(const char* name, CrawlerRunSettings settings,
            Knowledge knowledge = Knowledge::kNothing) {
  Study result;
  for (std::uint64_t seed = kFirstSeed; seed <= kLastSeed; ++seed) {
    settings.backward = seed % 2 == 1;
    const CrawlerRun run = simulate_crawler_run(settings, seed);
    const auto start = knowledge == Knowledge::kNothing
                           ? WeldPositioningStart{.orientation = Orientation::kUnknown}
                           : known_start(run, settings);
    const auto tally = knowledge == Knowledge::kStartWithoutTally ? std::span<const TallyJoint>{}
                                                                  : std::span(run.tally);
    WeldPositioning positioning({}, tally, start);
    result.runs.push_back(score_run(run, positioning, settings));
    const CrawlerScore& score = result.runs.back();
    result.errors.insert(result.errors.end(), score.errors.begin(), score.errors.end());
    result.lock_joints.push_back(static_cast<double>(score.lock_joints));
  }
  std::printf(
      "%s: lock_joints_median %g lock_joints_max %g wrong_joint_after_lock %zu in_joint_p95_m %.4f "
      "in_joint_worst_m %.4f coverage95_percent %.2f locks_lost %zu false_slips %zu\n",
      name, quantile(result.lock_joints, 0.5), quantile(result.lock_joints, 1.0),
      result.sum(&CrawlerScore::wrong_joint), quantile(result.errors, 0.95),
      quantile(result.errors, 1.0), result.coverage(), result.sum(&CrawlerScore::locks_lost),
      result.sum(&CrawlerScore::false_slips));
  return result;
}

void expect_targets(const Study& study) {
  EXPECT_LE(quantile(study.lock_joints, 0.5), 10.0);
  EXPECT_LE(quantile(study.lock_joints, 1.0), 20.0);
  EXPECT_EQ(study.sum(&CrawlerScore::wrong_joint), 0U);
  EXPECT_LE(quantile(study.errors, 0.95), 0.05);
  EXPECT_LE(quantile(study.errors, 1.0), 0.15);
  EXPECT_GE(study.coverage(), 92.0);
  EXPECT_LE(study.coverage(), 98.0);
}

TEST(WeldPositioningStudy, UnknownStart) {
  expect_targets(study("unknown start", {}));
}

TEST(WeldPositioningStudy, UnknownStartReversing) {
  CrawlerRunSettings settings;
  settings.reverse_share = 0.2;
  for (const bool again : {false, true}) {
    settings.detects_on_old_ground = again;
    expect_targets(
        study(again ? "reversing, welds seen again" : "reversing, welds not seen again", settings));
  }
}

TEST(WeldPositioningStudy, KnownStart) {
  expect_targets(study("known start", {}, Knowledge::kStart));
}

TEST(WeldPositioningStudy, NoiseTwiceAsStated) {
  CrawlerRunSettings settings;
  settings.stated_noise_part = 0.5;
  expect_targets(study("odometer noise twice as stated", settings));
}

TEST(WeldPositioningStudy, DoubleSlips) {
  CrawlerRunSettings settings;
  settings.double_slips = 20;
  const Study result = study("double slips", settings);
  EXPECT_GE(result.sum(&CrawlerScore::slips), 70U);
  EXPECT_GE(result.percent(&CrawlerScore::slips_said, &CrawlerScore::slips), 99.0);
  EXPECT_GE(result.percent(&CrawlerScore::slips_detected, &CrawlerScore::slips), 97.0);
  EXPECT_EQ(result.sum(&CrawlerScore::slips_hidden), 0U);
  EXPECT_GE(result.coverage(), 92.0);
  EXPECT_LE(result.coverage(), 98.0);
}

TEST(WeldPositioningStudy, ErrorsOfTheTally) {
  CrawlerRunSettings settings;
  settings.wrong_lengths = settings.missing_joints = settings.extra_joints = 0.003;
  const Study result = study("errors of the tally", settings);
  // Joints that differ by less than the tolerance cannot be told apart at once: the index may be
  // off by one for a few joints after a joint that is missing or extra, never for long.
  EXPECT_LE(result.percent(&CrawlerScore::wrong_joint, &CrawlerScore::locked_events), 1.5);
  EXPECT_LE(quantile(result.errors, 0.95), 0.05);
  for (const CrawlerScore& run : result.runs) {
    EXPECT_TRUE(run.right_at_end);
  }
}

/// A pipe read from its other end is the same pipe. Equal to the bit it is not: which hypotheses
/// merge, and with which first, depends on their order.
TEST(WeldPositioningStudy, ThePipeMayBeReadFromEitherEnd) {
  CrawlerRunSettings settings;
  settings.double_slips = 10;
  settings.reverse_share = 0.1;
  std::size_t compared = 0;
  for (std::uint64_t seed = kFirstSeed; seed <= kLastSeed; ++seed) {
    const CrawlerRun run = simulate_crawler_run(settings, seed);
    const std::vector<TallyJoint> mirrored(run.tally.rbegin(), run.tally.rend());
    const double length =
        std::accumulate(run.tally.begin(), run.tally.end(), 0.0,
                        [](double sum, const TallyJoint& joint) { return sum + joint.length; });
    WeldPositioning from_low({}, run.tally, {.orientation = Orientation::kUnknown});
    WeldPositioning from_high({}, mirrored, {.orientation = Orientation::kUnknown});
    for (const auto& event : run.events) {
      const auto& low =
          event.is_weld ? from_low.add_weld(event.weld) : from_low.add_increment(event.increment);
      const auto& high =
          event.is_weld ? from_high.add_weld(event.weld) : from_high.add_increment(event.increment);
      ASSERT_EQ(low.locked, high.locked) << "seed " << seed;
      if (low.locked) {
        ++compared;
        ASSERT_NEAR(low.chainage + high.chainage, length, 1e-3) << "seed " << seed;
        ASSERT_NEAR(low.probability, high.probability, 1e-5) << "seed " << seed;
        ASSERT_NEAR(low.scale, high.scale, 1e-4) << "seed " << seed;
        ASSERT_NE(low.orientation, high.orientation) << "seed " << seed;
      }
    }
  }
  EXPECT_GT(compared, 300'000U);
}

/// A slip over most of a bend is not told from the bend by three wheels: near the next weld the
/// joint would be wrong, and is not stated as certain. Development seeds where that happens.
TEST(WeldPositioningStudy, BehindABendAWrongJointIsNotStatedAsCertain) {
  CrawlerRunSettings settings;
  settings.bends = 30;
  settings.tees = 10;
  settings.rule = odometry::FusionRule::kCircumference;
  settings.lookback_windows = 16;
  for (const std::uint64_t seed : {2, 8, 20}) {
    settings.backward = seed % 2 == 1;
    const CrawlerRun run = simulate_crawler_run(settings, seed);
    const auto score = [&](double fault_probability) {
      WeldPositioning positioning({.bend_fault_probability = fault_probability}, run.tally,
                                  {.orientation = Orientation::kUnknown}, run.tally_bends);
      return score_run(run, positioning, settings);
    };
    const CrawlerScore certain = score(0);
    EXPECT_GT(certain.wrong_joint, 0U) << "seed " << seed;
    const CrawlerScore doubting = score(WeldPositioningParameters{}.bend_fault_probability);
    EXPECT_EQ(doubting.wrong_joint, 0U) << "seed " << seed;
    EXPECT_GT(doubting.locked_events, certain.locked_events / 100 * 99) << "seed " << seed;
    EXPECT_TRUE(doubting.right_at_end) << "seed " << seed;
  }
}

TEST(WeldPositioningStudy, WithoutATally) {
  const Study result = study("without a tally", {}, Knowledge::kStartWithoutTally);
  // Backwards, the length of the joint itself is only known to its tolerance; the count is right.
  EXPECT_LT(quantile(result.errors, 1.0), 1.0);
  EXPECT_GE(result.coverage(), 92.0);
  EXPECT_LE(result.coverage(), 98.0);
}

}  // namespace
}  // namespace pipescout::odometry_study
