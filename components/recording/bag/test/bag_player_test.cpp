// SPDX-License-Identifier: Apache-2.0
#include "pipescout/bag_recording/bag_player.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <rosbag2_interfaces/srv/burst.hpp>
#include <rosbag2_interfaces/srv/get_rate.hpp>
#include <rosbag2_interfaces/srv/is_paused.hpp>
#include <rosbag2_interfaces/srv/pause.hpp>
#include <rosbag2_interfaces/srv/play_next.hpp>
#include <rosbag2_interfaces/srv/resume.hpp>
#include <rosbag2_interfaces/srv/seek.hpp>
#include <rosbag2_interfaces/srv/set_rate.hpp>
#include <rosbag2_interfaces/srv/toggle_paused.hpp>
#include <rosgraph_msgs/msg/clock.hpp>
#include <std_msgs/msg/int32.hpp>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/runtime/bring_up.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/testing/component_harness.hpp"
#include "pipescout/testing/fake_transport.hpp"
#include "pipescout/testing/program.hpp"
#include "support.hpp"

namespace pipescout {
namespace {

namespace srv = rosbag2_interfaces::srv;
using bag_test::Line;
using bag_test::write_bag;
using std_msgs::msg::String;
using testing::ComponentHarness;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

using Parameters = std::vector<NamedParameter>;

/// So fast that nobody waits.
const NamedParameter kAtOnce{"rate", 1e6};

class BagPlayerTest : public ::testing::Test {
 protected:
  BagPlayer& make(Parameters parameters, std::vector<std::string> remappings = {}) {
    parameters.push_back({"bag", bag_.string()});
    return harness_.make<BagPlayer>({.name = "player",
                                     .parameters = std::move(parameters),
                                     .remappings = std::move(remappings)});
  }
  void bring_up(Parameters parameters, std::vector<std::string> remappings = {}) {
    const auto result = harness_.bring_up(make(std::move(parameters), std::move(remappings)));
    ASSERT_TRUE(result.success) << result.message;
  }
  /// Hears all text topics in one list.
  void listen(const std::string& topic) {
    subscriptions_.push_back(harness_.peer().create_subscription<String>(
        topic, QoS::reliable(), [this](const String& text) { heard_.push_back(text.data); },
        // Between topics a queue would change the order.
        {.at_once = true}));
  }
  [[nodiscard]] bool await(std::size_t messages) {
    return harness_.spin_until([&] { return heard_.size() >= messages; });
  }
  [[nodiscard]] bool is_paused() {
    return harness_.call<srv::IsPaused>("player/is_paused", {})->paused;
  }
  std::uint64_t burst(std::uint64_t messages) {
    srv::Burst::Request request;
    request.num_messages = messages;
    return harness_.call<srv::Burst>("player/burst", request)->actually_burst;
  }
  bool seek(std::int64_t milliseconds) {
    srv::Seek::Request request;
    request.time = to_message(Time(std::chrono::milliseconds(milliseconds)));
    return harness_.call<srv::Seek>("player/seek", request)->success;
  }
  bool set_rate(double rate) {
    srv::SetRate::Request request;
    request.rate = rate;
    return harness_.call<srv::SetRate>("player/set_rate", request)->success;
  }

  const ::pipescout::testing::TemporaryFolder temporary_;
  const std::filesystem::path bag_ = temporary_.path() / "bag";
  ComponentHarness harness_;
  std::vector<std::string> heard_;
  std::vector<Subscription<String>> subscriptions_;
};

TEST_F(BagPlayerTest, PlaysByStampAndEqualStampsAsInTheFile) {
  write_bag(bag_, {{"/a", 1000, "one"},
                   {"/b", 3000, "three"},
                   {"/a", 2000, "two"},
                   {"/a", 3000, "four"},
                   {"/b", 3000, "five"}});
  listen("a");
  listen("b");
  const auto status =
      harness_.collect<pipescout_msgs::msg::MissionStatus>("mission/status", QoS::latched());
  bring_up({kAtOnce});
  ASSERT_TRUE(harness_.spin_until([&] {
    return !status.empty() && status.back().state == pipescout_msgs::msg::MissionStatus::COMPLETE;
  }));
  EXPECT_THAT(heard_, ElementsAre("one", "two", "three", "four", "five"));
}

TEST_F(BagPlayerTest, TypesNeedNotBeKnown) {
  write_bag(bag_, {{"/secret", 1, "x"}}, "nobody_msgs/msg/Unheard");
  std::vector<std::size_t> sizes;
  const auto subscription = harness_.peer().create_generic_subscription(
      "secret", "nobody_msgs/msg/Unheard", QoS::reliable(),
      [&](const SerializedMessage& message) { sizes.push_back(message.bytes().size()); });
  bring_up({kAtOnce});
  ASSERT_TRUE(harness_.spin_until([&] { return !sizes.empty(); }));
  EXPECT_EQ(sizes.at(0), bag_test::text_bytes("x")->bytes().size());
}

TEST_F(BagPlayerTest, OnlyTheTopicsAskedForUnderTheNamesAskedFor) {
  write_bag(bag_, {{"/a", 1, "a"}, {"/b", 2, "b"}, {"/c", 3, "c"}});
  listen("a");
  listen("elsewhere");
  listen("c");
  bring_up({kAtOnce, {"topics", std::vector<std::string>{"a", "/b"}}}, {"/b:=/elsewhere"});
  ASSERT_TRUE(await(2));
  harness_.spin();
  EXPECT_THAT(heard_, ElementsAre("a", "b"));
}

TEST_F(BagPlayerTest, IsSteeredByTheServicesOfRosbag2) {
  std::vector<Line> lines;
  for (std::int64_t i = 0; i < 10; ++i) {
    lines.push_back({"/a", 1000 * i, std::to_string(i)});
  }
  write_bag(bag_, lines);
  listen("a");
  bring_up({{"start_paused", true}});
  EXPECT_TRUE(is_paused());
  EXPECT_TRUE(harness_.call<srv::PlayNext>("player/play_next", {})->success);
  EXPECT_EQ(burst(2), 2U);
  harness_.spin();
  EXPECT_THAT(heard_, ElementsAre("0", "1", "2"));

  EXPECT_TRUE(seek(8000));
  EXPECT_FALSE(seek(10'000));
  EXPECT_FALSE(seek(-1));
  EXPECT_EQ(burst(0), 2U);  // to the end
  EXPECT_FALSE(harness_.call<srv::PlayNext>("player/play_next", {})->success);
  EXPECT_TRUE(seek(5000));
  harness_.spin();
  EXPECT_THAT(heard_, ElementsAre("0", "1", "2", "8", "9"));

  EXPECT_FALSE(set_rate(0.0));
  EXPECT_FALSE(set_rate(std::numeric_limits<double>::infinity()));
  EXPECT_TRUE(set_rate(1e6));
  EXPECT_EQ(harness_.call<srv::GetRate>("player/get_rate", {})->rate, 1e6);
  ASSERT_TRUE(harness_.call<srv::Resume>("player/resume", {}));
  EXPECT_EQ(burst(1), 0U);  // only while paused
  ASSERT_TRUE(await(10));
  EXPECT_EQ(heard_.back(), "9");
  EXPECT_FALSE(is_paused());
  ASSERT_TRUE(harness_.call<srv::TogglePaused>("player/toggle_paused", {}));
  EXPECT_TRUE(is_paused());
  ASSERT_TRUE(harness_.call<srv::TogglePaused>("player/toggle_paused", {}));
  EXPECT_FALSE(is_paused());
  ASSERT_TRUE(harness_.call<srv::Pause>("player/pause", {}));
  EXPECT_TRUE(is_paused());
}

TEST_F(BagPlayerTest, BeginsAtAnOffsetAndAgainAfterTheEnd) {
  write_bag(bag_, {{"/a", 0, "0"}, {"/a", 1000, "1"}, {"/a", 2000, "2"}});
  listen("a");
  bring_up({kAtOnce, {"loop", true}, {"start_offset", 0.5}});
  ASSERT_TRUE(await(5));
  heard_.resize(5);
  EXPECT_THAT(heard_, ElementsAre("1", "2", "1", "2", "1"));
}

TEST_F(BagPlayerTest, WaitsForTheSubscriptionsThatAreThere) {
  write_bag(bag_, {{"/a", 1, "one"}, {"/a", 2, "two"}});
  testing::FakeNetwork network;
  Executor executor;
  Node there({.context = Context::create(network.create_transport("there")),
              .executor = &executor,
              .name = {"/", "listener"}});
  const auto subscription = there.create_subscription<String>(
      "a", QoS::reliable(), [this](const String& text) { heard_.push_back(text.data); });
  network.hold_matching("rt/a");
  const auto player = make_component<BagPlayer>(
      ComponentOptions{.context = Context::create(network.create_transport("player")),
                       .executor = &executor,
                       .name = {"/", "player"},
                       .parameter_overrides = {{"bag", ParameterValue(bag_.string())},
                                               {"rate", ParameterValue(1e6)},
                                               {"wait", ParameterValue(0.01)}}});
  std::string said;
  Logger logger = player->logger();  // a copy shares its state
  logger.set_sink(
      [&](LogSeverity, const std::string& text, const Logger::Location&) { said = text; });
  const auto spin_until = [&](const std::function<bool()>& done) {
    return executor.spin_until(
        [&] {
          network.deliver();
          return done();
        },
        testing::kPatience);
  };
  bool is_active = false;
  pipescout::bring_up(*player, [&](const TransitionResult& result) { is_active = result.success; });
  ASSERT_TRUE(spin_until([&] { return is_active; }));
  // Its complaint comes long after the time that it waits for once all are matched.
  ASSERT_TRUE(spin_until([&] { return said.find("waits for") != std::string::npos; }));
  EXPECT_THAT(said, HasSubstr("the subscriptions of /listener to /a"));
  network.allow_matching("rt/a");
  ASSERT_TRUE(spin_until([&] { return heard_.size() == 2; }));
  EXPECT_THAT(heard_, ElementsAre("one", "two"));
}

TEST_F(BagPlayerTest, WithNobodyThereItPlaysAllTheSame) {
  write_bag(bag_, {{"/a", 1, "one"}});
  const auto status =
      harness_.collect<pipescout_msgs::msg::MissionStatus>("mission/status", QoS::latched());
  bring_up({kAtOnce, {"wait", 0.01}});
  ASSERT_TRUE(harness_.spin_until([&] {
    return !status.empty() && status.back().state == pipescout_msgs::msg::MissionStatus::COMPLETE;
  }));
}

TEST_F(BagPlayerTest, MessagesWaitForTheirTime) {
  write_bag(bag_, {{"/a", 0, "0"}, {"/a", 40, "1"}});
  listen("a");
  const auto begin = steady_now();
  bring_up({{"delay", 0.02}});
  ASSERT_TRUE(await(2));
  EXPECT_GE(steady_now() - begin, std::chrono::milliseconds(60));
}

TEST_F(BagPlayerTest, PublishesTheTimeOfTheBag) {
  write_bag(bag_, {{"/a", 5000, "0"}, {"/clock", 5001, "not this one"}, {"/a", 6000, "1"}},
            "std_msgs/msg/String");
  const auto clock = harness_.collect<rosgraph_msgs::msg::Clock>("/clock");
  bring_up({{"start_paused", true}, {"clock_frequency", 1000.0}});
  ASSERT_TRUE(harness_.spin_until([&] { return clock.size() >= 2; }));
  EXPECT_EQ(from_message(clock.back().clock), Time(std::chrono::seconds(5)));
  EXPECT_EQ(burst(2), 2U);
  ASSERT_TRUE(harness_.spin_until(
      [&] { return from_message(clock.back().clock) == Time(std::chrono::seconds(6)); }));
}

TEST_F(BagPlayerTest, ATopicThatIsAnotherTypeHereIsNamedAndNotPlayed) {
  write_bag(bag_, {{"/a", 0, "a"}, {"/b", 1, "b"}});
  listen("b");
  const auto number = harness_.peer().create_subscription<std_msgs::msg::Int32>(
      "a", QoS::reliable(), [](const std_msgs::msg::Int32&) { FAIL(); });
  auto& player = make({kAtOnce});
  ASSERT_TRUE(harness_.bring_up(player).success);
  ASSERT_TRUE(await(1));
  EXPECT_THAT(heard_, ElementsAre("b"));
  EXPECT_EQ(player.diagnostics().counter("not_played./a"), 1U);
}

TEST_F(BagPlayerTest, WhatCannotBeIsRefusedByName) {
  EXPECT_THAT(harness_.bring_up(make({})).message, HasSubstr(bag_.string()));
}

TEST_F(BagPlayerTest, AnOffsetBehindTheEndIsRefused) {
  write_bag(bag_, {{"/a", 0, "0"}, {"/a", 1000, "1"}});
  EXPECT_THAT(harness_.bring_up(make({{"start_offset", 1.5}})).message,
              HasSubstr("start_offset = 1.5"));
}

TEST_F(BagPlayerTest, ABagThatIsCutIsPlayedAsFarAsItGoesAndThatIsSaid) {
  std::vector<Line> lines;
  for (std::int64_t i = 0; i < 100; ++i) {
    lines.push_back({"/a", i, std::string(10'000, 'x')});
  }
  write_bag(bag_, lines);
  const auto file = bag_ / "bag_0.db3";
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  const auto status =
      harness_.collect<pipescout_msgs::msg::MissionStatus>("mission/status", QoS::latched());
  auto& player = make({kAtOnce});
  const auto result = harness_.bring_up(player);
  if (result.success) {
    ASSERT_TRUE(harness_.spin_until([&] {
      return !status.empty() && status.back().state == pipescout_msgs::msg::MissionStatus::FAILED;
    }));
    EXPECT_THAT(status.back().message, HasSubstr("bag_0.db3"));
  } else {
    EXPECT_THAT(result.message, HasSubstr("bag_0.db3"));
  }
}

}  // namespace
}  // namespace pipescout
