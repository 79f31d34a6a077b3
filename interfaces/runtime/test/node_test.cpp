// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/node.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <rcl_interfaces/msg/log.hpp>
#include <rosgraph_msgs/msg/clock.hpp>
#include <std_msgs/msg/header.hpp>
#include <std_srvs/srv/set_bool.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/standard_topics.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using rosgraph_msgs::msg::Clock;
using std::chrono::seconds;
using testing::ComponentHarness;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

class NodeTest : public ::testing::Test {
 protected:
  NodeOptions options(const std::string& name, const std::vector<std::string>& remappings = {}) {
    return harness_.component_options({.name = name, .remappings = remappings});
  }

  void publish_time(Duration since_start, const std::string& topic = "/clock") {
    Clock message;
    message.clock = to_message(Time(since_start));
    harness_.publish(topic, message);
    harness_.spin();
  }

  /// The nodes that `ros2 topic info` shows as subscribing to a topic.
  std::vector<std::string> subscribers(const std::string& wire_topic) {
    std::vector<std::string> result;
    for (const GraphEndpoint& endpoint : harness_.context().graph().endpoints()) {
      if (!endpoint.is_publisher && endpoint.wire_topic == wire_topic) {
        result.push_back(endpoint.node ? endpoint.node->fully_qualified() : "nobody");
      }
    }
    return result;
  }

  ComponentHarness harness_;
};

TEST_F(NodeTest, ChangesBetweenSystemAndSimulatedTimeWhileItRuns) {
  Node node(options("node"));
  int ticks = 0;
  const auto timer = node.create_timer(seconds(10), [&ticks] { ++ticks; });
  const Time system = node.now();
  EXPECT_GT(system, Time(std::chrono::hours(24)));

  EXPECT_TRUE(node.parameters().set("use_sim_time", true).successful);
  EXPECT_EQ(node.now(), Time{});
  publish_time(seconds(9));
  EXPECT_EQ(node.now(), Time(seconds(9)));
  EXPECT_EQ(ticks, 0);
  publish_time(seconds(10));
  EXPECT_EQ(ticks, 1);

  EXPECT_TRUE(node.parameters().set("use_sim_time", false).successful);
  EXPECT_GE(node.now(), system);
  publish_time(seconds(100));
  EXPECT_EQ(ticks, 1);
}

TEST_F(NodeTest, EveryNodeWithSimulatedTimeIsSeenToFollowTheClock) {
  const Node first(options("first"));
  Node second(options("second"));
  EXPECT_THAT(subscribers("rt/clock"), IsEmpty());
  first.parameters().set("use_sim_time", true);
  {
    const Node third(options("third"));
    third.parameters().set("use_sim_time", true);
    second.parameters().set("use_sim_time", true);
    EXPECT_THAT(subscribers("rt/clock"), UnorderedElementsAre("/first", "/second", "/third"));
  }
  first.parameters().set("use_sim_time", false);
  EXPECT_THAT(subscribers("rt/clock"), UnorderedElementsAre("/second"));
  publish_time(seconds(5));
  EXPECT_EQ(second.now(), Time(seconds(5)));
}

TEST_F(NodeTest, ARemappedClockDrivesItsNodeAlone) {
  const Node plain(options("plain"));
  const Node remapped(options("remapped", {"/clock:=/twin/clock"}));
  plain.parameters().set("use_sim_time", true);
  remapped.parameters().set("use_sim_time", true);
  publish_time(seconds(5));
  publish_time(seconds(7), "/twin/clock");
  EXPECT_EQ(plain.now(), Time(seconds(5)));
  EXPECT_EQ(remapped.now(), Time(seconds(7)));
  EXPECT_THAT(subscribers("rt/twin/clock"), UnorderedElementsAre("/remapped"));
}

TEST_F(NodeTest, SaysWhichNameOrTypeIsWrong) {
  using Message = std_msgs::msg::Header;
  Node node(options("node"));
  const auto publisher = node.create_publisher<Message>("topic", QoS::reliable());
  EXPECT_THROW((void)node.create_publisher<Message>("no topic", QoS::reliable()), InvalidName);
  EXPECT_THROW((void)node.create_publisher<Clock>("topic", QoS::reliable()), TopicTypeMismatch);
  EXPECT_THROW((void)node.create_publisher<Message>("other", QoS{.depth = 0}),
               std::invalid_argument);
  EXPECT_THROW((void)node.create_subscription<Clock>("topic", QoS::reliable(), [](const Clock&) {}),
               TopicTypeMismatch);
  EXPECT_THROW((void)node.create_client<std_srvs::srv::SetBool>("1st"), InvalidName);
  EXPECT_THROW((void)node.create_timer(seconds(0), [] {}), std::invalid_argument);
}

TEST_F(NodeTest, ItsLogSaysWhereItWasSaid) {
  const auto logs = harness_.collect<rcl_interfaces::msg::Log>(topics::kRosout);
  const Node node(options("node"));
  const auto here = Logger::Location::current();
  node.logger().warn("here");
  harness_.spin();
  ASSERT_EQ(logs.size(), 1U);
  EXPECT_EQ(logs.at(0).file, here.file_name());
  EXPECT_EQ(logs.at(0).function, here.function_name());
  EXPECT_EQ(logs.at(0).line, here.line() + 1);
}

TEST_F(NodeTest, RefusesACallbackGroupOfAnotherNode) {
  Node node(options("node"));
  Node other(options("other"));
  const auto foreign = other.create_callback_group(CallbackGroupType::kReentrant);
  const auto own = node.create_callback_group(CallbackGroupType::kReentrant);
  const auto publishers = node.publishers().size();
  using std_msgs::msg::Header;
  using std_srvs::srv::SetBool;
  const auto hear = [](const Header&) {};
  const auto serve = [](const SetBool::Request&, SetBool::Response&) {};
  EXPECT_THROW((void)node.create_publisher<Header>("out", QoS::reliable(), {.group = foreign}),
               std::invalid_argument);
  EXPECT_THROW(
      (void)node.create_subscription<Header>("in", QoS::reliable(), hear, {.group = foreign}),
      std::invalid_argument);
  EXPECT_THROW((void)node.create_service<SetBool>("set", serve, {.group = foreign}),
               std::invalid_argument);
  EXPECT_THROW((void)node.create_client<SetBool>("set", {.group = foreign}), std::invalid_argument);
  EXPECT_THROW((void)node.create_timer(seconds(1), [] {}, {.group = foreign}),
               std::invalid_argument);
  EXPECT_EQ(node.publishers().size(), publishers) << "nothing is left behind";
  EXPECT_NO_THROW((void)node.create_timer(seconds(1), [] {}, {.group = own}));
}

}  // namespace
}  // namespace pipescout
