// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking/shape_tracker.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <vector>

#include "tracked_pictures.hpp"

namespace pipescout::tracking {
namespace {

using test::kFrame;
using test::kImage;
using test::Pictures;
using test::region_of;
using test::wrapped;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using State = PipeShape::State;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(PipeTracker, LocksOnAndFollows) {
  Pictures pictures;
  std::mt19937_64 engine(1);
  std::normal_distribution<double> noise(0, 0.4);
  for (int i = 0; i < 200; ++i) {
    const double t = kFrame * i;
    const State truth(160 + 40 * std::sin(3 * t), 120 + 25 * std::sin(5 * t),
                      120 + 10 * std::sin(t), 0.3 * std::sin(2 * t));
    PipeRegion region = region_of(truth);
    for (auto* point : {&region.start, &region.end}) {
      *point += Eigen::Vector2d(noise(engine), noise(engine));
    }
    const PipeTrack& track = pictures.show({region});
    EXPECT_EQ(track.state, i < 2 ? TrackState::kDetecting : TrackState::kLocked) << i;
    if (i < 20) {
      continue;
    }
    EXPECT_EQ(track.number, 1U);
    EXPECT_EQ(track.region, 0U);
    EXPECT_GT(track.confidence, 0.99);
    EXPECT_LT((track.estimate - truth).head<2>().norm(), 2) << i;
    EXPECT_LT(std::abs(track.estimate[3] - truth[3]), 0.02) << i;
    EXPECT_NEAR(track.rate.x(), 120 * std::cos(3 * t), 60) << i;
    EXPECT_NEAR(track.rate.y(), 125 * std::cos(5 * t), 60) << i;
    for (const State& estimate : {track.best_particle, track.robust_mean, track.weighted_mean}) {
      EXPECT_LT((estimate - truth).head<2>().norm(), 6) << i;
    }
  }
}

TEST(PipeTracker, CovarianceCoversTheError) {
  Pictures pictures;
  std::mt19937_64 engine(2);
  // As PipeShape has it of outlines and ends.
  const PipeShape shape;
  std::normal_distribution<double> along(0, shape.end_deviation);
  std::normal_distribution<double> across(0, shape.edge_deviation);
  double squares = 0;
  constexpr int kPictures = 2000;
  const State truth(160, 120, 150, 0.5);
  const Eigen::Vector2d u(std::cos(0.5), std::sin(0.5));
  for (int i = 0; i < kPictures; ++i) {
    PipeRegion region = region_of(truth);
    region.start += along(engine) * u + across(engine) * Eigen::Vector2d(-u.y(), u.x());
    region.end += along(engine) * u + across(engine) * Eigen::Vector2d(-u.y(), u.x());
    const PipeTrack& track = pictures.show({region});
    const State error = track.estimate - truth;
    squares += error.dot(track.covariance.inverse() * error);
  }
  // 4 on average, if the pipe moved as the parameters have it; it stands still.
  EXPECT_LT(squares / kPictures, 6);
  EXPECT_GT(squares / kPictures, 1);
}

TEST(PipeTracker, CoastsThroughGapsAndIsLostThen) {
  Pictures pictures;
  State truth(100, 120, 100, 0.1);
  for (int i = 0; i < 50; ++i) {
    truth.x() += 2;
    pictures.show({region_of(truth)});
  }
  for (int i = 0; i < 10; ++i) {
    truth.x() += 2;
    const PipeTrack& track = pictures.show({});
    EXPECT_EQ(track.state, TrackState::kCoasting);
    EXPECT_LT((track.estimate - truth).head<2>().norm(), 8);
    EXPECT_FALSE(track.region);
  }
  double confidence = pictures.track().confidence;
  double deviation = pictures.track().covariance(0, 0);
  while (pictures.track().since_seen < pictures.tracker.parameters().max_coast) {
    pictures.show({});
    EXPECT_LT(pictures.track().confidence, confidence);
    EXPECT_GE(pictures.track().covariance(0, 0), deviation);
    confidence = pictures.track().confidence;
  }
  EXPECT_EQ(pictures.show({}).state, TrackState::kLost);
  EXPECT_EQ(pictures.track().number, 1U);
  // Where it is expected, it is the same.
  const PipeTrack& again = pictures.show({region_of(pictures.track().estimate)});
  EXPECT_EQ(again.state, TrackState::kLocked);
  EXPECT_EQ(again.number, 1U);
}

TEST(PipeTracker, AfterALongTimeAnyPipeIsTakenAsAnother) {
  Pictures pictures;
  pictures.show_often({region_of({100, 60, 100, 0})}, 10);
  const State other(200, 150, 100, 1.2);
  int taken = 0;
  double lost_for = 0;
  for (int i = 0; i < 200 && taken == 0; ++i) {
    const PipeTrack& track = pictures.show({region_of(other)});
    lost_for = track.since_seen;
    taken = track.number == 2 ? i : 0;
  }
  EXPECT_NEAR(kFrame * taken, 1.5 + 3.0, 0.3);
  EXPECT_EQ(pictures.track().state, TrackState::kLocked);
  EXPECT_LT((pictures.track().estimate - other).norm(), 2);
  EXPECT_EQ(lost_for, 0);
}

TEST(PipeTracker, IsTakenUpAgainWhereThePoseHasIt) {
  Pictures pictures;
  pictures.show_often({region_of({100, 60, 100, 0})}, 10);
  while (pictures.track().state != TrackState::kLost) {
    pictures.show({});
  }
  const State there(200, 180, 110, 0.4);
  const TrackHint<PipeShape> hint{.shape = {190, 185, 100, 0.35}, .deviation = {10, 10, 20, 0.05}};
  // A longer one elsewhere is not what the pose tells of.
  const PipeTrack& track =
      pictures.show({region_of({160, 20, 300, 0}), region_of(there)}, {.hint = hint});
  EXPECT_EQ(track.state, TrackState::kLocked);
  EXPECT_EQ(track.number, 1U);
  EXPECT_EQ(track.region, 1U);
  EXPECT_LT((track.estimate - there).norm(), 5);
}

TEST(PipeTracker, BeginsWhereThePoseHasIt) {
  Pictures pictures;
  const TrackHint<PipeShape> hint{.shape = {190, 185, 100, 0.35}, .deviation = {10, 10, 20, 0.05}};
  EXPECT_EQ(pictures.show({region_of({160, 20, 300, 0})}, {.hint = hint}).number, 0U);
  for (int i = 0; i < 5; ++i) {
    pictures.show({region_of({160, 20, 300, 0}), region_of({192, 180, 110, 0.36})}, {.hint = hint});
  }
  EXPECT_EQ(pictures.track().state, TrackState::kLocked);
  EXPECT_EQ(pictures.track().region, 1U);
}

TEST(PipeTracker, LengthIsNotShrunkWhenEndsLeaveThePicture) {
  Pictures pictures;
  State truth(160, 120, 200, 0.2);
  for (int i = 0; i < 60; ++i) {
    truth.x() += 3;
    const PipeTrack& track = pictures.show_in_view(truth);
    ASSERT_EQ(track.start_censored, false);
    const auto view = PipeShape::in_view(truth, kImage);
    if (i > 5) {
      EXPECT_EQ(track.end_censored, view.end_censored) << i;
      EXPECT_NEAR(track.whole[2], 200, 3) << i;
      EXPECT_LT((track.whole - truth).head<2>().norm(), 3) << i;
      EXPECT_NEAR(track.estimate[2], view.shape[2], 3) << i;
    }
  }
  EXPECT_LT(pictures.track().estimate[2], 80);
  for (int i = 0; i < 60; ++i) {
    truth.x() -= 3;
    pictures.show_in_view(truth);
  }
  EXPECT_FALSE(pictures.track().end_censored);
  EXPECT_NEAR(pictures.track().whole[2], 200, 3);
}

TEST(PipeTracker, APipeWithoutEndsInThePictureHasOnlyItsLine) {
  Pictures pictures;
  for (int i = 0; i < 500; ++i) {
    const double t = kFrame * i;
    const State truth(160, 120 + 30 * std::sin(3 * t), 5000, 0.2 * std::sin(2 * t));
    const PipeTrack& track = pictures.show_in_view(truth);
    const auto view = PipeShape::in_view(truth, kImage);
    if (i < 10) {
      continue;
    }
    ASSERT_TRUE(track.start_censored && track.end_censored) << i;
    EXPECT_LT((track.estimate - view.shape).head<2>().norm(), 2) << i;
    EXPECT_NEAR(track.estimate[2], view.shape[2], 3) << i;
    ASSERT_LT(track.whole[2], 3000) << "nothing is claimed of what is far outside";
  }
}

TEST(PipeTracker, AnEndHiddenByAPostIsNotTheEnd) {
  Pictures pictures;
  const State truth(160, 120, 200, 0);
  pictures.show_often({region_of(truth)}, 30);
  const PipeRegion before{.start = {60, 120}, .end = {150, 120}, .half_width = 6};
  const PipeRegion behind{.start = {170, 120}, .end = {260, 120}, .half_width = 6};
  for (int i = 0; i < 10; ++i) {
    const PipeTrack& track = pictures.show({before, behind});
    EXPECT_EQ(track.state, TrackState::kLocked);
    EXPECT_LT((track.whole - truth).norm(), 6) << i;
  }
  // Only one of the parts.
  for (int i = 0; i < 5; ++i) {
    EXPECT_LT((pictures.show({before}).whole - truth).norm(), 10) << i;
  }
}

/// A post came into view while the camera calibrated itself, and passes.
TEST(PipeTracker, APipeOnBothSidesOfAPostIsOne) {
  Pictures pictures;
  const auto piece = [](double from, double to) {
    return PipeRegion{.start = {from, 120}, .end = {to, 120}, .half_width = 6};
  };
  pictures.show_often({piece(0, 319)}, 30);
  pictures.show({});
  pictures.show({piece(0, 237)});
  for (double post = 200; post > 70; post -= 30) {
    const PipeTrack& track = pictures.show({piece(0, post), piece(post + 60, 319)});
    EXPECT_NEAR(track.estimate[0], 159.5, 2) << post;
    EXPECT_NEAR(track.estimate[2], 319, 4) << post;
    EXPECT_LT((track.robust_mean - track.estimate).head<2>().norm(), 8) << post;
  }
}

TEST(PipeTracker, AxesHaveNoHeadAndTail) {
  Pictures pictures;
  for (int i = 0; i < 300; ++i) {
    const State truth(160, 120, 100, wrapped(0.03 * i));
    PipeRegion region = region_of(truth);
    if (i % 2 == 1) {
      std::swap(region.start, region.end);
    }
    const PipeTrack& track = pictures.show({region});
    EXPECT_LT(std::abs(wrapped(track.estimate[3] - truth[3])), 0.03) << i;
    EXPECT_LE(std::abs(track.estimate[3]), std::numbers::pi / 2 + 1e-9);
    EXPECT_EQ(track.number, i < 2 ? 0U : 1U) << i;
    if (i > 20) {
      EXPECT_NEAR(track.rate[3], 0.03 / kFrame, 0.15) << i;
    }
  }
}

TEST(PipeTracker, CrossingPipesAreNotSwapped) {
  Pictures pictures;
  for (int i = 0; i < 120; ++i) {
    const State target(160, 120, 200, 0.3);
    const State other(40 + 2.0 * i, 120, 180, -0.3);
    // Where they cross the other one hides it now and then.
    std::vector<PipeRegion> regions{region_of(other)};
    if (i < 50 || i > 70) {
      regions.insert(i % 2 == 0 ? regions.begin() : regions.end(), region_of(target));
    }
    if (i == 0) {
      regions = {region_of(target)};
    }
    const PipeTrack& track = pictures.show(regions);
    ASSERT_LE(track.number, 1U);
    if (i > 5) {
      EXPECT_LT(std::abs(track.estimate[3] - 0.3), 0.1) << i;
      EXPECT_LT((track.estimate - target).head<2>().norm(), 4) << i;
    }
  }
}

TEST(PipeTracker, AParallelPipeDoesNotTakeThePlaceOfAHiddenOne) {
  Pictures pictures;
  const auto target = [](int i) { return State(160, 110 + 20 * std::sin(0.1 * i), 250, 0.1); };
  const auto other = [&target](int i) { return State(target(i) + State(0, 18, 0, 0)); };
  for (int i = 0; i < 60; ++i) {
    pictures.show({region_of(target(i)), region_of(other(i))});
  }
  ASSERT_LT((pictures.track().estimate - target(59)).norm(), 3);
  for (int i = 60; i < 85; ++i) {
    const PipeTrack& track = pictures.show({region_of(other(i))});
    EXPECT_EQ(track.state, TrackState::kCoasting) << i;
    EXPECT_EQ(track.number, 1U);
  }
}

TEST(PipeTracker, CloseParallelPipesAreToldApartWhileBothAreSeen) {
  Pictures pictures;
  std::mt19937_64 engine(3);
  std::normal_distribution<double> noise(0, 0.4);
  double above = 0;  // of the track, against the middle between them: whose it was at first
  for (int i = 0; i < 300; ++i) {
    const State target(160, 110 + 15 * std::sin(0.15 * i), 250, 0.1);
    PipeRegion a = region_of(target);
    PipeRegion b = region_of(target + State(0, 14, 0, 0));
    for (auto* point : {&a.start, &a.end, &b.start, &b.end}) {
      point->y() += noise(engine);
    }
    const PipeTrack& track = i % 2 == 0 ? pictures.show({a, b}) : pictures.show({b, a});
    const double side = track.estimate.y() - target.y() - 7;
    above = i == 0 ? side : above;
    EXPECT_GT(side * above, 0) << i;
    EXPECT_NEAR(std::abs(side), 7, 3) << i;
    EXPECT_LE(track.number, 1U);
  }
}

TEST(PipeTracker, TheParticlesTakeItAlongWhenThePictureJumps) {
  Pictures pictures;
  pictures.show_often({region_of({160, 100, 5000, 0})}, 30);
  State after(160, 175, 5000, 0.05);
  int pictures_needed = 0;
  while (pictures.show_in_view(after).state != TrackState::kLocked && pictures_needed < 20) {
    ++pictures_needed;
  }
  EXPECT_LT(pictures_needed, 10);
  EXPECT_EQ(pictures.track().number, 1U);
  EXPECT_NEAR(pictures.track().estimate.y(), 175, 3);
}

TEST(PipeTracker, MotionOfTheCameraCarriesItThroughAGap) {
  Pictures with;
  Pictures without;
  ImageMotion motion;
  State truth(160, 120, 200, 0);
  double error_with = 0;
  double error_without = 0;
  for (int i = 0; i < 70; ++i) {
    const double t = kFrame * i;
    motion.at = truth.head<2>();
    motion.velocity = {0, 300 * std::cos(8 * t)};
    truth.y() = 120 + 300.0 / 8 * std::sin(8 * (t + kFrame / 2));
    const std::vector<PipeRegion> regions =
        i < 50 ? std::vector{region_of(truth)} : std::vector<PipeRegion>{};
    with.show(regions, {.motion = motion});
    without.show(regions);
    if (i >= 50) {
      error_with = std::max(error_with, (with.track().estimate - truth).norm());
      error_without = std::max(error_without, (without.track().estimate - truth).norm());
    }
  }
  EXPECT_LT(error_with, 5);
  EXPECT_GT(error_without, 20);
}

TEST(PipeTracker, ALongPipeThatPassesByEndsInThePicture) {
  // Without its motion being told: its end comes into view, 400 px/s along it.
  Pictures pictures;
  for (int i = 0; i < 60; ++i) {
    const State truth(160 - 2000 - 16.0 * (i - 45) + 160, 120, 4000, 0);
    const PipeTrack& track = pictures.show_in_view(truth);
    ASSERT_EQ(track.state, i < 2 ? TrackState::kDetecting : TrackState::kLocked) << i;
    const auto view = PipeShape::in_view(truth, kImage);
    if (i > 55) {
      EXPECT_NEAR(track.estimate[2], view.shape[2], 8) << i;
    }
  }
}

TEST(PipeTracker, AnotherResolutionIsTheSameScene) {
  Pictures pictures;
  const State truth(100, 120, 100, 0.3);
  pictures.show_often({region_of(truth)}, 20);
  const State doubled = PipeShape::scaled(truth, 2);
  pictures.image = {.width = 640, .height = 480};
  const PipeTrack& track = pictures.show({region_of(doubled)});
  EXPECT_EQ(track.state, TrackState::kLocked);
  EXPECT_EQ(track.number, 1U);
  EXPECT_LT((track.estimate - doubled).norm(), 1);
  EXPECT_LT((track.weighted_mean - doubled).head<2>().norm(), 8);
  // Another part of the scene: nothing is known of it.
  pictures.image = {.width = 640, .height = 200};
  EXPECT_EQ(pictures.show({region_of(doubled)}).state, TrackState::kDetecting);
}

TEST(PipeTracker, TheFrameRateMayChange) {
  Pictures pictures;
  State truth(80, 120, 100, 0.3);
  for (int i = 0; i < 90; ++i) {
    pictures.period = i < 30 ? 0.04 : i < 60 ? 0.16 : 0.01;
    truth.x() += 30 * pictures.period;
    const PipeTrack& track = pictures.show({region_of(truth)});
    EXPECT_EQ(track.number, i < 2 ? 0U : 1U) << i;
    EXPECT_LT((track.estimate - truth).head<2>().norm(), 1.5) << i;
  }
}

TEST(PipeTracker, TimeThatGoesBackIsRefusedAndBeginsAnew) {
  Pictures pictures;
  const std::vector<PipeRegion> regions{region_of({100, 120, 100, 0.3})};
  pictures.show_often(regions, 20);
  const State before = pictures.track().estimate;
  TrackingFrame<PipeShape> late{.time = pictures.time - 0.5, .image = kImage, .regions = regions};
  EXPECT_EQ(pictures.tracker.update(late).fault, TrackFault::kTimeWentBack);
  EXPECT_EQ(pictures.track().estimate, before);
  EXPECT_EQ(pictures.track().state, TrackState::kLocked);
  late.time = pictures.time - 100;
  EXPECT_EQ(pictures.tracker.update(late).state, TrackState::kDetecting);
  for (int i = 0; i < 3; ++i) {
    late.time += kFrame;
    pictures.tracker.update(late);
  }
  EXPECT_EQ(pictures.track().state, TrackState::kLocked);
  EXPECT_EQ(pictures.track().number, 2U);
  EXPECT_EQ(pictures.faults(TrackFault::kTimeWentBack), 2U);
}

TEST(PipeTracker, BadInputIsCountedAndLeavesASafeState) {
  Pictures pictures;
  const PipeRegion good = region_of({100, 120, 100, 0.3});
  pictures.show_often({good}, 20);
  PipeRegion bad = good;
  bad.end.y() = kNan;
  PipeRegion point = good;
  point.end = point.start;
  EXPECT_EQ(pictures.show({bad, point, good}).state, TrackState::kLocked);
  EXPECT_EQ(pictures.track().region, 2U);
  EXPECT_EQ(pictures.faults(TrackFault::kBadRegion), 2U);

  TrackingFrame<PipeShape> frame{.time = kNan, .image = kImage};
  EXPECT_EQ(pictures.tracker.update(frame).fault, TrackFault::kBadStamp);
  frame.time = pictures.time + 0.01;
  frame.image.height = 0;
  EXPECT_EQ(pictures.tracker.update(frame).fault, TrackFault::kBadImageSize);

  const std::vector<PipeRegion> thousands(5000, good);
  EXPECT_EQ(pictures.show(thousands).state, TrackState::kCoasting);
  EXPECT_EQ(pictures.track().fault, TrackFault::kTooManyRegions);

  ImageMotion motion;
  motion.gradient(0, 0) = kNan;
  EXPECT_EQ(pictures.show({good}, {.motion = motion}).state, TrackState::kLocked);
  EXPECT_EQ(pictures.track().fault, TrackFault::kBadMotion);
  EXPECT_TRUE(pictures.track().estimate.allFinite());

  Pictures fresh;
  const TrackHint<PipeShape> hint{.shape = {1, 2, 3, 0}, .deviation = {1, 1, 0, 1}};
  EXPECT_EQ(fresh.show({good}, {.hint = hint}).fault, TrackFault::kBadHint);
}

TEST(PipeTracker, ManyRegionsOfClutterDoNotLeadItAway) {
  Pictures pictures;
  std::mt19937_64 engine(4);
  std::uniform_real_distribution<double> uniform(0, 1);
  const State truth(160, 120, 200, 0.3);
  for (int i = 0; i < 200; ++i) {
    std::vector<PipeRegion> regions{region_of(truth)};
    for (int k = 0; k < 400 && i > 0; ++k) {
      regions.push_back(region_of({320 * uniform(engine), 240 * uniform(engine),
                                   10 + 60 * uniform(engine), 3 * uniform(engine)}));
    }
    const PipeTrack& track = pictures.show(regions);
    if (i > 5) {
      ASSERT_LT((track.estimate - truth).head<2>().norm(), 5) << i;
      ASSERT_EQ(track.number, 1U);
    }
  }
}

TEST(PipeTracker, ACandidateThatIsNotSeenAgainIsNoTrack) {
  Pictures pictures;
  pictures.show({region_of({160, 120, 200, 0.3})});
  pictures.show({});
  pictures.show({});
  EXPECT_EQ(pictures.track().state, TrackState::kDetecting);
  EXPECT_EQ(pictures.track().number, 0U);
  EXPECT_EQ(pictures.track().estimate, State::Zero());
  EXPECT_TRUE(std::isnan(pictures.track().since_seen));
}

TEST(PipeTracker, TheSameSeedAndFramesGiveTheSameBits) {
  const auto run = [](std::uint64_t seed) {
    Pictures pictures(seed);
    for (int i = 0; i < 30; ++i) {
      pictures.show({region_of({100.0 + i, 120, 100, 0.3})});
    }
    return pictures.track();
  };
  EXPECT_EQ(run(5).weighted_mean, run(5).weighted_mean);
  EXPECT_EQ(run(5).estimate, run(5).estimate);
  EXPECT_NE(run(5).weighted_mean, run(6).weighted_mean);
}

RC_GTEST_PROP(PipeTracker, NothingThatIsShownBreaksIt, ()) {
  Pictures pictures(*rc::gen::arbitrary<std::uint64_t>());
  const auto number = [] {
    return *rc::gen::oneOf(
        rc::gen::map(rc::gen::inRange(-4000, 6000), [](int v) { return v / 10.0; }),
        rc::gen::element(0.0, 1e300, -1e9, kNan, std::numeric_limits<double>::infinity()));
  };
  const int shown = *rc::gen::inRange(1, 12);
  for (int i = 0; i < shown; ++i) {
    std::vector<PipeRegion> regions(*rc::gen::inRange<std::size_t>(0, 5));
    for (PipeRegion& region : regions) {
      region = {.start = {number(), number()},
                .end = {number(), number()},
                .half_width = number(),
                .cut_along = *rc::gen::arbitrary<bool>()};
    }
    TrackingFrame<PipeShape> frame{.time = number(), .image = kImage, .regions = regions};
    if (*rc::gen::arbitrary<bool>()) {
      frame.motion = ImageMotion{.at = {number(), number()}, .velocity = {number(), number()}};
    }
    const PipeTrack& track = pictures.tracker.update(frame);
    RC_ASSERT(track.estimate.allFinite() && track.covariance.allFinite() && track.rate.allFinite());
    RC_ASSERT(track.confidence >= 0 && track.confidence <= 1);
  }
}

TEST(ShapeTracker, FollowsValvesAndVessels) {
  ShapeTracker<ValveShape> valves(ValveShape{}, {}, 7);
  ShapeTracker<VesselShape> vessels(VesselShape{}, {}, 8);
  for (int i = 0; i < 80; ++i) {
    const double t = kFrame * i;
    const bool hidden = i > 40 && i < 50;
    const std::vector<ValveShape::State> valve{{100 + 30 * t, 80, 20}, {250, 200, 25}};
    VesselShape::State vessel;
    vessel << 150, 90 + 20 * t, 80, 40, wrapped(1.5 + 0.1 * t);
    const std::vector<VesselShape::State> tank{vessel};
    const auto& circle = valves.update(
        {.time = t, .image = kImage, .regions = std::span(valve).subspan(i == 0 ? 1 : hidden)});
    const auto& rectangle =
        vessels.update({.time = t, .image = kImage, .regions = std::span(tank).subspan(hidden)});
    if (i > 10) {
      EXPECT_EQ(circle.state, TrackState::kLocked) << i;
      EXPECT_LT((circle.estimate - valve[1]).norm(), 1) << i;
      EXPECT_EQ(rectangle.state, hidden ? TrackState::kCoasting : TrackState::kLocked) << i;
      EXPECT_LT((rectangle.estimate - vessel).head<4>().norm(), 4) << i;
    }
  }
}

TEST(ShapeTracker, ParametersOutOfRangeAreNamed) {
  const auto make = [](const auto& spoil) {
    PipeTrackerParameters parameters;
    spoil(parameters);
    return [parameters] { PipeTracker(PipeShape{}, parameters, 1); };
  };
  EXPECT_THAT(make([](auto& p) { p.rate_walk[1] = 0; }),
              ThrowsMessage<std::invalid_argument>(HasSubstr("rate_walk: 0")));
  EXPECT_THAT(make([](auto& p) { p.motion_share = kNan; }),
              ThrowsMessage<std::invalid_argument>(HasSubstr("motion_share: nan")));
  EXPECT_THAT(make([](auto& p) { p.detection = 1; }),
              ThrowsMessage<std::invalid_argument>(HasSubstr("detection: 1")));
  EXPECT_THAT(make([](auto& p) { p.confirm = 0; }),
              ThrowsMessage<std::invalid_argument>(HasSubstr("confirm: 0")));
  EXPECT_THAT(make([](auto& p) { p.max_coast = -1; }),
              ThrowsMessage<std::invalid_argument>(HasSubstr("max_coast: -1")));
  EXPECT_THAT(make([](auto& p) { p.filter.particles = 2; }),
              ThrowsMessage<std::invalid_argument>(HasSubstr("particles: 2")));
  EXPECT_THAT([] { PipeTracker(PipeShape{.end_deviation = 0}, {}, 1); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("end_deviation: 0")));
  EXPECT_NO_THROW(make([](auto&) {})());
}

TEST(ShapeTracker, StatesAndFaultsHaveNames) {
  EXPECT_EQ(to_string(TrackState::kCoasting), "coasting");
  EXPECT_EQ(to_string(TrackFault::kTooManyRegions), "too_many_regions");
  EXPECT_EQ(to_string(static_cast<TrackState>(77)), "unknown");
  EXPECT_EQ(to_string(static_cast<TrackFault>(77)), "unknown");
}

}  // namespace
}  // namespace pipescout::tracking
