// SPDX-License-Identifier: Apache-2.0
#include "pipescout/driving/local_planner.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <vector>

#include "heap_guard.hpp"

namespace pipescout::navigation {
namespace {

constexpr double kFar = 20;

/// A path of arcs: curvature and signed length of each.
struct Arc {
  double curvature;
  double length;
};

Path path_of(const Pose2d& start, const std::vector<Arc>& arcs) {
  std::vector<PathPose> poses;
  Pose2d pose = start;
  double driven = 0;
  for (const Arc& arc : arcs) {
    const auto direction = arc.length < 0 ? Direction::kReverse : Direction::kForward;
    const int steps = static_cast<int>(std::ceil(std::abs(arc.length) / 0.1));
    if (poses.empty() || poses.back().direction != direction) {
      poses.push_back({pose, direction, arc.curvature, driven});
    } else {
      poses.back().curvature = arc.curvature;
    }
    const Pose2d first = pose;
    for (int i = 1; i <= steps; ++i) {
      pose = drive_arc(first, arc.curvature, arc.length * i / steps);
      poses.push_back({pose, direction, arc.curvature, driven + std::abs(arc.length) * i / steps});
    }
    driven += std::abs(arc.length);
  }
  return Path(poses);
}

/// A robot that follows its commands at once but for the delay, the steering rate and its
/// acceleration; around it points that its lidar sees.
class LocalPlannerTest : public ::testing::Test {
 protected:
  DriveCommand step(bool with_scan = true, double sigma = 0.05) {
    time_ += parameters_.period;
    planner_.add(Localisation{.time = time_, .pose = pose_, .speed = speed_, .sigma = sigma});
    if (with_scan) {
      scan();
    }
    const DriveCommand command = planner_.cycle(time_);
    waiting_.push_back(command);
    if (waiting_.size() > 2) {
      const double turn = parameters_.steering_rate * parameters_.period;
      const double wanted = std::atan(parameters_.wheel_base * waiting_.front().curvature);
      steering_ += std::clamp(wanted - steering_, -turn, turn);
      speed_ = waiting_.front().speed;
      waiting_.erase(waiting_.begin());
    }
    pose_ =
        drive_arc(pose_, std::tan(steering_) / parameters_.wheel_base, speed_ * parameters_.period);
    if (speed_ != 0) {
      pose_ = compose(pose_, {0, drift_ * parameters_.period, 0});
    }
    return command;
  }

  /// What a lidar sees of a wall from one point to another.
  void add_wall(const Point2d& from, const Point2d& to) {
    const double length = distance(from, to);
    for (double at = 0; at <= length; at += 0.05) {
      points_.push_back(
          {from.x + (to.x - from.x) * at / length, from.y + (to.y - from.y) * at / length});
    }
  }

  void scan() {
    std::vector<float>& ranges = ranges_;
    ranges.assign(360, std::numeric_limits<float>::infinity());
    // A flicker of the farthest beam: a lidar that never changes is frozen.
    ranges[0] = static_cast<float>(kFar - 1 - 1e-3 * std::fmod(time_, 1.0));
    for (const Point2d& point : points_) {
      const Point2d seen = relative(pose_, {point.x, point.y, 0}).position();
      const double angle = std::atan2(seen.y, seen.x) + std::numbers::pi;
      const auto beam = static_cast<std::size_t>(angle * 180 / std::numbers::pi) % 360;
      ranges[beam] = std::min(ranges[beam], static_cast<float>(std::hypot(seen.x, seen.y)));
    }
    planner_.add(ScanView{.time = time_,
                          .angle_min = -std::numbers::pi,
                          .angle_increment = std::numbers::pi / 180,
                          .range_min = 0.1,
                          .range_max = kFar,
                          .ranges = ranges},
                 {});
  }

  DriveCommand run(double seconds) {
    DriveCommand command;
    for (double t = 0; t < seconds; t += parameters_.period) {
      command = step();
      fastest_ = std::max(fastest_, std::abs(command.speed));
      if (command.state == DriveState::kReached || command.state == DriveState::kFailed) {
        break;
      }
    }
    return command;
  }

  DrivingParameters parameters_;
  LocalPlanner planner_{parameters_, {}, Footprint::rectangle(1.55, 0.35, 1.0)};
  std::vector<Point2d> points_;
  std::vector<float> ranges_;
  std::vector<DriveCommand> waiting_;
  Pose2d pose_;
  double speed_ = 0;
  double steering_ = 0;
  double drift_ = 0;  ///< m/s, to the left, while it drives
  double time_ = 100;
  double fastest_ = 0;
};

TEST_F(LocalPlannerTest, StraightToAGoal) {
  planner_.set_path(path_of({}, {{0, 20}}));
  EXPECT_EQ(run(60).state, DriveState::kReached);
  EXPECT_NEAR(pose_.x, 20, 0.1);
  EXPECT_NEAR(pose_.y, 0, 0.02);
  EXPECT_NEAR(fastest_, parameters_.largest_speed, 0.1);
}

TEST_F(LocalPlannerTest, CurvesAndACuspToGoalAndHeading) {
  const Path path = path_of({}, {{0, 5}, {0.4, 3}, {0, 2}, {-0.4, -4}, {0, -2}});
  planner_.set_path(path);
  EXPECT_EQ(run(90).state, DriveState::kReached);
  const Pose2d error = relative(path.poses().back().pose, pose_);
  EXPECT_LT(std::hypot(error.x, error.y), 0.1);
  EXPECT_LT(std::abs(error.heading), 3 * std::numbers::pi / 180);
}

/// Down a slope, for example: 2.5 cm a second are as much as the last metre takes it aside.
TEST_F(LocalPlannerTest, SlippingSidewaysItStillComesToTheGoalAtOnce) {
  for (const double length : {15.0, -15.0}) {
    for (const double drift : {-0.025, 0.025}) {
      pose_ = {};
      drift_ = drift;
      planner_.set_path(path_of({}, {{0, length}}));
      DriveCommand command;
      for (int i = 0; i < 1200 && command.state != DriveState::kReached; ++i) {
        command = step();
        ASSERT_NE(command.state, DriveState::kBackingUp) << length << ", " << drift;
      }
      EXPECT_EQ(command.state, DriveState::kReached);
      EXPECT_NEAR(pose_.y, 0, 0.025) << length << ", " << drift;
      EXPECT_NEAR(pose_.heading, 0, 0.03) << length << ", " << drift;
    }
  }
}

TEST_F(LocalPlannerTest, PassesANarrowPlaceSlowlyWithLessOfAMargin) {
  // A gate with 0.17 m on both sides: less than the usual margin and half a cell.
  add_wall({9, 0.67}, {9, 6});
  add_wall({9, -0.67}, {9, -6});
  planner_.set_path(path_of({}, {{0, 20}}));
  bool waited = false;
  DriveCommand command;
  for (int i = 0; i < 2400 && command.state != DriveState::kReached; ++i) {
    command = step();
    waited |= command.state == DriveState::kWaiting;
    if (pose_.x > 7.5 && pose_.x < 9.5) {
      ASSERT_TRUE(waited);
      ASSERT_LE(std::abs(command.speed), parameters_.tight_speed);
      ASSERT_LT(std::abs(pose_.y), 0.15);
    }
  }
  EXPECT_EQ(command.state, DriveState::kReached);
}

/// Somebody walks to and fro in the same aisle, and leaves room to pass.
TEST_F(LocalPlannerTest, WhereSomebodyWillBeInHalfAMinuteDoesNotBlockIt) {
  add_wall({-2, -1.3}, {16, -1.3});
  planner_.set_path(path_of({}, {{0, 12}}));
  const std::vector<Point2d> wall = points_;
  DriveCommand command;
  for (int i = 0; i < 1200 && command.state != DriveState::kReached; ++i) {
    const double phase = std::fmod(0.5 * (time_ - 100), 8);
    const double x = 5 + (phase < 4 ? phase : 8 - phase);
    points_ = wall;
    for (double s = -0.2; s <= 0.2; s += 0.05) {
      points_.push_back({x - 0.2, 1.6 + s});
      points_.push_back({x + s, 1.4});
    }
    command = step();
    EXPECT_FALSE(command.replan) << time_;
  }
  EXPECT_EQ(command.state, DriveState::kReached);
}

TEST_F(LocalPlannerTest, StopsBeforeAWallAndAsksForAnotherPath) {
  for (double y = -6; y <= 6; y += 0.05) {
    points_.push_back({12, y});
  }
  planner_.set_path(path_of({}, {{0, 20}}));
  DriveCommand command;
  for (int i = 0; i < 1200 && !command.replan; ++i) {
    command = step();
    ASSERT_LT(pose_.x + 1.55, 12);
  }
  EXPECT_TRUE(command.replan);
  EXPECT_EQ(command.reason, DriveReason::kPathBlocked);
  EXPECT_EQ(command.speed, 0);
}

TEST_F(LocalPlannerTest, MoreObstaclesThanItCanLookAtStopIt) {
  for (double y = -6; y <= 6; y += 0.05) {
    points_.push_back({12, y});
  }
  parameters_.most_obstacle_cells = 20;
  planner_ = LocalPlanner(parameters_, {}, Footprint::rectangle(1.55, 0.35, 1.0));
  planner_.set_path(path_of({}, {{0, 20}}));
  DriveCommand command;
  for (int i = 0; i < 1200; ++i) {
    command = step();
    ASSERT_LT(pose_.x + 1.55, 12);
  }
  EXPECT_EQ(command.reason, DriveReason::kTooManyObstacles);
  EXPECT_EQ(command.state, DriveState::kWaiting);
  EXPECT_EQ(command.speed, 0);
}

TEST_F(LocalPlannerTest, StopsBeforeWhatOtherSensorsSee) {
  std::vector<Point2d> cells;
  for (double y = -6; y <= 6; y += 0.1) {
    cells.push_back({12, y});
  }
  cells.push_back({std::numeric_limits<double>::quiet_NaN(), 0});
  planner_.set_path(path_of({}, {{0, 20}}));
  DriveCommand command;
  for (int i = 0; i < 1200 && !command.replan; ++i) {
    command = step();
    planner_.set_obstacles(cells, time_);
    ASSERT_LT(pose_.x + 1.55, 12);
  }
  EXPECT_EQ(command.reason, DriveReason::kPathBlocked);
  planner_.set_obstacles(std::vector<Point2d>(parameters_.most_obstacle_cells + 1, {1, 5}), time_);
  EXPECT_EQ(step().reason, DriveReason::kTooManyObstacles);
}

TEST_F(LocalPlannerTest, PassesABoxBesideThePath) {
  for (double s = -0.2; s <= 0.2; s += 0.05) {
    for (const double side : {-0.2, 0.2}) {
      points_.push_back({15 + s, 0.3 + side});
      points_.push_back({15 + side, 0.3 + s});
    }
  }
  planner_.set_path(path_of({}, {{0, 30}}));
  EXPECT_EQ(run(60).state, DriveState::kReached);
  EXPECT_NEAR(pose_.y, 0, 0.1);
}

/// The offset never jumps from side to side, and no metre is driven twice.
TEST_F(LocalPlannerTest, NeitherOscillatesNorLoopsNeedlessly) {
  enum class Scene { kFree, kBoxOnThePath, kBoxesOnBothSides, kSomebodyCrosses };
  for (const Scene scene :
       {Scene::kFree, Scene::kBoxOnThePath, Scene::kBoxesOnBothSides, Scene::kSomebodyCrosses}) {
    SCOPED_TRACE(static_cast<int>(scene));
    const double begin = time_;
    pose_ = {};
    points_.clear();
    planner_ = LocalPlanner(parameters_, {}, Footprint::rectangle(1.55, 0.35, 1.0));
    planner_.set_path(path_of({}, {{0, 10}, {0.2, 5}, {0, 12}}));
    if (scene == Scene::kBoxOnThePath || scene == Scene::kBoxesOnBothSides) {
      add_wall({8, -0.1}, {8, 0.3});
      add_wall({8, 0.3}, {8.4, 0.3});
    }
    if (scene == Scene::kBoxesOnBothSides) {
      add_wall({5, -1.2}, {5, -0.9});
      add_wall({11, 1.6}, {11, 2});
    }
    const std::vector<Point2d> standing = points_;
    int changes = 0;
    double side = 0;
    double driven = 0;
    DriveCommand command;
    while (command.state != DriveState::kReached && time_ < begin + 90) {
      if (scene == Scene::kSomebodyCrosses) {
        points_ = standing;
        const double y = -8 + 1.2 * (time_ - begin);
        add_wall({9, y - 0.3}, {9, y + 0.3});
      }
      command = step();
      ASSERT_NE(command.state, DriveState::kBackingUp);
      driven += std::abs(speed_) * parameters_.period;
      if (command.travelled > 19) {
        EXPECT_NEAR(command.lateral_error, 0, 0.3) << "it weaves at " << command.travelled;
      }
      if (command.offset != 0) {
        changes += command.offset * side < 0 ? 1 : 0;
        side = command.offset;
      }
    }
    EXPECT_EQ(command.state, DriveState::kReached);
    EXPECT_LE(changes, 1);
    EXPECT_LT(driven, 27 * 1.06);
  }
}

TEST_F(LocalPlannerTest, NoCuspIsOvershot) {
  for (const double sign : {1.0, -1.0}) {
    pose_ = {};
    const Path path = path_of({}, {{0, 4 * sign}, {0.4, -3 * sign}, {0, 4 * sign}});
    planner_.set_path(path);
    double farthest = 0;
    DriveCommand command;
    for (int i = 0; i < 2000 && command.state != DriveState::kReached; ++i) {
      command = step();
      farthest = std::max(farthest, sign * pose_.x);
    }
    EXPECT_EQ(command.state, DriveState::kReached);
    EXPECT_NEAR(farthest, 4, 0.05) << "or beyond the last pose: " << path.poses().back().pose.x;
  }
}

TEST_F(LocalPlannerTest, WaitsForWhatCrosses) {
  planner_.set_path(path_of({}, {{0, 25}}));
  bool slowed = false;
  DriveCommand command;
  for (int i = 0; i < 1000 && command.state != DriveState::kReached; ++i) {
    const double y = -8 + 1.2 * (time_ - 100);
    points_.clear();
    for (double s = -0.3; s <= 0.3; s += 0.05) {
      points_.push_back({12, y + s});
    }
    command = step();
    slowed |= command.reason == DriveReason::kMovingObstacle;
    const Point2d seen = relative(pose_, {12, y, 0}).position();
    ASSERT_FALSE(seen.x > -0.35 && seen.x < 1.55 && std::abs(seen.y) < 0.8) << time_;
  }
  EXPECT_TRUE(slowed);
  EXPECT_EQ(command.state, DriveState::kReached);
}

TEST_F(LocalPlannerTest, InputsThatCannotBeDrivenByStopIt) {
  planner_.set_path(path_of({}, {{0, 50}}));
  run(4);
  ASSERT_GT(speed_, 1);
  DriveCommand command;
  for (int i = 0; i < 60; ++i) {
    command = step(true, 2.0);
  }
  EXPECT_EQ(command.reason, DriveReason::kLocalisationUncertain);
  EXPECT_EQ(command.speed, 0);
  run(3);
  ASSERT_GT(speed_, 1);
  for (int i = 0; i < 60; ++i) {
    command = step(false);
  }
  EXPECT_EQ(command.reason, DriveReason::kScanStale);
  EXPECT_EQ(command.speed, 0);
  run(3);
  ASSERT_GT(speed_, 1);
  for (int i = 0; i < 60; ++i) {
    time_ += parameters_.period;
    command = planner_.cycle(time_);
  }
  EXPECT_EQ(command.reason, DriveReason::kLocalisationStale);
  EXPECT_EQ(command.speed, 0);
}

TEST_F(LocalPlannerTest, AFrozenLidarStopsIt) {
  planner_.set_path(path_of({}, {{0, 50}}));
  run(4);
  DriveCommand command;
  for (int i = 0; i < 60; ++i) {
    time_ += parameters_.period;
    planner_.add(Localisation{.time = time_, .pose = pose_, .speed = speed_});
    planner_.add(ScanView{.time = time_,
                          .angle_min = -std::numbers::pi,
                          .angle_increment = std::numbers::pi / 180,
                          .range_min = 0.1,
                          .range_max = kFar,
                          .ranges = ranges_},
                 {});
    command = planner_.cycle(time_);
  }
  EXPECT_EQ(command.reason, DriveReason::kScanFrozen);
  EXPECT_EQ(command.speed, 0);
}

TEST_F(LocalPlannerTest, PushedOffItsPathByTwoMetres) {
  planner_.set_path(path_of({}, {{0, 50}}));
  run(4);
  pose_.y += 2;
  DriveCommand command;
  for (int i = 0; i < 60; ++i) {
    command = step();
  }
  EXPECT_EQ(command.reason, DriveReason::kOffPath);
  EXPECT_TRUE(command.replan);
  EXPECT_EQ(command.speed, 0);
}

TEST_F(LocalPlannerTest, PauseLimitAndGoingBack) {
  planner_.set_path(path_of({}, {{0, 50}}));
  planner_.limit_speed(0.5);
  run(12);
  EXPECT_NEAR(speed_, 0.5, 1e-9);
  EXPECT_FALSE(planner_.go_back_to(40).has_value());
  const double before = pose_.x;
  EXPECT_TRUE(planner_.go_back_to(before - 2).has_value());
  bool was_back = false;
  for (int i = 0; i < 400; ++i) {
    was_back |= step().state == DriveState::kBackingUp && pose_.x < before - 1.8;
  }
  EXPECT_TRUE(was_back);
  EXPECT_GT(speed_, 0);
  planner_.pause(true);
  EXPECT_EQ(run(3).reason, DriveReason::kPaused);
  EXPECT_EQ(speed_, 0);
}

TEST_F(LocalPlannerTest, GoesBackNoFartherThanTheLastCusp) {
  planner_.set_path(path_of({}, {{0, 6}, {0, -12}}));
  DriveCommand command;
  while (command.travelled < 8) {
    command = step();
    ASSERT_LT(time_, 160);
  }
  EXPECT_EQ(planner_.go_back_to(3), 6);
}

TEST_F(LocalPlannerTest, BrakesAsHardAsTheCauseAsks) {
  planner_.set_path(path_of({}, {{0, 60}}));
  run(6);
  ASSERT_NEAR(speed_, parameters_.largest_speed, 0.01);
  const auto largest_change = [&](int cycles) {
    double largest = 0;
    double last = step().speed;
    for (int i = 0; i < cycles; ++i) {
      const double speed = step().speed;
      largest = std::max(largest, (last - speed) / parameters_.period);
      last = speed;
    }
    return largest;
  };
  planner_.pause(true);
  EXPECT_NEAR(largest_change(100), parameters_.gentle_braking, 1e-6);
  EXPECT_EQ(speed_, 0);
  planner_.pause(false);
  run(6);
  // Somebody steps onto the path, too near for a usual stop: after 0.15 s at 2 m/s, 1.6 m are left.
  for (double y = -1; y <= 1; y += 0.05) {
    points_.push_back({pose_.x + 1.55 + 2.0, y});
  }
  EXPECT_NEAR(largest_change(60), parameters_.hardest_braking, 1e-6);
  EXPECT_EQ(speed_, 0);
  EXPECT_LT(pose_.x + 1.55, points_.front().x);
}

TEST(LocalCostmap, BeamsWithoutAnEchoClearWhatWasThereInSeveralScans) {
  const LocalCostmapParameters parameters;
  LocalCostmap costmap(parameters);
  const std::vector<float> echo{5};
  const std::vector<float> none{std::numeric_limits<float>::infinity()};
  double time = 1;
  const auto occupied = [&](const std::vector<float>& ranges) {
    time += 0.1;
    costmap.add({.time = time,
                 .angle_increment = 0.01,
                 .range_min = 0.1,
                 .range_max = kFar,
                 .ranges = ranges},
                {});
    std::vector<Point2d> cells;
    cells.reserve(10);
    EXPECT_TRUE(costmap.occupied_near({5, 0}, 1, time, cells));
    return !cells.empty();
  };
  EXPECT_TRUE(occupied(echo));
  EXPECT_TRUE(occupied(none));
  EXPECT_TRUE(occupied(none));
  // Seen again: it only gave no echo.
  EXPECT_TRUE(occupied(echo));
  EXPECT_TRUE(occupied(none));
  EXPECT_TRUE(occupied(none));
  EXPECT_FALSE(occupied(none));
}

TEST_F(LocalPlannerTest, RefusesWhatIsWrong) {
  EXPECT_THROW(planner_.set_path(Path()), std::invalid_argument);
  EXPECT_THROW(planner_.set_path(path_of({}, {{1.0, 3}})), std::invalid_argument);
  parameters_.period = 0;
  EXPECT_THROW(LocalPlanner(parameters_, {}, Footprint::rectangle(1, 1, 1)), std::invalid_argument);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(planner_.add(Localisation{.time = 1, .pose = {nan, 0, 0}}), DriveInput::kNotFinite);
  EXPECT_EQ(planner_.add(Localisation{.time = 1}), DriveInput::kTaken);
  EXPECT_EQ(planner_.add(Localisation{.time = 1}), DriveInput::kOutOfOrder);
  EXPECT_EQ(planner_.add(ScanView{}, {}), DriveInput::kBadGeometry);
}

TEST_F(LocalPlannerTest, DrivesOnWhenTheClockIsSetBack) {
  planner_.set_path(path_of({}, {{0, 30}}));
  for (int i = 0; i < 40; ++i) {
    step();
  }
  ASSERT_GT(speed_, 0.5);
  time_ -= 60;
  // The first readings after that are from before what it knows, until it has looked at the clock.
  EXPECT_EQ(step().reason, DriveReason::kLocalisationMissing);
  EXPECT_EQ(step().reason, DriveReason::kNone);
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(step().state, DriveState::kDriving);
  }
  EXPECT_GT(speed_, 0.5);
}

TEST_F(LocalPlannerTest, TakesNothingFromTheHeap) {
  for (double y = -6; y <= 6; y += 0.05) {
    points_.push_back({12, y});
    points_.push_back({y + 6, 2.5});
  }
  planner_.set_path(path_of({}, {{0, 20}}));
  step();
  waiting_.reserve(8);
  std::size_t taken = 0;
  for (int i = 0; i < 300; ++i) {
    time_ += parameters_.period;
    const Localisation localisation{.time = time_, .pose = pose_, .speed = speed_};
    const pipescout::test::HeapGuard guard;
    planner_.add(localisation);
    scan();
    const DriveCommand command = planner_.cycle(time_);
    taken += guard.allocations();
    speed_ = command.speed;
    pose_ = drive_arc(pose_, command.curvature, speed_ * parameters_.period);
  }
  EXPECT_EQ(taken, 0U);
}

}  // namespace
}  // namespace pipescout::navigation
