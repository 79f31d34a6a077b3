// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/way_point_mission.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace pipescout::rack_vision {
namespace {

using Eigen::Vector3d;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kPeriod = 0.04;

WayPointPath short_path() {
  const std::vector<WayPoint> points{{.position = {1, 5, 3}, .hold = 1},
                                     {.position = {1, 6, 3}, .yaw = 0.2, .hold = 1}};
  return {points, {}};
}

LevelPose on_path(const WayPointMission& mission, double now) {
  const PathPoint point = mission.target(now);
  return {.time = now, .position = point.position, .yaw = point.yaw};
}

TEST(WayPointMission, IsFlownInTheTimeOfThePathByAVehicleThatIsAlwaysOnIt) {
  WayPointMission mission(short_path(), {});
  double now = 100;
  for (; !mission.complete() && now < 200; now += kPeriod) {
    mission.advance(now, on_path(mission, now));
  }
  EXPECT_TRUE(mission.complete());
  EXPECT_NEAR(now - 100, mission.path().duration(), 4 * kPeriod);
  EXPECT_THAT(mission.outcomes(),
              ElementsAre(WayPointOutcome::kReached, WayPointOutcome::kReached));
  EXPECT_EQ(mission.count(WayPointOutcome::kReached), 2U);
  EXPECT_EQ(mission.current(), 1U);
}

TEST(WayPointMission, WaitsForAVehicleThatIsNotThereYet) {
  WayPointMission mission(short_path(), {});
  double now = 0;
  for (; now < 50; now += kPeriod) {
    mission.advance(now, LevelPose{.time = now, .position = {1, 5.4, 3}});
  }
  EXPECT_TRUE(mission.waiting());
  EXPECT_EQ(mission.path_time(), 0);
  EXPECT_EQ(mission.target(now).velocity.norm(), 0);
  mission.advance(now, LevelPose{.time = now, .position = {1, 5, 3}, .yaw = 0.6});
  EXPECT_TRUE(mission.waiting());
  for (int i = 0; i < 5; ++i, now += kPeriod) {
    mission.advance(now, LevelPose{.time = now, .position = {1, 5, 3}});
  }
  EXPECT_FALSE(mission.waiting());
  EXPECT_GT(mission.path_time(), 0);
}

TEST(WayPointMission, WaitsWhileThePoseIsNotKnownOrIsNoNumber) {
  WayPointMission mission(short_path(), {});
  double now = 0;
  for (; mission.path_time() < 2; now += kPeriod) {
    mission.advance(now, on_path(mission, now));
  }
  EXPECT_GT(mission.target(now).velocity.norm(), 0);
  const double stopped = mission.path_time();
  for (int i = 0; i < 100; ++i, now += kPeriod) {
    mission.advance(now, std::nullopt);
  }
  EXPECT_EQ(mission.path_time(), stopped);
  LevelPose broken = on_path(mission, now);
  broken.position.y() = std::numeric_limits<double>::quiet_NaN();
  mission.advance(now, broken);
  broken = on_path(mission, now);
  broken.time = std::numeric_limits<double>::quiet_NaN();
  mission.advance(now, broken);
  EXPECT_EQ(mission.path_time(), stopped);
  EXPECT_EQ(mission.target(now).velocity.norm(), 0);
  EXPECT_EQ(mission.target(now).acceleration.norm(), 0);
  EXPECT_EQ(mission.target(now).yaw_rate, 0);
  for (; !mission.complete() && now < 100; now += kPeriod) {
    mission.advance(now, on_path(mission, now));
  }
  EXPECT_EQ(mission.count(WayPointOutcome::kReached), 2U);
}

TEST(WayPointMission, DoesNotTakeAWayPointForReachedWhileThePoseIsNotKnownSoWell) {
  WayPointMission mission(short_path(), {});
  double now = 0;
  const auto fly = [&](double position_deviation, double yaw_deviation) {
    for (const double end = now + 5; now < end; now += kPeriod) {
      LevelPose pose = on_path(mission, now);
      pose.position_deviation = position_deviation;
      pose.yaw_deviation = yaw_deviation;
      mission.advance(now, pose);
    }
  };
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  for (const auto& [position_deviation, yaw_deviation] :
       {std::pair{0.016, 0.001}, {0.001, 0.009}, {kNaN, 0.001}, {0.001, kNaN}}) {
    fly(position_deviation, yaw_deviation);
    EXPECT_EQ(mission.outcomes()[0], WayPointOutcome::kPending);
  }
  fly(0.0149, 0.0087);
  EXPECT_EQ(mission.outcomes()[0], WayPointOutcome::kReached);
}

TEST(WayPointMission, LooksAroundWhileThePoseIsNotKnownSoWell) {
  constexpr double kRadius = 0.3;
  constexpr double kSpeed = 0.4;
  const Vector3d way_point{1, 5, 3};
  WayPointMission mission(short_path(),
                          {.look_around = kRadius, .look_around_speed = kSpeed, .patience = 60});
  double now = 0;
  double way = 0;
  double largest_speed = 0;
  double right = 0;
  double left = 0;
  double highest = 0;
  double lowest = 0;
  std::optional<PathPoint> before;
  const auto fly = [&](double until, double deviation) {
    for (; now < until; now += kPeriod) {
      LevelPose pose = on_path(mission, now);
      pose.position_deviation = deviation;
      mission.advance(now, pose);
      const PathPoint point = mission.target(now);
      if (before) {
        const Vector3d moved = point.position - before->position;
        way += moved.norm();
        // What it says of the velocity is how it moves.
        EXPECT_LT((moved - 0.5 * kPeriod * (point.velocity + before->velocity)).norm(), 2e-3);
      }
      before = point;
      largest_speed = std::max(largest_speed, point.velocity.norm());
      const Vector3d off = point.position - way_point;
      right = std::max(right, off.x());
      left = std::min(left, off.x());
      highest = std::max(highest, off.z());
      lowest = std::min(lowest, off.z());
      EXPECT_EQ(point.position.y(), 5);
    }
  };
  fly(22, 0.02);
  EXPECT_EQ(mission.outcomes()[0], WayPointOutcome::kPending);
  EXPECT_NEAR(right, kRadius, 0.01);
  EXPECT_NEAR(left, -kRadius, 0.01);
  EXPECT_NEAR(highest, 2 * kRadius, 0.01);
  EXPECT_GT(lowest, -1e-12);
  EXPECT_NEAR(largest_speed, kSpeed, 0.01);
  EXPECT_GT(way, 2 * 2 * 3.1 * kRadius);
  // It ends its round first: it is reached at the way-point, not beside it.
  while (now < 60 && mission.outcomes()[0] == WayPointOutcome::kPending) {
    fly(now + kPeriod, 0.001);
  }
  EXPECT_EQ(mission.outcomes()[0], WayPointOutcome::kReached);
  EXPECT_LT((before->position - way_point).norm(), 1e-3);
}

TEST(WayPointMission, StandsOnItsRoundWhileThereIsNoPose) {
  WayPointMission mission(short_path(), {.look_around = 0.3});
  double now = 0;
  for (; (mission.target(now).position - Vector3d(1, 5, 3)).norm() < 0.2 && now < 20;
       now += kPeriod) {
    LevelPose pose = on_path(mission, now);
    pose.position_deviation = 0.02;
    mission.advance(now, pose);
  }
  ASSERT_LT(now, 20);
  mission.advance(now, std::nullopt);
  const PathPoint stands = mission.target(now);
  EXPECT_EQ(stands.velocity.norm(), 0);
  EXPECT_EQ(stands.acceleration.norm(), 0);
  mission.advance(now + 1, std::nullopt);
  EXPECT_EQ((mission.target(now + 1).position - stands.position).norm(), 0);
}

TEST(WayPointMission, TakesThePoseAtItsWordWhenAskedTo) {
  WayPointMission mission(short_path(), {.deviations_within = 0});
  double now = 0;
  for (; now < 5; now += kPeriod) {
    LevelPose pose = on_path(mission, now);
    pose.position_deviation = 100;
    mission.advance(now, pose);
  }
  EXPECT_EQ(mission.outcomes()[0], WayPointOutcome::kReached);
}

TEST(WayPointMission, StaysUntilAWayPointIsReached) {
  WayPointMission mission(short_path(), {});
  double now = 0;
  const auto beside = [&](double distance) {
    LevelPose pose = on_path(mission, now);
    pose.position.x() += distance;
    return pose;
  };
  for (; now < 10; now += kPeriod) {
    mission.advance(now, beside(0.05));
  }
  EXPECT_EQ(mission.current(), 0U);
  EXPECT_EQ(mission.path_time(), mission.path().departure(0));
  EXPECT_EQ(mission.outcomes()[0], WayPointOutcome::kPending);
  // 0.4 s within, a moment out: not yet.
  for (int i = 0; i < 10; ++i, now += kPeriod) {
    mission.advance(now, beside(0.02));
  }
  mission.advance(now, beside(0.04));
  now += kPeriod;
  EXPECT_EQ(mission.outcomes()[0], WayPointOutcome::kPending);
  for (int i = 0; i < 14; ++i, now += kPeriod) {
    mission.advance(now, beside(0.02));
  }
  EXPECT_EQ(mission.outcomes()[0], WayPointOutcome::kReached);
  EXPECT_EQ(mission.current(), 1U);
}

TEST(WayPointMission, GoesOnWithoutAWayPointWhenItsPatienceEnds) {
  WayPointMission mission(short_path(), {.patience = 3});
  double now = 0;
  for (; !mission.complete() && now < 100; now += kPeriod) {
    LevelPose pose = on_path(mission, now);
    pose.position.z() += mission.current() == 0 ? 0.1 : 0;
    mission.advance(now, pose);
  }
  EXPECT_THAT(mission.outcomes(), ElementsAre(WayPointOutcome::kMissed, WayPointOutcome::kReached));
  EXPECT_NEAR(now, mission.path().duration() + 3, 5 * kPeriod);
}

TEST(WayPointMission, TargetIsThatOfTheTimeOfThePose) {
  WayPointMission mission(short_path(), {});
  double now = 0;
  for (; mission.path_time() < 3; now += kPeriod) {
    mission.advance(now, on_path(mission, now));
  }
  now -= kPeriod;
  const PathPoint before = mission.target(now - 0.2);
  EXPECT_LT((before.position - mission.path().at(mission.path_time() - 0.2).position).norm(),
            1e-12);
  // Not before it began to run, and not ahead of it.
  EXPECT_LT((mission.target(now - 50).position - Vector3d(1, 5, 3)).norm(), 1e-9);
  EXPECT_EQ(mission.target(now + 5).position, mission.target(now).position);
}

TEST(WayPointMission, TakesNoNoticeOfBadTimesAndLongGaps) {
  WayPointMission mission(short_path(), {});
  mission.advance(std::numeric_limits<double>::quiet_NaN(), std::nullopt);
  EXPECT_EQ(mission.path_time(), 0);
  mission.advance(10, on_path(mission, 10));
  mission.advance(10.1, on_path(mission, 10.1));
  const double time = mission.path_time();
  EXPECT_NEAR(time, 0.1, 1e-12);
  mission.advance(5, on_path(mission, 5));
  EXPECT_EQ(mission.path_time(), time);
  mission.advance(1000, on_path(mission, 1000));
  EXPECT_NEAR(mission.path_time(), time + 0.2, 1e-12);
}

TEST(WayPointMission, RejectsParametersOutOfRange) {
  const auto message = [](const WayPointMissionParameters& parameters) -> std::string {
    try {
      const WayPointMission mission(short_path(), parameters);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message({.tolerance = {.position = -1}}), HasSubstr("tolerance.position: -1"));
  EXPECT_THAT(message({.reached_for = 61}), HasSubstr("reached_for: 61"));
  EXPECT_THAT(message({.look_around = 3}), HasSubstr("look_around: 3"));
  EXPECT_THAT(message({.look_around_speed = 0}), HasSubstr("look_around_speed: 0"));
  EXPECT_THAT(message({.patience = -1}), HasSubstr("patience: -1"));
  EXPECT_THAT(message({.largest_lag = 0}), HasSubstr("largest_lag: 0"));
  EXPECT_THAT(message({.largest_yaw_lag = 4}), HasSubstr("largest_yaw_lag: 4"));
  EXPECT_EQ(message({}), "");
}

}  // namespace
}  // namespace pipescout::rack_vision
