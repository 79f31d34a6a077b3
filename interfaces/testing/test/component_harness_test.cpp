// SPDX-License-Identifier: Apache-2.0
#include "pipescout/testing/component_harness.hpp"

#include <gtest/gtest.h>

#include <lifecycle_msgs/srv/get_state.hpp>
#include <memory>
#include <std_msgs/msg/header.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace pipescout {
namespace {

using testing::Collector;
using testing::ComponentHarness;
using Message = std_msgs::msg::Header;

Message message(const std::string& text) {
  Message result;
  result.frame_id = text;
  return result;
}

/// Repeats each message with a prefix, and ticks once a second.
class Echo : public Component {
 public:
  explicit Echo(ComponentOptions options)
      : Component(std::move(options)),
        prefix_(parameters().declare<std::string>("prefix", "echo ")) {}

  int ticks = 0;

 private:
  CallbackReturn on_configure() override {
    publisher_ = create_publisher<Message>("out", QoS::reliable());
    subscription_ =
        create_subscription<Message>("in", QoS::reliable(), [this](const Message& received) {
          if (received.frame_id == "throw") {
            throw std::runtime_error("cannot repeat this");
          }
          logger().info("heard " + received.frame_id);
          publisher_.publish(message(prefix_.get() + received.frame_id));
        });
    timer_ = create_timer(std::chrono::seconds(1), [this] { ++ticks; });
    return CallbackReturn::kSuccess;
  }
  CallbackReturn on_cleanup() override {
    timer_.reset();
    subscription_ = {};
    publisher_ = {};
    return CallbackReturn::kSuccess;
  }

  Parameter<std::string> prefix_;
  Publisher<Message> publisher_;
  Subscription<Message> subscription_;
  std::shared_ptr<Timer> timer_;
};

std::vector<std::string> texts(const Collector<Message>& collector) {
  std::vector<std::string> result;
  for (const auto& received : collector.messages()) {
    result.push_back(received->frame_id);
  }
  return result;
}

TEST(ComponentHarness, CarriesMessagesThereAndBackInOrder) {
  ComponentHarness harness({.ns = "/robot_1"});
  auto& echo = harness.make<Echo>({.name = "echo"});
  const auto out = harness.collect<Message>("out");
  ASSERT_TRUE(harness.bring_up(echo).success);
  EXPECT_EQ(out.publisher_count(), 1U);
  for (const char* text : {"a", "b", "c"}) {
    harness.publish("in", message(text));
  }
  EXPECT_TRUE(out.empty());
  harness.spin();
  EXPECT_EQ(texts(out), (std::vector<std::string>{"echo a", "echo b", "echo c"}));
  EXPECT_EQ(out.back().frame_id, "echo c");
}

TEST(ComponentHarness, GivesOverridesAndRemappings) {
  ComponentHarness harness;
  auto& echo = harness.make<Echo>(
      {.name = "echo", .parameters = {{"prefix", "again "}}, .remappings = {"out:=/elsewhere"}});
  const auto out = harness.collect<Message>("/elsewhere");
  ASSERT_TRUE(harness.bring_up(echo).success);
  harness.publish("in", message("a"));
  harness.spin();
  EXPECT_EQ(texts(out), (std::vector<std::string>{"again a"}));
}

TEST(ComponentHarness, AWrongOverrideThrows) {
  ComponentHarness harness;
  EXPECT_THROW(harness.make<Echo>({.name = "echo", .parameters = {{"prefix", 5}}}), ParameterError);
  EXPECT_NO_THROW(harness.make<Echo>({.name = "echo"}));
}

TEST(ComponentHarness, TwoComponentsOfOneNameAreRefused) {
  ComponentHarness harness;
  harness.make<Echo>({.name = "echo"});
  EXPECT_THROW(harness.make<Echo>({.name = "echo"}), std::invalid_argument);
}

TEST(ComponentHarness, SetsParameters) {
  ComponentHarness harness;
  auto& echo = harness.make<Echo>();
  const auto out = harness.collect<Message>("out");
  ASSERT_TRUE(harness.bring_up(echo).success);
  EXPECT_TRUE(harness.set_parameter(echo, "prefix", "then ").successful);
  EXPECT_FALSE(harness.set_parameter(echo, "prefix", 1.0).successful);
  harness.publish("in", message("a"));
  harness.spin();
  EXPECT_EQ(texts(out), (std::vector<std::string>{"then a"}));
}

TEST(ComponentHarness, ReportsARefusedTransition) {
  ComponentHarness harness;
  auto& echo = harness.make<Echo>();
  const auto refused = harness.activate(echo);
  EXPECT_FALSE(refused.success);
  EXPECT_EQ(refused.state, LifecycleState::kUnconfigured);
  EXPECT_FALSE(refused.message.empty());
  ASSERT_TRUE(harness.bring_up(echo).success);
  ASSERT_TRUE(harness.deactivate(echo).success);
  ASSERT_TRUE(harness.cleanup(echo).success);
  ASSERT_TRUE(harness.shutdown(echo).success);
  EXPECT_FALSE(harness.shutdown(echo).success);
}

TEST(ComponentHarness, DrivesSimulatedTime) {
  ComponentHarness harness({.simulated_time = true});
  auto& echo = harness.make<Echo>();
  EXPECT_EQ(echo.now(), Time{});
  harness.set_time(Time(std::chrono::seconds(100)));
  ASSERT_TRUE(harness.bring_up(echo).success);
  EXPECT_EQ(echo.now(), Time(std::chrono::seconds(100)));
  harness.advance(std::chrono::milliseconds(999));
  EXPECT_EQ(echo.ticks, 0);
  harness.advance(std::chrono::milliseconds(1));
  EXPECT_EQ(echo.ticks, 1);
}

TEST(ComponentHarness, HasNoSimulatedTimeUnlessAsked) {
  ComponentHarness harness;
  EXPECT_THROW(harness.set_time(Time{}), std::logic_error);
}

TEST(ComponentHarness, ReadsLogs) {
  ComponentHarness harness({.ns = "/robot_1"});
  auto& echo = harness.make<Echo>({.name = "echo"});
  ASSERT_TRUE(harness.bring_up(echo).success);
  harness.publish("in", message("a"));
  harness.spin();
  const auto logs = harness.logs();
  ASSERT_FALSE(logs.empty());
  EXPECT_EQ(logs.back().severity, LogSeverity::kInfo);
  EXPECT_EQ(logs.back().logger, "robot_1.echo");
  EXPECT_EQ(logs.back().text, "heard a");
}

TEST(ComponentHarness, AnExceptionInACallbackLeavesTheOthersAlone) {
  ComponentHarness harness;
  auto& broken = harness.make<Echo>({.name = "broken", .remappings = {"in:=to_broken"}});
  auto& sound = harness.make<Echo>({.name = "sound"});
  const auto out = harness.collect<Message>("out");
  ASSERT_TRUE(harness.bring_up(broken).success);
  ASSERT_TRUE(harness.bring_up(sound).success);
  harness.publish("to_broken", message("throw"));
  harness.publish("in", message("a"));
  harness.spin();
  EXPECT_NE(broken.state(), LifecycleState::kActive);
  EXPECT_EQ(sound.state(), LifecycleState::kActive);
  EXPECT_EQ(texts(out), (std::vector<std::string>{"echo a"}));

  const auto statuses = harness.diagnostics(broken);
  ASSERT_FALSE(statuses.empty());
  EXPECT_EQ(statuses.back().level, diagnostic_msgs::msg::DiagnosticStatus::ERROR);
  EXPECT_NE(statuses.back().message.find("cannot repeat this"), std::string::npos);
  EXPECT_EQ(ComponentHarness::value(statuses.back(), "exceptions"), "1");
}

TEST(ComponentHarness, WaitsForDiagnosticsInRealTimeToo) {
  ComponentHarness harness;
  auto& echo = harness.make<Echo>();
  ASSERT_TRUE(harness.bring_up(echo).success);
  const auto status = harness.next_diagnostics(echo);
  EXPECT_EQ(ComponentHarness::value(status, "lifecycle_state"), "active");
  EXPECT_EQ(ComponentHarness::value(status, "no such key"), std::nullopt);
}

TEST(ComponentHarness, ACallThatTheExecutorGivesUpLeavesNothingBehind) {
  // The client answers when it goes: Clang's AddressSanitizer sees where to (GCC's does not).
  ComponentHarness harness;
  using lifecycle_msgs::srv::GetState;
  const auto silent = harness.peer().create_service<GetState>(
      "silent", [&harness](const std::shared_ptr<const GetState::Request>&,
                           const Responder<GetState>&) { harness.executor().stop(); });
  const auto result = harness.call<GetState>("silent", {});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error(), ServiceError::kTimeout);
}

TEST(ComponentHarness, DestroysAComponent) {
  ComponentHarness harness;
  auto& echo = harness.make<Echo>({.name = "echo"});
  ASSERT_TRUE(harness.bring_up(echo).success);
  harness.publish("in", message("never heard"));
  harness.destroy(echo);
  harness.spin();
  EXPECT_NO_THROW(harness.make<Echo>({.name = "echo"}));
}

TEST(ComponentHarness, PublishesOneTypePerTopic) {
  ComponentHarness harness;
  harness.publish("in", message("a"));
  EXPECT_ANY_THROW(harness.publish("in", diagnostic_msgs::msg::DiagnosticStatus()));
}

}  // namespace
}  // namespace pipescout
