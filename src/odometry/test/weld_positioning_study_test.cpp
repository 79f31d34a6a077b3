// SPDX-License-Identifier: Apache-2.0
// Figures of weld positioning on 20 seeds that no parameter was chosen on (those were 1 to 100).
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <span>
#include <vector>

#include "crawler_score.hpp"

namespace pipescout::odometry {
namespace {

using test::CrawlerRunSettings;
using test::CrawlerScore;
using test::quantile;

constexpr std::uint64_t kFirstSeed = 1001;
constexpr std::uint64_t kLastSeed = 1020;

struct Study {
  std::vector<CrawlerScore> runs;
  std::vector<double> errors;
  std::vector<double> scale_errors;
  std::vector<double> lock_joints;
  std::vector<double> coverage;  // percent, per run

  [[nodiscard]] std::size_t sum(std::size_t CrawlerScore::*field) const {
    return std::accumulate(runs.begin(), runs.end(), std::size_t{0},
                           [field](std::size_t s, const CrawlerScore& r) { return s + r.*field; });
  }
  [[nodiscard]] double percent(std::size_t CrawlerScore::*part,
                               std::size_t CrawlerScore::*whole) const {
    return 100.0 * static_cast<double>(sum(part)) / static_cast<double>(sum(whole));
  }
};

enum class Knowledge { kNothing, kStart, kStartWithoutTally };

/// Every other run faces backwards, and nothing knows which.
Study study(CrawlerRunSettings settings, Knowledge knowledge = Knowledge::kNothing,
            const WeldPositioningParameters& parameters = {}) {
  Study result;
  for (std::uint64_t seed = kFirstSeed; seed <= kLastSeed; ++seed) {
    settings.backward = seed % 2 == 1;
    const auto run = test::simulate_crawler_run(settings, seed);
    WeldPositioningStart start{.orientation = Orientation::kUnknown};
    if (knowledge != Knowledge::kNothing) {
      const auto weld = std::upper_bound(run.welds.begin(), run.welds.end(), run.start) - 1;
      start.joint_known = true;
      start.joint = static_cast<std::size_t>(weld - run.welds.begin());
      start.distance = run.start - *weld;
      start.orientation = settings.backward ? Orientation::kBackward : Orientation::kForward;
    }
    const auto tally = knowledge == Knowledge::kStartWithoutTally ? std::span<const TallyJoint>{}
                                                                  : std::span(run.tally);
    WeldPositioning positioning(parameters, tally, start);
    result.runs.push_back(test::score_run(run, positioning, settings));
    const CrawlerScore& score = result.runs.back();
    result.errors.insert(result.errors.end(), score.errors.begin(), score.errors.end());
    result.scale_errors.insert(result.scale_errors.end(), score.scale_errors.begin(),
                               score.scale_errors.end());
    result.lock_joints.push_back(static_cast<double>(score.lock_joints));
    result.coverage.push_back(100.0 * static_cast<double>(score.inside_band) /
                              static_cast<double>(score.locked_events));
  }
  return result;
}

void print(const char* name, const Study& study) {
  std::printf(
      "%s: lock_joints_median %g lock_joints_max %g wrong_joint_after_lock %zu in_joint_p95_m %.4f "
      "in_joint_worst_m %.4f coverage95_percent %.2f (runs %.2f to %.2f) scale_p95 %.5f "
      "locks_lost %zu false_slips %zu\n",
      name, quantile(study.lock_joints, 0.5), quantile(study.lock_joints, 1.0),
      study.sum(&CrawlerScore::wrong_joint), quantile(study.errors, 0.95),
      quantile(study.errors, 1.0),
      study.percent(&CrawlerScore::inside_band, &CrawlerScore::locked_events),
      quantile(study.coverage, 0.0), quantile(study.coverage, 1.0),
      quantile(study.scale_errors, 0.95), study.sum(&CrawlerScore::locks_lost),
      study.sum(&CrawlerScore::false_slips));
}

void expect_targets(const Study& study) {
  EXPECT_LE(quantile(study.lock_joints, 0.5), 10.0);
  EXPECT_LE(quantile(study.lock_joints, 1.0), 20.0);
  EXPECT_EQ(study.sum(&CrawlerScore::wrong_joint), 0U);
  EXPECT_LE(quantile(study.errors, 0.95), 0.05);
  EXPECT_LE(quantile(study.errors, 1.0), 0.15);
  const double coverage = study.percent(&CrawlerScore::inside_band, &CrawlerScore::locked_events);
  EXPECT_GE(coverage, 92.0);
  EXPECT_LE(coverage, 98.0);
}

TEST(WeldPositioningStudy, UnknownStart) {
  const Study result = study({});
  print("unknown start", result);
  expect_targets(result);
}

TEST(WeldPositioningStudy, UnknownStartReversing) {
  for (const bool again : {false, true}) {
    const Study result = study({.reversals = 20, .detects_on_old_ground = again});
    print(again ? "reversing, welds seen again" : "reversing, welds not seen again", result);
    expect_targets(result);
  }
}

TEST(WeldPositioningStudy, KnownStart) {
  const Study result = study({}, Knowledge::kStart);
  print("known start", result);
  expect_targets(result);
}

TEST(WeldPositioningStudy, NoiseTwiceAsStated) {
  CrawlerRunSettings settings;
  settings.stated_noise_part = 0.5;
  const Study result = study(settings);
  print("odometer noise twice as stated", result);
  expect_targets(result);
}

TEST(WeldPositioningStudy, DoubleSlips) {
  CrawlerRunSettings settings;
  settings.double_slips = 20;
  const Study result = study(settings);
  print("double slips", result);
  const double detected = result.percent(&CrawlerScore::slips_detected, &CrawlerScore::slips);
  std::printf("double_slip_detected_percent %.2f of %zu, hidden %zu\n", detected,
              result.sum(&CrawlerScore::slips), result.sum(&CrawlerScore::slips_hidden));
  EXPECT_GE(result.sum(&CrawlerScore::slips), 350U);
  EXPECT_GE(detected, 99.0);
  EXPECT_LE(result.percent(&CrawlerScore::slips_hidden, &CrawlerScore::slips), 1.0);
  const double coverage = result.percent(&CrawlerScore::inside_band, &CrawlerScore::locked_events);
  EXPECT_GE(coverage, 92.0);
  EXPECT_LE(coverage, 98.0);
}

TEST(WeldPositioningStudy, ErrorsOfTheTally) {
  CrawlerRunSettings settings;
  settings.wrong_lengths = 3;
  settings.missing_joints = 3;
  settings.extra_joints = 3;
  const Study result = study(settings);
  print("errors of the tally", result);
  // Joints that differ by less than the tolerance cannot be told apart at once: the index may be
  // off by one for a few joints after a joint that is missing or extra, never for long.
  EXPECT_LE(result.percent(&CrawlerScore::wrong_joint, &CrawlerScore::locked_events), 1.5);
  EXPECT_LE(quantile(result.errors, 0.95), 0.05);
  const auto right = std::count_if(result.runs.begin(), result.runs.end(),
                                   [](const CrawlerScore& run) { return run.right_at_end; });
  EXPECT_EQ(right, 20);
}

/// A pipe read from its other end is the same pipe. Equal to the bit it is not: which hypotheses
/// merge, and with which first, depends on their order.
TEST(WeldPositioningStudy, ThePipeMayBeReadFromEitherEnd) {
  CrawlerRunSettings settings;
  settings.double_slips = 10;
  settings.reversals = 5;
  std::size_t compared = 0;
  for (std::uint64_t seed = kFirstSeed; seed <= kLastSeed; ++seed) {
    const auto run = test::simulate_crawler_run(settings, seed);
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

TEST(WeldPositioningStudy, WithoutATally) {
  const Study result = study({}, Knowledge::kStartWithoutTally);
  print("without a tally", result);
  // Backwards, the length of the joint itself is only known to its tolerance; the count is right.
  EXPECT_LT(quantile(result.errors, 1.0), 1.0);
  const double coverage = result.percent(&CrawlerScore::inside_band, &CrawlerScore::locked_events);
  EXPECT_GE(coverage, 92.0);
  EXPECT_LE(coverage, 98.0);
}

}  // namespace
}  // namespace pipescout::odometry
