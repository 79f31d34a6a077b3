// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry_study/crawler_run.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace pipescout::odometry_study {
namespace {

CrawlerRunSettings short_run() {
  CrawlerRunSettings settings;
  settings.joints = 100;
  settings.run_length = 600.0;
  return settings;
}

TEST(CrawlerRun, IncrementsAddUpToTheDistanceAndWeldsLieWhereTheyAre) {
  CrawlerRunSettings settings = short_run();
  // Perfect wheels, a perfect detector.
  settings.wheel_noise = settings.radius_error = settings.common_scale_error = settings.wear = 0.0;
  settings.stated_noise_part = 1.0;
  settings.slip_most = 0.0;
  settings.missed = settings.spurious = settings.weld_sigma = 0.0;
  settings.wheel_noise = 1e-6;  // a fusion takes no odometer for perfect
  for (const bool backward : {false, true}) {
    settings.backward = backward;
    const CrawlerRun run = simulate_crawler_run(settings, 1);
    const double facing = backward ? -1.0 : 1.0;
    double odometer = 0.0;
    std::size_t welds = 0;
    for (const auto& event : run.events) {
      if (!event.is_weld) {
        odometer += event.increment.distance;
        ASSERT_NEAR(run.start + facing * odometer, event.place, 0.004);
        continue;
      }
      ++welds;
      const double place = run.start + facing * event.weld.odometer_distance;
      const auto near = std::lower_bound(run.welds.begin(), run.welds.end(), place - 0.006);
      ASSERT_NE(near, run.welds.end());
      ASSERT_NEAR(*near, place, 0.006);
      ASSERT_EQ(event.joints_passed, welds);
    }
    EXPECT_NEAR(odometer, settings.run_length, 1.0);
    EXPECT_NEAR(static_cast<double>(welds), settings.run_length / settings.joint_length, 2.0);
  }
}

TEST(CrawlerRun, IsTheSameForTheSameSeed) {
  const CrawlerRun a = simulate_crawler_run(short_run(), 7);
  const CrawlerRun b = simulate_crawler_run(short_run(), 7);
  const CrawlerRun other = simulate_crawler_run(short_run(), 8);
  ASSERT_EQ(a.events.size(), b.events.size());
  for (std::size_t i = 0; i < a.events.size(); ++i) {
    ASSERT_EQ(a.events[i].is_weld, b.events[i].is_weld);
    if (!a.events[i].is_weld) {
      ASSERT_EQ(a.events[i].increment.distance, b.events[i].increment.distance);
    }
  }
  EXPECT_NE(a.start, other.start);
}

TEST(CrawlerRun, TwoWheelsSlippingTogetherAreBelievedOrDoubted) {
  CrawlerRunSettings settings = short_run();
  settings.double_slips = 5;
  settings.common_scale_error = settings.wear = 0.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const CrawlerRun run = simulate_crawler_run(settings, seed);
    ASSERT_EQ(run.double_slips.size(), 5U);
    double lost = 0.0;
    for (const DoubleSlip& slip : run.double_slips) {
      EXPECT_LE(slip.begin, slip.end);
      lost += slip.lost;
    }
    double odometer = 0.0;
    for (const auto& event : run.events) {
      odometer += event.is_weld ? 0.0 : event.increment.distance;
    }
    EXPECT_NEAR(odometer + lost, std::abs(run.events.back().place - run.start), 0.25 * lost + 1.5);
  }
}

TEST(CrawlerRun, WeldsOfTheTallyAreThoseOfThePipe) {
  CrawlerRunSettings settings = short_run();
  settings.missing_joints = settings.extra_joints = 0.05;
  const CrawlerRun run = simulate_crawler_run(settings, 3);
  ASSERT_EQ(run.weld_of_tally.size(), run.tally.size() + 1);
  std::size_t none = 0;
  for (std::size_t i = 0; i < run.tally.size(); ++i) {
    if (run.weld_of_tally[i] < 0) {
      ++none;
      continue;
    }
    const auto weld = static_cast<std::size_t>(run.weld_of_tally[i]);
    EXPECT_NEAR(run.welds[weld + 1] - run.welds[weld], run.tally[i].length, 0.06);
  }
  EXPECT_GT(none, 0U);
}

}  // namespace
}  // namespace pipescout::odometry_study
