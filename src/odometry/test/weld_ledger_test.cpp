// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry/weld_ledger.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "weld_runs.hpp"

namespace pipescout::odometry {
namespace {

using test::RunFaults;
using test::WeldRun;

constexpr RunFaults kClean = {.missed = 0.0, .spurious = 0.0, .drift = 0.0, .slip_share = 0.0};

test::Pipe make_pipe(std::uint64_t seed, std::size_t joints) {
  std::mt19937_64 engine(seed);
  return test::laid_pipe(joints, engine);
}

WeldRun drive(const test::Pipe& pipe, const RunFaults& faults, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  return test::make_run(pipe, 0, pipe.size(), faults, engine);
}

double root_mean_square(const std::vector<double>& errors) {
  double sum = 0.0;
  for (const double error : errors) {
    sum += error * error;
  }
  return std::sqrt(sum / static_cast<double>(errors.size()));
}

TEST(WeldLedger, OneRunIsItself) {
  const test::Pipe pipe = make_pipe(1, 50);
  const WeldRun run = drive(pipe, kClean, 2);
  const LedgerUpdate update = build_ledger({.name = "crawler", .date = "2026-05-01"}, run.welds);
  ASSERT_TRUE(update.accepted);
  ASSERT_EQ(update.ledger.welds.size(), run.welds.size());
  EXPECT_EQ(update.ledger.welds[0].id, "W00010");
  for (std::size_t k = 0; k < run.welds.size(); ++k) {
    EXPECT_NEAR(update.ledger.welds[k].chainage, run.welds[k].chainage, 1e-6);
  }
  // One joint: two sightings and the odometer between them, and its scale.
  const double length = update.ledger.welds[7].joint_length;
  EXPECT_NEAR(update.ledger.welds[7].joint_standard_deviation,
              std::sqrt(2.0 * 0.02 * 0.02 + 1e-4 * length + std::pow(0.01 * length, 2)), 1e-5);
  EXPECT_TRUE(std::isnan(update.ledger.welds.back().joint_length));
  EXPECT_EQ(evidence(update.ledger)[3].verdict, WeldVerdict::kSingle);
}

/// What a run with a clean odometer has of places given by joint and the metres into it.
std::vector<LandmarkPosition> see_landmarks(
    const WeldRun& run, const std::vector<std::pair<std::size_t, double>>& places, double sigma,
    std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> noise(0.0, sigma);
  std::vector<LandmarkPosition> seen;
  for (const auto& [joint, into] : places) {
    seen.push_back({.kind = joint % 2 == 0 ? LandmarkKind::kValve : LandmarkKind::kBend,
                    .chainage = run.welds[joint].chainage + into + noise(engine),
                    .standard_deviation = sigma});
  }
  return seen;
}

TEST(WeldLedger, LandmarksAreKnownAgain) {
  const test::Pipe pipe = make_pipe(5, 120);
  const WeldRun first = drive(pipe, kClean, 6);
  const WeldRun second = drive(pipe, kClean, 7);
  const std::vector<std::pair<std::size_t, double>> places{{10, 2.0}, {31, 1.0}, {80, 3.0}};
  constexpr double kSigma = 0.1;
  WeldLedger ledger = build_ledger({.name = "1"}, first.welds).ledger;
  ledger = add_landmarks(ledger, 0, see_landmarks(first, places, kSigma, 8));
  ASSERT_EQ(ledger.landmarks.size(), 3U);
  EXPECT_EQ(ledger.landmarks[0].id, "V00010");
  EXPECT_EQ(ledger.landmarks[1].id, "B00010");
  EXPECT_EQ(ledger.landmarks[2].id, "V00020");
  const double single = ledger.landmarks[0].standard_deviation;

  ledger = merge_run(ledger, {.name = "2"}, second.welds).ledger;
  ASSERT_EQ(ledger.landmarks.size(), 3U);
  auto seen = see_landmarks(second, {{10, 2.0}, {31, 1.0}, {50, 4.0}}, kSigma, 9);
  seen.push_back({.kind = LandmarkKind::kTee});  // not usable
  // Of another kind at the place of a valve: another landmark.
  seen.push_back(
      {.kind = LandmarkKind::kMarker, .chainage = seen[0].chainage, .standard_deviation = kSigma});
  ledger = add_landmarks(ledger, 1, seen);
  ASSERT_EQ(ledger.landmarks.size(), 5U);
  EXPECT_TRUE(std::ranges::is_sorted(ledger.landmarks, {}, &LedgerLandmark::chainage));
  for (const LedgerLandmark& landmark : ledger.landmarks) {
    const bool both = landmark.id == "V00010" || landmark.id == "B00010";
    EXPECT_EQ(landmark.sightings.size(), both ? 2U : 1U) << landmark.id;
    if (both) {
      const auto [joint, into] = places[landmark.id == "V00010" ? 0 : 1];
      EXPECT_LT(landmark.standard_deviation, single);
      EXPECT_NEAR(landmark.chainage - ledger.welds[joint].chainage, into,
                  4.0 * landmark.standard_deviation);
    }
  }
  EXPECT_THROW((void)add_landmarks(ledger, 2, seen), std::out_of_range);
}

TEST(WeldLedger, RunsRefineTheJointLengths) {
  const test::Pipe pipe = make_pipe(3, 300);
  LedgerUpdate update = build_ledger({.name = "run 0"}, drive(pipe, kClean, 100).welds);
  const auto errors = [&](const WeldLedger& ledger) {
    std::vector<double> result;
    for (std::size_t k = 0; k + 1 < pipe.size(); ++k) {
      result.push_back(ledger.welds[k].joint_length - (pipe[k + 1] - pipe[k]));
    }
    return result;
  };
  const double alone = root_mean_square(errors(update.ledger));
  for (std::uint64_t run = 1; run < 9; ++run) {
    update = merge_run(update.ledger, {.name = "run " + std::to_string(run)},
                       drive(pipe, kClean, 100 + run).welds);
    ASSERT_TRUE(update.accepted);
    ASSERT_EQ(update.ledger.welds.size(), pipe.size());
  }
  // Nine runs: a third of the error of one.
  EXPECT_NEAR(root_mean_square(errors(update.ledger)) / alone, 1.0 / 3.0, 0.06);
}

TEST(WeldLedger, StandardDeviationsCoverTheTruth) {
  std::size_t inside = 0;
  std::size_t count = 0;
  for (std::uint64_t seed = 1001; seed <= 1020; ++seed) {
    const test::Pipe pipe = make_pipe(seed, 200);
    LedgerUpdate update = build_ledger({.name = "a"}, drive(pipe, kClean, seed + 100).welds);
    update = merge_run(update.ledger, {.name = "b"}, drive(pipe, kClean, seed + 200).welds,
                       {.scale_sigma = 0.0});
    update = merge_run(update.ledger, {.name = "c"}, drive(pipe, kClean, seed + 300).welds,
                       {.scale_sigma = 0.0});
    ASSERT_EQ(update.ledger.welds.size(), pipe.size()) << "seed " << seed;
    for (std::size_t k = 0; k + 1 < pipe.size(); ++k) {
      const LedgerWeld& weld = update.ledger.welds[k];
      const double error = weld.joint_length - (pipe[k + 1] - pipe[k]);
      inside += std::abs(error) <= 1.96 * weld.joint_standard_deviation ? 1U : 0U;
      ++count;
    }
  }
  const double percent = 100.0 * static_cast<double>(inside) / static_cast<double>(count);
  std::printf("joint lengths inside their 95 %% band: %.1f %% of %zu\n", percent, count);
  EXPECT_GE(percent, 92.0);
  EXPECT_LE(percent, 98.0);
}

TEST(WeldLedger, SlipOfOneRunIsOutvoted) {
  const test::Pipe pipe = make_pipe(5, 100);
  WeldRun slipped = drive(pipe, kClean, 12);
  for (std::size_t k = 50; k < slipped.welds.size(); ++k) {
    slipped.welds[k].chainage += 2.0;
  }
  LedgerUpdate update = build_ledger({.name = "slipped"}, slipped.welds);
  update = merge_run(update.ledger, {.name = "b"}, drive(pipe, kClean, 13).welds);
  ASSERT_TRUE(update.accepted);
  // Two runs that disagree by 2 m: nobody knows who is right, and the ledger says so.
  EXPECT_GT(update.ledger.welds[49].joint_standard_deviation, 0.3);
  EXPECT_LT(update.ledger.welds[20].joint_standard_deviation, 0.15);
  update = merge_run(update.ledger, {.name = "c"}, drive(pipe, kClean, 14).welds);
  update = merge_run(update.ledger, {.name = "d"}, drive(pipe, kClean, 15).welds);
  EXPECT_NEAR(update.ledger.welds[49].joint_length, pipe[50] - pipe[49], 0.15);
}

TEST(WeldLedger, MissedWeldsAreAddedAndSpuriousOnesMarked) {
  const test::Pipe pipe = make_pipe(6, 80);
  WeldRun first = drive(pipe, kClean, 21);
  const WeldRun second = drive(pipe, kClean, 22);
  first.welds.erase(first.welds.begin() + 30);
  const WeldPosition ghost = {
      .chainage = 0.5 * (first.welds[55].chainage + first.welds[56].chainage),
      .standard_deviation = 0.02};
  first.welds.insert(first.welds.begin() + 56, ghost);
  LedgerUpdate update = build_ledger({.name = "first"}, first.welds);
  update = merge_run(update.ledger, {.name = "second"}, second.welds);
  ASSERT_TRUE(update.accepted);
  // Two sightings of 2 cm, and one.
  const auto positions = weld_positions(update.ledger);
  EXPECT_NEAR(positions[40].standard_deviation, 0.02 / std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(positions[30].standard_deviation, 0.02, 1e-12);
  EXPECT_EQ(positions[40].chainage, update.ledger.welds[40].chainage);
  EXPECT_EQ(update.added, 1U);
  ASSERT_EQ(update.ledger.welds.size(), pipe.size() + 1);
  EXPECT_EQ(update.ledger.welds[30].id, "W00300.1");
  EXPECT_NEAR(update.ledger.welds[30].chainage - update.ledger.welds[29].chainage,
              pipe[30] - pipe[29], 0.15);
  const auto believed = evidence(update.ledger);
  EXPECT_EQ(believed[30].verdict, WeldVerdict::kDoubtful);
  EXPECT_EQ(believed[57].verdict, WeldVerdict::kDoubtful);
  EXPECT_EQ(believed[40].verdict, WeldVerdict::kConfirmed);
  EXPECT_EQ(believed[30].passed, 2U);
  update = merge_run(update.ledger, {.name = "third"}, drive(pipe, kClean, 23).welds);
  EXPECT_EQ(update.added, 0U);
  EXPECT_EQ(evidence(update.ledger)[30].verdict, WeldVerdict::kConfirmed);
  EXPECT_EQ(evidence(update.ledger)[57].verdict, WeldVerdict::kDoubtful);
}

TEST(WeldLedger, TheMetreIsTheMeanOfTheRuns) {
  const test::Pipe pipe = make_pipe(7, 100);
  RunFaults worn = kClean;
  worn.scale = 1.02;
  LedgerUpdate update = build_ledger({.name = "true"}, drive(pipe, kClean, 31).welds);
  update = merge_run(update.ledger, {.name = "worn"}, drive(pipe, worn, 32).welds);
  ASSERT_TRUE(update.accepted);
  const double length = update.ledger.welds.back().chainage - update.ledger.welds.front().chainage;
  EXPECT_NEAR(length / pipe.back(), 1.0 / (0.5 * (1.0 + 1.0 / 1.02)), 0.002);
}

TEST(WeldLedger, RunFromTheOtherEndJoins) {
  const test::Pipe pipe = make_pipe(8, 100);
  const WeldRun back = test::driven_back(drive(pipe, kClean, 42));
  LedgerParameters parameters;
  parameters.alignment.direction = AlignmentDirection::kEither;
  LedgerUpdate update = build_ledger({.name = "there"}, drive(pipe, kClean, 41).welds, parameters);
  update = merge_run(update.ledger, {.name = "back"}, back.welds, parameters);
  ASSERT_TRUE(update.accepted);
  EXPECT_TRUE(update.alignment.reversed);
  ASSERT_EQ(update.ledger.welds.size(), pipe.size());
  const ChainageMap map = run_to_ledger(update.ledger, 1);
  EXPECT_NEAR(map.map(back.welds[0].chainage).chainage, update.ledger.welds.back().chainage, 1e-9);
}

TEST(WeldLedger, FindingIsFoundAgainByAnotherRun) {
  const test::Pipe pipe = make_pipe(9, 200);
  RunFaults late = kClean;
  late.scale = 1.01;
  late.start = 300.0;
  LedgerUpdate update = build_ledger({.name = "2020"}, drive(pipe, kClean, 51).welds);
  update = merge_run(update.ledger, {.name = "2026"}, drive(pipe, late, 52).welds);
  ASSERT_TRUE(update.accepted);
  update.ledger = lay_along(
      update.ledger,
      CentreLine(MapFrame::kLocal,
                 {{.position = {.coordinates = {0, 0, 0}, .standard_deviation = 0.05}},
                  {.position = {.coordinates = {5000, 0, 0}, .standard_deviation = 0.05}}}));
  // Half way between two welds, by the odometer of each run.
  const auto sighted = [&](std::size_t weld, std::size_t run) {
    return update.ledger.welds[weld].sightings[run].chainage;
  };
  const LedgerPlace then = locate(
      update.ledger, run_to_ledger(update.ledger, 0).map(0.5 * (sighted(99, 0) + sighted(100, 0))));
  const LedgerPlace now = locate(
      update.ledger, run_to_ledger(update.ledger, 1).map(0.5 * (sighted(99, 1) + sighted(100, 1))));
  EXPECT_EQ(then.weld, update.ledger.welds[99].id);
  EXPECT_EQ(now.weld, then.weld);
  EXPECT_NEAR(now.from_weld, then.from_weld, 1e-9);
  EXPECT_LT(now.from_weld_standard_deviation, 0.1);
  EXPECT_GT(now.standard_deviation, now.from_weld_standard_deviation);
  ASSERT_TRUE(now.position);
  EXPECT_NEAR(now.position->coordinates[0], now.chainage, 1e-6);
  EXPECT_TRUE(std::isnan(locate(update.ledger, ChainageMap().map(3.0)).chainage));
  EXPECT_THROW((void)run_to_ledger(update.ledger, 2), std::out_of_range);
}

TEST(WeldLedger, RunOfAnotherPipeChangesNothing) {
  const test::Pipe pipe = make_pipe(10, 100);
  const LedgerUpdate first = build_ledger({.name = "one"}, drive(pipe, kClean, 61).welds);
  const LedgerUpdate second =
      merge_run(first.ledger, {.name = "other"}, drive(make_pipe(11, 100), kClean, 62).welds);
  EXPECT_FALSE(second.accepted);
  EXPECT_EQ(second.alignment.status, AlignmentStatus::kNoOverlap);
  EXPECT_EQ(second.ledger.runs, first.ledger.runs);
  ASSERT_EQ(second.ledger.welds.size(), first.ledger.welds.size());
  for (std::size_t k = 0; k < first.ledger.welds.size(); ++k) {
    EXPECT_EQ(second.ledger.welds[k].id, first.ledger.welds[k].id);
    EXPECT_EQ(second.ledger.welds[k].chainage, first.ledger.welds[k].chainage);
    EXPECT_EQ(second.ledger.welds[k].sightings, first.ledger.welds[k].sightings);
  }
}

TEST(WeldLedger, KeepsEveryRunsOrderWhereSightingsAreWorthLittle) {
  std::size_t merged = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 engine(seed);
    test::Pipe pipe;
    for (const double weld : test::laid_pipe(60, engine)) {
      pipe.push_back(weld);
      if (pipe.size() % 9 == 4) {
        pipe.push_back(weld + 0.35);  // as short as a sighting is uncertain
      }
    }
    const RunFaults poor = {.missed = 0.06,
                            .spurious = 0.06,
                            .detection_sigma = 0.1,
                            .slip_share = 0.1,
                            .largest_slip = 3.0};
    const auto drive_poorly = [&] {
      return test::make_run(pipe, 0, pipe.size(), poor, engine).welds;
    };
    WeldLedger ledger = build_ledger({.name = "run 0"}, drive_poorly()).ledger;
    for (std::size_t run = 1; run < 6; ++run) {
      const LedgerUpdate update =
          merge_run(ledger, {.name = "run " + std::to_string(run)}, drive_poorly());
      merged += update.accepted ? 1U : 0U;
      ledger = update.ledger;
      for (std::size_t k = 0; k < ledger.runs.size(); ++k) {
        EXPECT_NO_THROW((void)run_to_ledger(ledger, k)) << "seed " << seed;
      }
      for (std::size_t k = 0; k + 1 < ledger.welds.size(); ++k) {
        ASSERT_GT(ledger.welds[k].joint_length, 0.0);
        ASSERT_GT(ledger.welds[k].joint_standard_deviation, 0.0);
      }
    }
  }
  EXPECT_GE(merged, 30U);
}

TEST(WeldLedger, BadWeldsAreLeftOutAndListed) {
  const test::Pipe pipe = make_pipe(12, 40);
  WeldRun run = drive(pipe, kClean, 71);
  run.welds[5].chainage = std::numeric_limits<double>::quiet_NaN();
  run.welds[9].standard_deviation = 0.0;
  const LedgerUpdate update = build_ledger({.name = "bad"}, run.welds);
  EXPECT_THAT(update.unusable, testing::ElementsAre(5, 9));
  EXPECT_EQ(update.ledger.welds.size(), pipe.size() - 2);
  EXPECT_FALSE(build_ledger({.name = "none"}, {}).accepted);
}

TEST(WeldLedger, RefusesNamesAndParametersOutOfRange) {
  const WeldRun run = drive(make_pipe(13, 40), kClean, 81);
  const LedgerUpdate update = build_ledger({.name = "a"}, run.welds);
  EXPECT_THROW((void)build_ledger({.name = ""}, run.welds), std::invalid_argument);
  EXPECT_THROW((void)build_ledger({.name = "a|b"}, run.welds), std::invalid_argument);
  EXPECT_THROW((void)build_ledger({.name = "a", .date = "1\n2"}, run.welds), std::invalid_argument);
  EXPECT_THROW((void)merge_run(update.ledger, {.name = "a"}, run.welds), std::invalid_argument);
  using Spoil = std::function<void(LedgerParameters&)>;
  const std::vector<std::pair<std::string, Spoil>> cases = {
      {"length_noise: 0", [](auto& p) { p.length_noise = 0.0; }},
      {"scale_sigma: -1", [](auto& p) { p.scale_sigma = -1.0; }},
      {"shortest_joint: 0", [](auto& p) { p.shortest_joint = 0.0; }},
      {"slip_scale: 0", [](auto& p) { p.alignment.slip_scale = 0.0; }},
  };
  for (const auto& [start, spoil] : cases) {
    LedgerParameters parameters;
    spoil(parameters);
    try {
      parameters.validate();
      ADD_FAILURE() << start << " was accepted";
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), testing::StartsWith(start));
    }
  }
}

}  // namespace
}  // namespace pipescout::odometry
