// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/crawler.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace pipescout::simulation {
namespace {

const JointedPipeParameters kLevel{
    .joints = 20, .length_spread = 0.0, .bend_share = 0.0, .slope_share = 0.0};

/// 200 m at 0.5 m/s, 12 m back, stop.
Motion there_and_back() {
  return Motion({{.speed = 0.5, .duration = 400.0},
                 {.speed = -0.5, .duration = 30.0},
                 {.speed = 0.0, .duration = 20.0}},
                0.25);
}

std::vector<WheelSample> run(Crawler& crawler) {
  std::vector<WheelSample> samples;
  while (const auto sample = crawler.next()) {
    samples.push_back(*sample);
  }
  return samples;
}

Crawler make(const WheelParameters& wheel, std::vector<WheelFault> faults = {}) {
  return Crawler(JointedPipe(kLevel, 1), there_and_back(), {.wheels = {wheel}}, 1,
                 std::move(faults));
}

TEST(Crawler, APerfectWheelShowsTheIntegralOfSpeed) {
  Crawler crawler = make({.resolution = 1e-9, .counter_start = 7.0});
  for (const WheelSample& sample : run(crawler)) {
    EXPECT_NEAR(sample.value, 7.0 + crawler.motion().distance(sample.time), 2e-9);
    EXPECT_EQ(sample.distance, crawler.motion().distance(sample.time));
    EXPECT_EQ(sample.speed, crawler.motion().speed(sample.time));
  }
}

TEST(Crawler, CountingIsOffByLessThanOneStep) {
  Crawler crawler = make({.resolution = 0.01});
  for (const WheelSample& sample : run(crawler)) {
    EXPECT_GT(sample.distance - sample.value, -1e-9);
    EXPECT_LT(sample.distance - sample.value, 0.01 + 1e-9);
    EXPECT_NEAR(std::remainder(sample.value, 0.01), 0.0, 1e-9);
  }
}

TEST(Crawler, IncrementsAddUpToTheCounter) {
  Crawler crawler = make({.incremental = true, .resolution = 0.001, .counter_start = 5.0});
  double sum = 0.0;
  for (const WheelSample& sample : run(crawler)) {
    sum += sample.value;
    EXPECT_NEAR(sum, sample.distance, 0.001 + 1e-9);
  }
}

TEST(Crawler, WearIsTheIntegralOfAScaleThatGrowsWithThePath) {
  Crawler crawler = make({.resolution = 1e-9, .scale_error = 0.01, .wear_per_metre = 1e-4});
  const auto turned = [](double path) { return 1.01 * path + 0.5e-4 * path * path; };
  const Motion motion = there_and_back();
  const double forward = motion.path(402.0);  // where it turns
  for (const WheelSample& sample : run(crawler)) {
    const double expected =
        sample.path <= forward ? turned(sample.path) : 2.0 * turned(forward) - turned(sample.path);
    EXPECT_NEAR(sample.value, expected, 1e-7);
  }
}

TEST(Crawler, FaultsLoseTheirShareOfTheirLength) {
  // The second begins within the first, the third sticks on the way back.
  Crawler crawler =
      make({.resolution = 1e-9},
           {{.begin = 50.0, .length = 10.0, .ratio = 0.3},
            {.begin = 55.0, .length = 2.0, .ratio = 0.5},
            {.kind = WheelFaultKind::kStick, .begin = 205.0, .length = 4.0, .ratio = 1.0}});
  const double lost = 0.3 * 8.0 + (1.0 - 0.7 * 0.5) * 2.0;
  for (const WheelSample& sample : run(crawler)) {
    if (sample.path < 50.0) {
      EXPECT_NEAR(sample.value, sample.distance, 2e-9);
    } else if (sample.path > 60.0 && sample.path < 205.0) {
      EXPECT_NEAR(sample.value, sample.distance - lost, 1e-8);
    } else if (sample.path > 209.0) {
      EXPECT_NEAR(sample.value, sample.distance - lost + 4.0, 1e-8);
    }
  }
}

TEST(Crawler, AStuckWheelStandsStill) {
  Crawler crawler =
      make({}, {{.kind = WheelFaultKind::kStick, .begin = 20.0, .length = 5.0, .ratio = 1.0}});
  std::set<double> shown;
  for (const WheelSample& sample : run(crawler)) {
    if (sample.path > 20.0 && sample.path < 25.0) {
      shown.insert(sample.value);
    }
  }
  EXPECT_EQ(shown.size(), 1U);
}

TEST(Crawler, NoiseIsARandomWalkAlongThePath) {
  double squares = 0.0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    Crawler crawler(JointedPipe(kLevel, 1), Motion({{.speed = 0.5, .duration = 100.0}}, 0.25),
                    {.wheels = {{.period = 1.0, .resolution = 1e-9, .noise_per_sqrt_metre = 0.02}}},
                    seed);
    const auto samples = run(crawler);
    squares += std::pow(samples.back().value - samples.back().distance, 2);
  }
  const double path = 0.5 * 100.0 - 0.5;
  EXPECT_NEAR(std::sqrt(squares / 400.0), 0.02 * std::sqrt(path), 0.1 * 0.02 * std::sqrt(path));
}

TEST(Crawler, GravityTakesUphillAndGivesDownhill) {
  const JointedPipe pipe({.joints = 20, .bend_share = 0.0, .slope_share = 1.0}, 3);
  Crawler crawler(pipe, Motion({{.speed = 0.5, .duration = 400.0}}, 0.25),
                  {.wheels = {{.resolution = 1e-9, .gravity_slip = 0.1}}}, 1);
  for (const WheelSample& sample : run(crawler)) {
    // The integral of the sine of the slope is the height.
    EXPECT_NEAR(sample.value, sample.distance - 0.1 * pipe.position(sample.distance)[2], 1e-5);
  }
}

TEST(Crawler, RatesStartsDropsAndNaNAreAsStated) {
  Crawler crawler(JointedPipe(kLevel, 1), there_and_back(),
                  {.wheels = {{.period = 0.02, .start = 0.007, .dropped_share = 0.1},
                              {.period = 0.05, .nan_share = 0.05},
                              {.period = 1.0, .start = 100.0}}},
                  9);
  std::map<std::size_t, std::vector<WheelSample>> of;
  double before = 0.0;
  for (const WheelSample& sample : run(crawler)) {
    EXPECT_GE(sample.time, before);
    before = sample.time;
    of[sample.wheel].push_back(sample);
  }
  EXPECT_NEAR(static_cast<double>(of[0].size()), 0.9 * 22500.0, 4.0 * std::sqrt(22500.0 * 0.09));
  EXPECT_NEAR(std::remainder(of[0].back().time - 0.007, 0.02), 0.0, 1e-9);
  EXPECT_EQ(of[1].size(), 9001U);
  const auto nans = std::count_if(of[1].begin(), of[1].end(), [](const WheelSample& sample) {
    return std::isnan(sample.value);
  });
  EXPECT_NEAR(static_cast<double>(nans), 450.0, 4.0 * std::sqrt(9001.0 * 0.0475));
  EXPECT_EQ(of[2].size(), 351U);
  EXPECT_EQ(of[2].front().time, 100.0);
}

TEST(Crawler, FaultsComeOneAtATimeUnlessTwoTogetherAreAsked) {
  const Motion motion({{.speed = 1.0, .duration = 20000.0}}, 0.25);
  CrawlerParameters parameters{
      .wheels = std::vector<WheelParameters>(3), .slip_spacing = 100.0, .stick_spacing = 400.0};
  const auto draw = [&] { return Crawler(JointedPipe(kLevel, 1), motion, parameters, 5).faults(); };
  const auto alone = draw();
  double over = 0.0;
  int sticks = 0;
  std::array<int, 3> of{};
  for (const WheelFault& fault : alone) {
    EXPECT_GE(fault.begin, over);
    over = fault.begin + fault.length;
    ++of[fault.wheel];
    if (fault.kind == WheelFaultKind::kStick) {
      ++sticks;
      EXPECT_EQ(fault.ratio, 1.0);
    } else {
      EXPECT_GE(fault.ratio, 0.05);
      EXPECT_LE(fault.ratio, 0.3);
      EXPECT_GE(fault.length, 1.0);
      EXPECT_LE(fault.length, 10.0);
    }
  }
  // Spaced by 80 m, 5 m long.
  EXPECT_NEAR(static_cast<double>(alone.size()), 20000.0 / 85.0, 50.0);
  EXPECT_NEAR(sticks, 0.2 * static_cast<double>(alone.size()), 25.0);
  for (const int count : of) {
    EXPECT_GT(count, 50);
  }

  parameters.slip_together_share = 1.0;
  parameters.stick_spacing = 0.0;
  const auto together = draw();
  ASSERT_EQ(together.size() % 2, 0U);
  for (std::size_t i = 0; i < together.size(); i += 2) {
    EXPECT_EQ(together[i].begin, together[i + 1].begin);
    EXPECT_EQ(together[i].ratio, together[i + 1].ratio);
    EXPECT_NE(together[i].wheel, together[i + 1].wheel);
  }
}

TEST(Crawler, PassesWeldsWhenTheDistanceReachesThem) {
  const Crawler crawler(JointedPipe({.joints = 10}, 2),
                        Motion({{.speed = 0.5, .duration = 50.0},
                                {.speed = -0.5, .duration = 20.0},
                                {.speed = 0.5, .duration = 300.0}},
                               0.25),
                        {.wheels = {{}}}, 1);
  const auto times = crawler.weld_times();
  ASSERT_EQ(times.size(), 11U);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_NEAR(crawler.motion().distance(times[i]), crawler.pipe().joints()[i].begin, 1e-6);
    EXPECT_LT(times[i], times[i + 1]);
  }
}

TEST(Crawler, TheSameSeedGivesTheSameBits) {
  const CrawlerParameters parameters{
      .wheels = std::vector<WheelParameters>(3, {.noise_per_sqrt_metre = 0.01}),
      .slip_spacing = 30.0};
  const auto last = [&](std::uint64_t seed) {
    Crawler crawler(JointedPipe(kLevel, 1), there_and_back(), parameters, seed);
    return run(crawler).back().value;
  };
  EXPECT_EQ(last(1), last(1));
  EXPECT_NE(last(1), last(2));
}

TEST(Crawler, RefusesWhatIsOutOfRange) {
  const auto refusal = [](const CrawlerParameters& parameters,
                          std::vector<WheelFault> faults = {}) {
    try {
      Crawler(JointedPipe(kLevel, 1), there_and_back(), parameters, 1, std::move(faults));
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refusal({}), "wheels: 0 is outside [1, 64]");
  EXPECT_EQ(refusal({.wheels = {{.period = 0.0}}}), "wheels[0].period: 0 is outside (0, inf]");
  EXPECT_EQ(refusal({.wheels = {{}}, .slip_least = 0.4}), "slip_most: 0.3 is outside [0.4, 1]");
  EXPECT_EQ(refusal({.wheels = {{}}}, {{.wheel = 1}}), "faults[0].wheel: 1 is outside [0, 0]");
  EXPECT_EQ(refusal({.wheels = {{}}}, {{.ratio = 2.0}}), "faults[0].ratio: 2 is outside [0, 1]");
}

}  // namespace
}  // namespace pipescout::simulation
