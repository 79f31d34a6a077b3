// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigator/navigator.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/map_files/grid_file.hpp"
#include "pipescout/map_files/route_graph_file.hpp"
#include "pipescout/runtime/activity.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using nav2_msgs::action::NavigateToPose;
using nav_msgs::msg::Odometry;
using navigation::Pose2d;
using pipescout_msgs::action::FollowRoute;
using pipescout_msgs::action::InspectTour;
using pipescout_msgs::msg::NavigatorState;
using sensor_msgs::msg::LaserScan;
using testing::ComponentHarness;
using ::testing::HasSubstr;

constexpr Time kStart{std::chrono::seconds(1000)};
constexpr Duration kCycle = std::chrono::milliseconds(50);
constexpr double kWheelBase = 1.2;

/// An empty yard of 60 x 30 m with two roads, a robot that does what it is told at once, and a
/// lidar that sees a wall far away.
class NavigatorTest : public ::testing::Test {
 protected:
  NavigatorTest() {
    harness_.set_time(kStart);
    navigation::OccupancyGrid grid({.resolution = 0.1, .width = 600, .height = 300},
                                   navigation::CellState::kFree);
    for (int column = 280; column < 320; ++column) {
      for (int row = 130; row < 170; ++row) {
        grid.set({column, row}, navigation::CellState::kOccupied);
      }
    }
    write_grid(folder_.path() / "yard.yaml", grid);
    std::vector<navigation::RouteNode> nodes{{.id = 10, .position = {5, 5}},
                                             {.id = 11, .position = {50, 5}},
                                             {.id = 12, .position = {50, 25}},
                                             {.id = 13, .position = {5, 25}}};
    std::vector<navigation::RouteEdge> edges;
    for (std::uint32_t i = 0; i < 4; ++i) {
      const auto side = i % 2 == 0 ? navigation::PipeSide::kLeft : navigation::PipeSide::kNone;
      edges.push_back({.id = i, .from = i, .to = (i + 1) % 4, .pipe_side = side});
      edges.push_back({.id = 100 + i, .from = (i + 1) % 4, .to = i});
    }
    write_route_graph(folder_.path() / "yard.geojson", {nodes, edges});
  }

  Navigator& start(std::vector<NamedParameter> parameters = {}) {
    parameters.push_back({"map", (folder_.path() / "yard.yaml").string()});
    parameters.push_back({"graph", (folder_.path() / "yard.geojson").string()});
    parameters.push_back({"planning.readings", std::int64_t{3000}});
    auto& navigator = harness_.make<Navigator>({.name = "navigator", .parameters = parameters});
    const auto result = harness_.bring_up(navigator);
    EXPECT_TRUE(result.success) << result.message;
    return navigator;
  }

  [[nodiscard]] Odometry odometry() const {
    Odometry message;
    message.header.stamp = to_message(now_);
    message.header.frame_id = "map";
    message.child_frame_id = "base_link";
    message.pose.pose.position.x = pose_.x;
    message.pose.pose.position.y = pose_.y;
    message.pose.pose.orientation.w = std::cos(pose_.heading / 2);
    message.pose.pose.orientation.z = std::sin(pose_.heading / 2);
    for (std::size_t i = 0; i < 6; ++i) {
      message.pose.covariance[7 * i] = sigma_ * sigma_;
    }
    message.pose.covariance[35] = 1e-6;
    message.twist.twist.linear.x = speed_;
    return message;
  }

  [[nodiscard]] LaserScan scan() {
    LaserScan message;
    message.header.stamp = to_message(now_);
    message.angle_min = static_cast<float>(-std::numbers::pi);
    message.angle_increment = static_cast<float>(std::numbers::pi / 90);
    message.range_min = 0.1F;
    message.range_max = 100;
    flicker_ = frozen_ ? flicker_ : flicker_ % 7 + 1;
    message.ranges.assign(180, 80.0F + 0.01F * static_cast<float>(flicker_));
    return message;
  }

  /// One control cycle in which the robot obeys.
  void step() {
    now_ += kCycle;
    if (odometry_there_) {
      harness_.publish(topics::kOdometryFiltered, odometry());
    }
    if (scan_there_) {
      harness_.publish(topics::kScan, scan());
    }
    harness_.spin();
    harness_.set_time(now_);
    // The planner has a thread; simulated time stands still meanwhile.
    // It does not always end with a callback here, so the wait is in slices.
    constexpr int kSlices = 2000;
    for (int i = 0; i < kSlices && !is_quiet(); ++i) {
      harness_.spin_until([this] { return is_quiet(); }, std::chrono::milliseconds(5));
    }
    if (!commands_.empty()) {
      const auto& twist = commands_.back();
      speed_ = twist.linear.x;
      pose_ = navigation::drive_arc(pose_, speed_ == 0 ? 0 : twist.angular.z / speed_,
                                    speed_ * to_seconds(kCycle));
    }
  }

  /// Nothing is being planned.
  [[nodiscard]] bool is_quiet() { return harness_.context().activity()->busy_nodes().empty(); }

  template <class Done>
  bool run(double seconds, Done done) {
    for (double t = 0; t < seconds && !done(); t += to_seconds(kCycle)) {
      step();
    }
    return done();
  }

  template <class A>
  struct Sent {
    ActionClient<A> client;
    GoalId id;
    bool accepted = false;
    std::optional<GoalOutcome<A>> outcome;
    std::size_t feedbacks = 0;
  };
  template <class A>
  std::shared_ptr<Sent<A>> send(const char* name, typename A::Goal goal) {
    auto sent = std::make_shared<Sent<A>>();
    sent->client = harness_.peer().template create_action_client<A>(name);
    Sent<A>* raw = sent.get();
    sent->id = sent->client.send_goal(
        std::move(goal),
        {.response = [raw](const GoalResponse& response) { raw->accepted = response.accepted; },
         .feedback = [raw](const auto&) { ++raw->feedbacks; },
         .result = [raw](const GoalOutcome<A>& outcome) { raw->outcome = outcome; }});
    harness_.spin();
    return sent;
  }
  std::shared_ptr<Sent<NavigateToPose>> go_to(const Pose2d& pose, const char* frame = "map") {
    NavigateToPose::Goal goal;
    goal.pose.header.frame_id = frame;
    goal.pose.pose.position.x = pose.x;
    goal.pose.pose.position.y = pose.y;
    goal.pose.pose.orientation.w = std::cos(pose.heading / 2);
    goal.pose.pose.orientation.z = std::sin(pose.heading / 2);
    return send<NavigateToPose>("navigate_to_pose", goal);
  }

  [[nodiscard]] std::string said(Navigator& navigator) {
    return harness_.next_diagnostics(navigator).message;
  }

  testing::TemporaryFolder folder_;
  ComponentHarness harness_{{.simulated_time = true}};
  testing::Collector<geometry_msgs::msg::Twist> commands_ =
      harness_.collect(topics::kGroundVelocityCommand);
  testing::Collector<NavigatorState> states_ = harness_.collect(topics::kNavigatorState);
  testing::Collector<nav_msgs::msg::Path> plans_ = harness_.collect(topics::kPlan);
  Time now_ = kStart;
  Pose2d pose_{5, 5, 0};
  double speed_ = 0;
  double sigma_ = 0.05;
  int flicker_ = 1;
  bool frozen_ = false;
  bool odometry_there_ = true;
  bool scan_there_ = true;
};

TEST_F(NavigatorTest, NavigatesToAPoseAndSaysHowFarItIs) {
  start();
  const auto goal = go_to({15, 8, 0.5});
  EXPECT_TRUE(goal->accepted);
  ASSERT_TRUE(run(60, [&] { return goal->outcome.has_value(); }));
  EXPECT_EQ(goal->outcome->end, GoalEnd::kSucceeded);
  EXPECT_NEAR(pose_.x, 15, 0.1);
  EXPECT_NEAR(pose_.y, 8, 0.1);
  EXPECT_NEAR(pose_.heading, 0.5, 0.06);
  EXPECT_GT(goal->feedbacks, 3U);
  ASSERT_EQ(plans_.size(), 1U);
  EXPECT_EQ(plans_.back().header.frame_id, "map");
  EXPECT_NEAR(plans_.back().poses.back().pose.position.x, 15, 1e-6);
  EXPECT_EQ(commands_.back().linear.x, 0);
}

TEST_F(NavigatorTest, FollowsARouteAndInspectsATour) {
  start();
  FollowRoute::Goal route;
  route.nodes = {11, 12};
  const auto followed = send<FollowRoute>("follow_route", route);
  ASSERT_TRUE(run(200, [&] { return followed->outcome.has_value(); }));
  ASSERT_EQ(followed->outcome->end, GoalEnd::kSucceeded) << followed->outcome->result->reason;
  EXPECT_EQ(followed->outcome->result->nodes_passed, 2U);
  EXPECT_NEAR(pose_.y, 25, 0.2);

  const auto tour = send<InspectTour>("inspect_tour", {});
  ASSERT_TRUE(run(600, [&] { return tour->outcome.has_value(); }));
  ASSERT_EQ(tour->outcome->end, GoalEnd::kSucceeded) << tour->outcome->result->reason;
  EXPECT_EQ(tour->outcome->result->rows_passed, 2U);
  EXPECT_GE(tour->outcome->result->cost, tour->outcome->result->lower_bound);
  EXPECT_TRUE(tour->outcome->result->left_out.empty());
}

TEST_F(NavigatorTest, RefusesAndFailsWithAReason) {
  start();
  // Each time: who asks again wants to know again.
  for (int i = 0; i < 2; ++i) {
    EXPECT_FALSE(go_to({15, 8, 0}, "odom")->accepted);
    EXPECT_THAT(harness_.logs().back().text,
                HasSubstr("rejected: the goal is in frame 'odom', not in 'map'"));
  }
  EXPECT_FALSE(go_to({std::numeric_limits<double>::quiet_NaN(), 8, 0})->accepted);
  EXPECT_THAT(harness_.logs().back().text, HasSubstr("rejected: "));
  for (const auto& [pose, reason] : {std::pair{Pose2d{30, 15, 0}, "goal in collision"},
                                     std::pair{Pose2d{-20, 15, 0}, "goal outside the map"}}) {
    const auto goal = go_to(pose);
    ASSERT_TRUE(run(20, [&] { return goal->outcome.has_value(); }));
    EXPECT_EQ(goal->outcome->end, GoalEnd::kAborted);
    EXPECT_EQ(states_.back().failure, reason);
  }
  FollowRoute::Goal route;
  route.nodes = {99};
  const auto unknown = send<FollowRoute>("follow_route", route);
  ASSERT_TRUE(run(20, [&] { return unknown->outcome.has_value(); }));
  EXPECT_THAT(unknown->outcome->result->reason, HasSubstr("unknown node"));
}

TEST_F(NavigatorTest, ClosedEdgesLeadItAnotherWay) {
  auto& navigator = start();
  FollowRoute::Goal route;
  route.nodes = {11};
  const auto goal = send<FollowRoute>("follow_route", route);
  ASSERT_TRUE(run(30, [&] { return pose_.x > 12; }));
  ASSERT_TRUE(
      harness_.set_parameter(navigator, "closed_edges", std::vector<std::int64_t>{0}).successful);
  bool was_north = false;
  ASSERT_TRUE(run(400, [&] {
    was_north |= pose_.y > 20;
    return goal->outcome.has_value();
  }));
  EXPECT_EQ(goal->outcome->end, GoalEnd::kSucceeded);
  EXPECT_TRUE(was_north);
}

TEST_F(NavigatorTest, PreemptsCancelsAndPauses) {
  start();
  const auto first = go_to({25, 8, 0});
  run(3, [] { return false; });
  const auto second = go_to({20, 5, 0});
  ASSERT_TRUE(first->outcome.has_value());
  EXPECT_EQ(first->outcome->end, GoalEnd::kAborted);
  FollowRoute::Goal route;
  route.nodes = {11};
  const auto third = send<FollowRoute>("follow_route", route);
  ASSERT_TRUE(second->outcome.has_value());
  EXPECT_EQ(second->outcome->end, GoalEnd::kAborted);
  ASSERT_TRUE(run(6, [&] { return speed_ == 0; }));
  ASSERT_TRUE(run(20, [&] { return speed_ > 1; }));

  std_srvs::srv::SetBool::Request pause;
  pause.data = true;
  EXPECT_TRUE(harness_.call<std_srvs::srv::SetBool>("navigator/pause", pause)->success);
  ASSERT_TRUE(run(6, [&] { return speed_ == 0; }));
  EXPECT_EQ(states_.back().reason, "paused");
  pause.data = false;
  EXPECT_TRUE(harness_.call<std_srvs::srv::SetBool>("navigator/pause", pause)->success);
  ASSERT_TRUE(run(6, [&] { return speed_ > 0.5; }));

  third->client.cancel(third->id);
  harness_.spin();
  ASSERT_TRUE(third->outcome.has_value());
  EXPECT_EQ(third->outcome->end, GoalEnd::kCanceled);
  EXPECT_EQ(third->outcome->result->reason, "canceled");
  ASSERT_TRUE(run(6, [&] { return speed_ == 0; }));
}

TEST_F(NavigatorTest, AThousandGoalsLeaveOneThatIsReached) {
  start();
  std::shared_ptr<Sent<NavigateToPose>> last;
  for (int i = 0; i < 1000; ++i) {
    const auto before = last;
    last = go_to({15 + 0.001 * i, 8, 0});
    ASSERT_TRUE(last->accepted);
    ASSERT_TRUE(!before || before->outcome.has_value());
    if (i % 50 == 0) {
      step();
    }
  }
  ASSERT_TRUE(run(60, [&] { return last->outcome.has_value(); }));
  EXPECT_EQ(last->outcome->end, GoalEnd::kSucceeded);
}

TEST_F(NavigatorTest, GoalPoseIsAGoalToo) {
  start();
  geometry_msgs::msg::PoseStamped goal;
  goal.header.frame_id = "map";
  goal.pose.position.x = 12;
  goal.pose.position.y = 5;
  goal.pose.orientation.w = 1;
  harness_.publish(topics::kGoalPose, goal);
  ASSERT_TRUE(run(40, [&] { return !states_.empty() && states_.back().state == "succeeded"; }));
  EXPECT_NEAR(pose_.x, 12, 0.1);
}

TEST_F(NavigatorTest, InputsThatCannotBeDrivenByStopItWithAReason) {
  auto& navigator = start({{"lost_after", 5.0}});
  const auto drive = [&] {
    pose_ = {5, 5, 0};
    const auto goal = go_to({45, 5, 0});
    EXPECT_TRUE(run(20, [&] { return speed_ > 1; }));
    return goal;
  };
  const auto stopped = [&](const std::string& reason) {
    EXPECT_TRUE(run(4, [&] { return speed_ == 0; })) << reason;
    EXPECT_EQ(states_.back().reason, reason);
  };
  (void)drive();
  odometry_there_ = false;
  stopped("localisation stale");
  EXPECT_THAT(said(navigator), HasSubstr("localisation stale"));
  now_ = kStart + std::chrono::hours(1);
  odometry_there_ = true;

  (void)drive();
  frozen_ = true;
  stopped("scan frozen");
  frozen_ = false;

  (void)drive();
  sigma_ = 2;
  stopped("localisation uncertain");
  sigma_ = 0.05;

  const auto goal = drive();
  scan_there_ = false;
  stopped("scan stale");
  ASSERT_TRUE(run(10, [&] { return goal->outcome.has_value(); }));
  EXPECT_EQ(states_.back().failure, "scan lost");
}

TEST_F(NavigatorTest, BadInputIsCountedByName) {
  auto& navigator = start();
  step();
  Odometry elsewhere = odometry();
  elsewhere.header.frame_id = "odom";
  harness_.publish(topics::kOdometryFiltered, elsewhere);
  Odometry without = odometry();
  without.pose.covariance = {};
  harness_.publish(topics::kOdometryFiltered, without);
  harness_.publish(topics::kOdometryFiltered, odometry());
  LaserScan empty = scan();
  empty.ranges.clear();
  harness_.publish(topics::kScan, empty);
  nav_msgs::msg::OccupancyGrid costmap;
  costmap.header.frame_id = "map";
  costmap.info.resolution = 0.1F;
  costmap.info.width = 3;
  costmap.info.height = 3;
  costmap.info.origin.orientation.w = 1;
  harness_.publish(topics::kLocalCostmap, costmap);
  harness_.spin();
  const auto status = harness_.next_diagnostics(navigator);
  const auto value = [&](const char* key) { return harness_.value(status, key).value_or("none"); };
  EXPECT_EQ(value("odometry.header.frame_id"), "1");
  EXPECT_EQ(value("odometry.refused"), "1");
  EXPECT_EQ(value("odometry.header.stamp.not_increasing"), "1");
  EXPECT_EQ(value("scan.bad_geometry"), "1");
  EXPECT_EQ(value("local_costmap.refused"), "1");
}

TEST_F(NavigatorTest, ACostmapOfOthersStopsIt) {
  start({{"obstacles.largest_offset", 0.0}});
  (void)go_to({45, 5, 0});
  nav_msgs::msg::OccupancyGrid costmap;
  costmap.header.frame_id = "map";
  costmap.info.resolution = 0.1F;
  costmap.info.width = 5;
  costmap.info.height = 80;
  costmap.info.origin.position.x = 20;
  costmap.info.origin.position.y = 1;
  costmap.info.origin.orientation.w = 1;
  costmap.data.assign(400, 100);
  ASSERT_TRUE(run(20, [&] {
    costmap.header.stamp = to_message(now_);
    harness_.publish(topics::kLocalCostmap, costmap);
    return !states_.empty() && states_.back().reason == "path blocked" && speed_ == 0 &&
           pose_.x > 10;
  }));
  EXPECT_LT(pose_.x + 1.55, 20);
}

TEST_F(NavigatorTest, ACostmapThatGrowsAndMovesIsTakenAsItIs) {
  start();
  const auto goal = go_to({40, 5, 0});
  std::uint32_t size = 5;
  ASSERT_TRUE(run(60, [&] {
    // Around the robot, larger each time, with an obstacle far beside the path.
    nav_msgs::msg::OccupancyGrid costmap;
    costmap.header.frame_id = "map";
    costmap.header.stamp = to_message(now_);
    costmap.info.resolution = size % 2 == 0 ? 0.1F : 0.05F;
    costmap.info.width = size;
    costmap.info.height = size + 3;
    costmap.info.origin.position.x = pose_.x - 1;
    costmap.info.origin.position.y = pose_.y + 4;
    costmap.info.origin.orientation.w = 1;
    costmap.data.assign(static_cast<std::size_t>(size) * (size + 3), 0);
    costmap.data.back() = 100;
    harness_.publish(topics::kLocalCostmap, costmap);
    size = std::min(size + 1, 200U);
    return goal->outcome.has_value();
  }));
  EXPECT_EQ(goal->outcome->end, GoalEnd::kSucceeded);
  EXPECT_NEAR(pose_.x, 40, 0.1);
}

TEST_F(NavigatorTest, PushedOffItsPathByTwoMetresItPlansAnewAndArrives) {
  start();
  const auto goal = go_to({40, 8, 0});
  ASSERT_TRUE(run(30, [&] { return speed_ > 1 && pose_.x > 12; }));
  pose_.y += 2;
  bool said_so = false;
  ASSERT_TRUE(run(90, [&] {
    said_so |= states_.back().reason == "off the path" && speed_ == 0;
    return goal->outcome.has_value();
  }));
  EXPECT_TRUE(said_so);
  EXPECT_EQ(goal->outcome->end, GoalEnd::kSucceeded);
  EXPECT_NEAR(pose_.y, 8, 0.1);
  EXPECT_EQ(plans_.size(), 2U);
}

TEST_F(NavigatorTest, StandsWhereThereIsNoWayToBegin) {
  start();
  pose_ = {30, 15, 0};
  const auto inside = go_to({20, 5, 0});
  ASSERT_TRUE(run(20, [&] { return inside->outcome.has_value(); }));
  EXPECT_EQ(states_.back().failure, "robot in collision");
  pose_ = {-30, 15, 0};
  const auto outside = go_to({20, 5, 0});
  ASSERT_TRUE(run(20, [&] { return outside->outcome.has_value(); }));
  EXPECT_EQ(states_.back().failure, "robot outside the map");
  EXPECT_EQ(speed_, 0);
  EXPECT_TRUE(plans_.empty());
}

TEST_F(NavigatorTest, AGraphWithoutTheWayIsARouteThatFails) {
  // Two nodes that no edge joins.
  write_route_graph(folder_.path() / "yard.geojson",
                    {{{.id = 1, .position = {5, 5}}, {.id = 2, .position = {50, 5}}}, {}});
  start();
  for (const auto& [nodes, reason] :
       {std::pair{std::vector<std::int64_t>{2}, "no route"},
        std::pair{std::vector<std::int64_t>{}, "nothing to drive to"}}) {
    FollowRoute::Goal route;
    route.nodes = nodes;
    const auto goal = send<FollowRoute>("follow_route", route);
    ASSERT_TRUE(run(20, [&] { return goal->outcome.has_value(); }));
    EXPECT_EQ(goal->outcome->end, GoalEnd::kAborted);
    EXPECT_THAT(goal->outcome->result->reason, HasSubstr(reason));
  }
  const auto tour = send<InspectTour>("inspect_tour", {});
  ASSERT_TRUE(run(20, [&] { return tour->outcome.has_value(); }));
  EXPECT_THAT(tour->outcome->result->reason, HasSubstr("nothing to drive to"));
  EXPECT_EQ(speed_, 0);
}

TEST_F(NavigatorTest, ACameraAtOneSideIsDrivenAlongEachEdgeInItsDirection) {
  start({{"inspection.one_sided", true}});
  pose_ = {5, 5, 0};
  InspectTour::Goal goal;
  goal.rows = {0, 100};  // there and back
  const auto tour = send<InspectTour>("inspect_tour", goal);
  ASSERT_TRUE(run(600, [&] { return tour->outcome.has_value(); }));
  ASSERT_EQ(tour->outcome->end, GoalEnd::kSucceeded) << tour->outcome->result->reason;
  EXPECT_EQ(tour->outcome->result->rows_passed, 2U);
  EXPECT_NEAR(pose_.x, 5, 0.5);
  EXPECT_LT(std::cos(pose_.heading), -0.9);
}

TEST_F(NavigatorTest, WhatIsProbablyNotMeantOfTheMapIsSaid) {
  // One row of pixels of the grey that map savers write for what is unknown.
  const auto image = folder_.path() / "yard.pgm";
  std::fstream file(image, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(-600, std::ios::end);
  file << std::string(600, static_cast<char>(205));
  file.close();
  start();
  const auto logs = harness_.logs();
  EXPECT_TRUE(std::ranges::any_of(logs, [](const testing::LogEntry& entry) {
    return entry.severity == LogSeverity::kWarn &&
           entry.text.find("600 of 180000 pixels have the grey 205") != std::string::npos;
  }));
}

TEST_F(NavigatorTest, WrongParametersAreNamed) {
  for (const auto& [parameter, text] : std::vector<std::pair<NamedParameter, std::string>>{
           {{"map", std::string()}, "parameter 'map'"},
           {{"map", (folder_.path() / "nowhere.yaml").string()}, "nowhere.yaml"},
           {{"graph", (folder_.path() / "nowhere.geojson").string()}, "nowhere.geojson"},
           {{"footprint", std::vector<double>{1, 1, 0}}, "parameter 'footprint'"},
           {{"hardest_braking", 0.5}, "hardest_braking"}}) {
    std::vector<NamedParameter> parameters{{"map", (folder_.path() / "yard.yaml").string()},
                                           parameter};
    auto& navigator = harness_.make<Navigator>({.name = "wrong", .parameters = parameters});
    const auto result = harness_.configure(navigator);
    EXPECT_FALSE(result.success);
    EXPECT_THAT(result.message, HasSubstr(text));
    harness_.destroy(navigator);
  }
}

}  // namespace
}  // namespace pipescout
