// SPDX-License-Identifier: Apache-2.0
// What odometers, drivers and crawlers do to the signal: none of it may hurt.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "pipescout/odometry/weld_detector.hpp"
#include "weld_signal.hpp"

namespace pipescout::odometry {
namespace {

using test::Complex;
using test::Crawl;
using test::welds_at;
using testing::DoubleNear;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr double kNoise = 0.05;
constexpr double kClose = 0.003;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(WeldDetectorFaults, BadSamplesAreCountedAndLeftOut) {
  WeldDetector clean({});
  WeldDetector dirty({});
  Crawl a(clean, welds_at({10.0, 20.0}), kNoise, 1);
  Crawl b(dirty, welds_at({10.0, 20.0}), kNoise, 1);
  for (int i = 0; i < 16000; ++i) {
    const double d = 0.0015 * i;
    a.sample(d);
    b.sample(d);
    if (i % 5 == 0) {
      b.sample(d, {kNaN, 0.0});
      b.sample(d, {0.0, -kInfinity});
      b.sample(d, {1e200, 0.0});
      b.sample(kNaN, {0.0, 0.0});
      b.sample(kInfinity, {0.0, 0.0});
      b.sample(-1e15, {0.0, 0.0});
    }
  }
  EXPECT_EQ(a.distances(), b.distances());
  EXPECT_THAT(a.distances(), ElementsAre(DoubleNear(10.0, kClose), DoubleNear(20.0, kClose)));
  EXPECT_EQ(dirty.counts().bad_values, 3U * 3200U);
  EXPECT_EQ(dirty.counts().bad_distances, 3U * 3200U);
  EXPECT_EQ(dirty.counts().samples, 16000U + 6U * 3200U);
  EXPECT_EQ(dirty.counts().cells, clean.counts().cells);
}

TEST(WeldDetectorFaults, NothingButBadSamples) {
  WeldDetector detector({});
  Crawl crawl(detector, welds_at({}), 0.0, 1);
  crawl.finish();
  for (int i = 0; i < 1000; ++i) {
    crawl.sample(kNaN, {kNaN, kNaN});
  }
  crawl.finish();
  crawl.finish();
  EXPECT_THAT(crawl.events(), IsEmpty());
}

TEST(WeldDetectorFaults, AWeldPassedTwiceIsReportedOnce) {
  WeldDetector detector({});
  Crawl crawl(detector, welds_at({10.0, 20.0, 30.0}), kNoise, 2);
  // Turns short of, on and past welds, near and farther away than it remembers.
  for (const double turn : {20.01, 19.0, 20.2, 5.0, 22.0, 19.99, 31.0, 29.9, 35.0, -2.0, 40.0}) {
    crawl.go_to(turn);
  }
  crawl.finish();
  EXPECT_THAT(crawl.distances(), ElementsAre(DoubleNear(10.0, kClose), DoubleNear(20.0, kClose),
                                             DoubleNear(30.0, kClose)));
  EXPECT_GT(detector.counts().revisiting, 0U);
}

TEST(WeldDetectorFaults, AWeldIsReportedAtEachPassWhenAskedFor) {
  WeldDetector detector({.report_again = true});
  Crawl crawl(detector, welds_at({10.0, 20.0}), kNoise, 3);
  crawl.go_to(25.0);
  crawl.go_to(5.0);
  crawl.go_to(15.0);
  crawl.finish();
  EXPECT_THAT(crawl.distances(), ElementsAre(DoubleNear(10.0, kClose), DoubleNear(20.0, kClose),
                                             DoubleNear(20.0, kClose), DoubleNear(10.0, kClose),
                                             DoubleNear(10.0, kClose)));
}

TEST(WeldDetectorFaults, ASlippedReturnDoesNotReportTheLastWeldAgain) {
  WeldDetector detector({});
  // The odometer counts 0.3 m too many on the way back and forth: the weld at 20 m seems to be at
  // 20.3 m.
  bool slipped = false;
  const auto signal = [&](double d) { return welds_at({20.0})(slipped ? d - 0.3 : d); };
  Crawl crawl(detector, signal, kNoise, 4);
  crawl.go_to(20.0 + detector.delay() + 0.05);
  crawl.go_to(10.0);
  slipped = true;
  crawl.go_to(25.0);
  EXPECT_THAT(crawl.distances(), ElementsAre(DoubleNear(20.0, kClose)));
}

TEST(WeldDetectorFaults, AStuckOdometerIsNoPulse) {
  WeldDetector detector({});
  bool stuck = false;
  double moved = 0.0;
  const auto welds = welds_at({10.0, 20.0, 40.0});
  Crawl crawl(
      detector, [&](double d) { return welds(stuck ? moved : d + moved); }, kNoise, 5);
  crawl.go_to(15.0);
  stuck = true;
  for (moved = 15.0; moved < 25.0; moved += 0.0001) {  // the crawler goes on past the second weld
    crawl.sample(15.0);
  }
  stuck = false;
  moved = 10.0;
  crawl.go_to(35.0);
  crawl.finish();
  EXPECT_THAT(crawl.distances(), ElementsAre(DoubleNear(10.0, kClose), DoubleNear(30.0, kClose)));
  EXPECT_GT(detector.counts().surplus, 90000U);
}

TEST(WeldDetectorFaults, DriftOfTheLevelWhileStandingIsNoPulse) {
  WeldDetector detector({});
  double level = 0.0;
  Crawl crawl(
      detector, [&](double d) { return welds_at({50.0})(d) + level; }, kNoise, 6);
  for (double stop = 5.0; stop < 100.0; stop += 5.5) {
    crawl.go_to(stop);
    for (int i = 0; i < 2000; ++i) {
      level += 0.001;
      crawl.sample(stop);
    }
  }
  EXPECT_THAT(crawl.distances(), ElementsAre(DoubleNear(50.0, kClose)));
}

TEST(WeldDetectorFaults, DriftOfTheLevelWhileTurningIsNoPulse) {
  WeldDetector detector({});
  double level = 0.0;
  double rate = 0.0;
  Crawl crawl(
      detector,
      [&](double d) {
        level += rate;
        return welds_at({50.0})(d) + Complex(level, -level);
      },
      kNoise, 16);
  for (double turn = 5.0; turn < 100.0; turn += 5.5) {
    crawl.go_to(turn);
    rate = 0.0005;  // 1.3 after 2 m and back
    crawl.go_to(turn - 2.0);
    crawl.go_to(turn);
    rate = 0.0;
  }
  EXPECT_THAT(crawl.distances(), ElementsAre(DoubleNear(50.0, kClose)));
}

TEST(WeldDetectorFaults, AnOutlierOfTheOdometerIsLeftOut) {
  WeldDetector detector({});
  Crawl crawl(detector, welds_at({10.0, 20.0}), kNoise, 7);
  for (int i = 0; i < 16000; ++i) {
    crawl.sample(0.0015 * i);
    if (i % 97 == 0) {
      crawl.sample(0.0015 * i + 500.0, {0.06, 0.02});  // no spike
      crawl.sample(-700.0, {0.05, 0.04});
    }
  }
  EXPECT_THAT(crawl.distances(), ElementsAre(DoubleNear(10.0, kClose), DoubleNear(20.0, kClose)));
  EXPECT_GE(detector.counts().outliers, 2U * 165U - 20U);  // some are taken for spikes
  EXPECT_LE(detector.counts().outliers, 2U * 165U);
  EXPECT_EQ(detector.counts().jumps, 0U);
}

TEST(WeldDetectorFaults, PipeThatWasNotSeenIsAGap) {
  WeldDetector detector({});
  Crawl crawl(detector, welds_at({10.0, 20.0, 30.0}), kNoise, 8);
  crawl.go_to(15.0);
  crawl.sample(22.0);
  crawl.go_to(25.0);
  crawl.go_to(12.0);  // back over what is known
  crawl.go_to(35.0);
  EXPECT_THAT(crawl.distances(), ElementsAre(DoubleNear(10.0, kClose), DoubleNear(30.0, kClose)));
  EXPECT_EQ(detector.counts().jumps, 1U);
  EXPECT_GE(detector.counts().gaps, 1U);
}

TEST(WeldDetectorFaults, ANewOriginBeginsANewCount) {
  WeldDetector detector({});
  Crawl crawl(detector, welds_at({10.0, 20.0, 4020.0}), kNoise, 9);
  crawl.go_to(25.0);
  crawl.sample(4000.0);
  crawl.go_to(4025.0);
  crawl.sample(0.0);
  crawl.go_to(25.0);
  EXPECT_THAT(crawl.distances(), ElementsAre(DoubleNear(10.0, kClose), DoubleNear(20.0, kClose),
                                             DoubleNear(4020.0, kClose), DoubleNear(10.0, kClose),
                                             DoubleNear(20.0, kClose)));
  EXPECT_EQ(detector.counts().jumps, 2U);
}

TEST(WeldDetectorFaults, AWeldInAGapIsIncomplete) {
  WeldDetector detector({});
  Crawl crawl(detector, welds_at({10.0, 20.0}), kNoise, 10);
  crawl.go_to(9.99);
  crawl.sample(10.04);
  crawl.go_to(25.0);
  EXPECT_THAT(crawl.distances(), ElementsAre(DoubleNear(20.0, kClose)));
}

TEST(WeldDetectorFaults, FrozenValuesAreNoPulse) {
  WeldDetector detector({});
  Crawl crawl(
      detector, [](double d) { return welds_at({50.0})(d) + Complex(2.0, -1.0); }, kNoise, 11);
  for (int i = 0; i < 60000; ++i) {
    const double d = 0.0015 * i;
    if (i % 1000 < 20 && i > 100 && std::abs(d - 50.0) > 0.1) {
      crawl.sample(d, i % 2000 < 1000 ? Impedance{0.0, 0.0} : Impedance{2.1, -1.1});
    } else {
      crawl.sample(d);
    }
  }
  EXPECT_THAT(crawl.distances(), ElementsAre(DoubleNear(50.0, kClose)));
  EXPECT_EQ(detector.counts().frozen, 59U * 20U);
}

TEST(WeldDetectorFaults, SpikesAreTakenOutAndWeldsAreNot) {
  WeldDetector detector({});
  std::vector<double> welds;
  for (double at = 5.0; at < 100.0; at += 12.0) {
    welds.push_back(at);
  }
  Crawl crawl(detector, welds_at(welds), kNoise, 12);
  for (int i = 0; i < 70000; ++i) {
    const double d = 0.0015 * i;
    if (i % 500 < 2) {
      crawl.sample(d, {i % 500 == 0 ? 5.0 : -3.0, 2.0});
    } else {
      crawl.sample(d);
    }
  }
  EXPECT_THAT(crawl.distances(), testing::Pointwise(DoubleNear(kClose), welds));
  EXPECT_GE(detector.counts().spikes, 270U);
  EXPECT_LE(detector.counts().spikes, 300U);
}

TEST(WeldDetectorFaults, SpikesThatRingAreNoPulses) {
  for (std::uint64_t seed = 20; seed < 25; ++seed) {
    WeldDetector detector({});
    std::mt19937_64 engine(seed);
    std::normal_distribution<double> noise(0.0, kNoise);
    Crawl crawl(detector, welds_at({50.0}), 0.0, 1);
    for (int i = 0; i < 40000; ++i) {
      const double d = 0.003 * i;
      Complex value = welds_at({50.0})(d) + Complex(noise(engine), noise(engine));
      if (i % 100 < 3 && std::abs(d - 50.0) > 0.1) {  // over three samples, with changing sign
        value += Complex(1.0, -0.7) * (1.0 + 0.001 * (i % 977)) * std::pow(-0.5, i % 100);
      }
      crawl.sample(d, {value.real(), value.imag()});
    }
    EXPECT_THAT(crawl.distances(), ElementsAre(DoubleNear(50.0, kClose))) << seed;
  }
}

TEST(WeldDetectorFaults, ALoneZeroAtTheStartOfADropoutIsLeftOut) {
  // A level that is no spike beside zero: only the samples that repeat the zero give it away.
  WeldDetector detector({});
  const Complex level(0.12, 0.12);
  Crawl crawl(
      detector, [&](double d) { return welds_at({50.0})(d) + level; }, kNoise, 18);
  for (int i = 0; i < 40000; ++i) {
    const double d = 0.0025 * i;
    if (i % 200 < 7 && std::abs(d - 50.0) > 0.1) {
      crawl.sample(d, {0.0, 0.0});
    } else {
      crawl.sample(d);
    }
  }
  EXPECT_THAT(crawl.distances(), ElementsAre(DoubleNear(50.0, kClose)));
  EXPECT_EQ(detector.counts().frozen, 7U * 199U);  // one falls on the weld
}

TEST(WeldDetectorFaults, ANoiselessSignalIsNoTrouble) {
  WeldDetector detector({.noise_floor = 1e-4, .frozen_after = 0});
  Crawl crawl(detector, welds_at({10.0, 20.0}), 0.0, 13);
  crawl.go_to(25.0);
  EXPECT_THAT(crawl.distances(), ElementsAre(DoubleNear(10.0, 0.0005), DoubleNear(20.0, 0.0005)));
}

TEST(WeldDetectorFaults, ACoarseOdometerIsNoTrouble) {
  WeldDetector detector({});
  const auto welds = welds_at({10.0, 20.0});
  Crawl crawl(detector, welds, kNoise, 14);
  for (int i = 0; i < 50000; ++i) {
    const double d = 0.0005 * i;
    const Complex value = welds(d);
    const double tick = 0.002 * std::floor(d / 0.002);  // 1 mm short on average
    crawl.sample(tick, {value.real() + 0.05 * std::sin(i * 1.7), value.imag()});
  }
  EXPECT_THAT(crawl.distances(),
              ElementsAre(DoubleNear(9.999, kClose), DoubleNear(19.999, kClose)));
}

}  // namespace
}  // namespace pipescout::odometry
