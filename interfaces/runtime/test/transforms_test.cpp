// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/transforms.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <rosgraph_msgs/msg/clock.hpp>
#include <stdexcept>
#include <string>
#include <tf2_msgs/msg/tf_message.hpp>
#include <utility>
#include <vector>

#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/graph.hpp"
#include "pipescout/runtime/standard_topics.hpp"
#include "pipescout/runtime/transform_broadcaster.hpp"
#include "pipescout/testing/component_harness.hpp"
#include "pipescout/testing/fake_transport.hpp"

namespace pipescout {
namespace {

using geometry_msgs::msg::TransformStamped;
using testing::ComponentHarness;
using ::testing::HasSubstr;
using tf2_msgs::msg::TFMessage;

Time at(double seconds) {
  return Time(from_seconds(seconds));
}

TransformStamped transform(const std::string& parent, const std::string& child, double seconds,
                           double x = 0) {
  TransformStamped result;
  result.header.stamp = to_message(at(seconds));
  result.header.frame_id = parent;
  result.child_frame_id = child;
  result.transform.translation.x = x;
  result.transform.rotation.w = 1;
  return result;
}

TFMessage message(std::vector<TransformStamped> transforms) {
  TFMessage result;
  result.transforms = std::move(transforms);
  return result;
}

/// Looks up for the test.
class Looking final : public Component {
 public:
  explicit Looking(ComponentOptions options) : Component(std::move(options)) {}

  void wait(double time, Duration timeout, const std::string& source = "camera") {
    wait_ =
        transforms().wait_for("base", source, at(time), timeout,
                              [this](const TransformResult& result) { answers.push_back(result); });
  }
  void stop_waiting() { wait_ = {}; }

  std::vector<TransformResult> answers;

 private:
  CallbackReturn on_configure() override {
    (void)transforms();
    return CallbackReturn::kSuccess;
  }
  TransformWait wait_;
};

class TransformsTest : public ::testing::Test {
 protected:
  Looking& looking(const std::string& name = "looking") {
    auto& component = harness_.make<Looking>({.name = name});
    EXPECT_TRUE(harness_.bring_up(component).success);
    return component;
  }
  void send(std::vector<TransformStamped> transforms) {
    harness_.publish(topics::kTf, message(std::move(transforms)));
  }
  ComponentHarness harness_{{.ns = "/robot_1", .simulated_time = true}};
};

TEST_F(TransformsTest, AreThoseOfTheRobotAndThereAsSoonAsTheyArePublished) {
  auto& component = looking();
  StaticTransformBroadcaster(harness_.peer()).send(transform("arm", "camera", 0, 2));
  send({transform("base", "arm", 1, 1)});
  // Nothing has spun: a callback that is running finds what was published before it looked.
  const TransformResult result = component.transforms().lookup("base", "camera", at(1));
  ASSERT_TRUE(result) << result.failure().text;
  EXPECT_EQ(result->transform.translation.x, 3);
  const auto topics = harness_.context().graph().topics();
  EXPECT_TRUE(topics.contains("/robot_1/tf"));
  EXPECT_TRUE(topics.contains("/robot_1/tf_static"));
}

TEST_F(TransformsTest, NodesOfAProcessShareSubscriptionsAndEachIsInTheGraph) {
  auto& first = looking("first");
  auto& second = looking("second");
  EXPECT_EQ(&first.transforms().buffer(), &second.transforms().buffer());
  const auto listeners = [&] {
    std::vector<std::string> names;
    for (const GraphEndpoint& endpoint : harness_.context().graph().endpoints()) {
      if (endpoint.wire_topic == "rt/robot_1/tf" && !endpoint.is_publisher) {
        names.push_back(endpoint.node ? endpoint.node->name : "nobody");
      }
    }
    std::ranges::sort(names);
    return names;
  };
  EXPECT_THAT(listeners(), ::testing::ElementsAre("first", "second"));
  send({transform("base", "camera", 1)});
  EXPECT_EQ(second.transforms().statistics().received, 1U);
  harness_.destroy(first);
  EXPECT_THAT(listeners(), ::testing::ElementsAre("second"));
  send({transform("base", "camera", 2)});
  EXPECT_TRUE(second.transforms().can_transform("base", "camera", at(2)));
}

TEST_F(TransformsTest, AWaitIsAnsweredWhenTheTransformComes) {
  auto& component = looking();
  component.wait(1.5, std::chrono::seconds(5));
  send({transform("base", "camera", 1, 1)});
  harness_.spin();
  EXPECT_TRUE(component.answers.empty());
  send({transform("base", "camera", 2, 2)});
  EXPECT_TRUE(component.answers.empty());  // in the callback group, not on the publisher's thread
  harness_.spin();
  ASSERT_EQ(component.answers.size(), 1U);
  EXPECT_EQ(component.answers.front()->transform.translation.x, 1.5);
  harness_.advance(std::chrono::seconds(10));
  EXPECT_EQ(component.answers.size(), 1U);
}

TEST_F(TransformsTest, AWaitForWhatIsThereIsAnsweredAtOnce) {
  auto& component = looking();
  send({transform("base", "camera", 1, 1)});
  component.wait(1, Duration::zero());
  harness_.spin();
  ASSERT_EQ(component.answers.size(), 1U);
  EXPECT_TRUE(component.answers.front());
  component.wait(0.5, std::chrono::seconds(5));  // before the history: will never be known
  harness_.spin();
  ASSERT_EQ(component.answers.size(), 2U);
  EXPECT_EQ(component.answers.back().failure().error, TransformError::kPast);
}

TEST_F(TransformsTest, AWaitEndsWithTheReasonWhenTheTimeIsOver) {
  auto& component = looking();
  component.wait(1, std::chrono::seconds(2));
  harness_.advance(from_seconds(1.9));
  EXPECT_TRUE(component.answers.empty());
  harness_.advance(from_seconds(0.1));
  ASSERT_EQ(component.answers.size(), 1U);
  EXPECT_EQ(component.answers.front().failure().error, TransformError::kUnknownFrame);
}

TEST_F(TransformsTest, AWaitThatIsDestroyedIsOver) {
  auto& component = looking();
  component.wait(1, std::chrono::seconds(2));
  send({transform("base", "camera", 1)});
  component.stop_waiting();
  harness_.spin();
  harness_.advance(std::chrono::seconds(3));
  EXPECT_TRUE(component.answers.empty());
  EXPECT_THROW(component.wait(1, Duration(-1)), std::invalid_argument);
}

TEST_F(TransformsTest, WaitsAreBounded) {
  auto& component = looking();
  std::vector<TransformWait> waits;
  std::vector<TransformError> errors;
  for (int i = 0; i <= 1000; ++i) {
    waits.push_back(component.transforms().wait_for(
        "base", "camera", at(1), std::chrono::seconds(5),
        [&errors](const TransformResult& result) { errors.push_back(result.failure().error); }));
  }
  harness_.spin();
  EXPECT_THAT(errors, ::testing::ElementsAre(TransformError::kTooManyWaits));
  EXPECT_TRUE(waits.front().is_waiting());
  EXPECT_FALSE(waits.back().is_waiting());
}

// A node that is made in a callback, in a group of its own, is told by events from there on.
TEST_F(TransformsTest, ANodeThatStartsInACallbackWaitsForEvents) {
  std::optional<Node> node;
  TransformWait wait;
  std::optional<TransformResult> answer;
  harness_.peer().default_group()->post([&] {
    node.emplace(NodeOptions{.context = harness_.context().shared_from_this(),
                             .executor = &harness_.executor(),
                             .name = {"/robot_1", "late"}});
    const auto group = node->create_callback_group(CallbackGroupType::kMutuallyExclusive);
    wait = node->transforms().wait_for(
        "base", "camera", at(1), std::chrono::hours(1),
        [&](const TransformResult& result) { answer = result; }, group);
  });
  harness_.spin();
  ASSERT_TRUE(node);
  EXPECT_EQ(harness_.spin(), 0U);  // nothing runs while nothing comes
  send({transform("base", "camera", 1)});
  EXPECT_TRUE(harness_.spin_until([&] { return answer.has_value(); }));
  EXPECT_TRUE(*answer);
}

TEST_F(TransformsTest, WhatMovesIsForgottenWhenTheClockGoesBack) {
  auto& component = looking();
  harness_.set_time(at(50));
  StaticTransformBroadcaster(harness_.peer()).send(transform("arm", "camera", 0, 2));
  send({transform("base", "arm", 50)});
  ASSERT_TRUE(component.transforms().can_transform("base", "camera"));
  harness_.set_time(at(45));  // less than the history: the stamps alone would not tell
  EXPECT_FALSE(component.transforms().can_transform("base", "camera"));
  EXPECT_TRUE(component.transforms().can_transform("arm", "camera"));
  send({transform("base", "arm", 45)});
  EXPECT_TRUE(component.transforms().can_transform("base", "camera", at(45)));
}

TEST_F(TransformsTest, WhatIsRefusedIsCountedAndNamesWhoSentIt) {
  auto& component = looking();
  harness_.set_time(at(50));
  auto& other = harness_.make<Looking>({.name = "other"});
  ASSERT_TRUE(harness_.bring_up(other).success);
  TransformBroadcaster broadcaster(other);
  broadcaster.send(transform("odom", "base", 50));
  send({transform("map", "base", 50)});
  TransformStamped bad = transform("base", "camera", 50);
  bad.transform.rotation.w = std::numeric_limits<double>::quiet_NaN();
  send({bad, bad, transform("base", "arm", 61)});
  const auto refused = component.transforms().statistics().refused;
  EXPECT_EQ(refused.at(TransformFault::kTwoParents), 1U);
  EXPECT_EQ(refused.at(TransformFault::kNotFinite), 2U);
  EXPECT_EQ(refused.at(TransformFault::kFromFuture), 1U);
  harness_.spin();
  std::vector<std::string> texts;
  for (const auto& log : harness_.logs()) {
    if (log.severity == LogSeverity::kWarn) {
      texts.push_back(log.text);
    }
  }
  ASSERT_EQ(texts.size(), 3U);
  EXPECT_THAT(texts[0], HasSubstr("'base' has two parents: 'odom', which stays, and 'map'"));
  EXPECT_THAT(texts[0], HasSubstr("believed is /robot_1/other)"));
  EXPECT_THAT(texts[2], HasSubstr("11 s ahead of the clock"));
  const auto status = harness_.next_diagnostics(component);
  EXPECT_EQ(harness_.value(status, "tf.refused.two_parents"), "1");
  EXPECT_EQ(harness_.value(status, "tf.refused.not_finite"), "2");
  EXPECT_THAT(status.message, HasSubstr("tf.refused +4: transform of 'arm' in 'base'"));
  EXPECT_NE(status.level, diagnostic_msgs::msg::DiagnosticStatus::OK);
}

TEST_F(TransformsTest, StaticTransformsOfANodeAreInOneMessage) {
  StaticTransformBroadcaster broadcaster(harness_.peer());
  broadcaster.send({transform("base", "mast", 0, 1), transform("mast", "camera", 0, 2)});
  broadcaster.send(transform("base", "mast", 0, 5));
  const auto late = harness_.collect(topics::kTfStatic);
  harness_.spin();
  ASSERT_EQ(late.size(), 1U);
  EXPECT_EQ(late.at(0).transforms.size(), 2U);
  auto& component = looking();
  EXPECT_EQ(component.transforms().lookup("base", "camera")->transform.translation.x, 7);
}

TEST_F(TransformsTest, TheLongestHistoryThatIsAskedForHolds) {
  auto& component = looking();
  looking("second").transforms().require_history(std::chrono::seconds(20));
  for (int i = 0; i <= 30; ++i) {
    harness_.set_time(at(i));
    send({transform("base", "camera", i)});
  }
  EXPECT_TRUE(component.transforms().can_transform("base", "camera", at(10)));
  EXPECT_FALSE(component.transforms().can_transform("base", "camera", at(9)));
}

TEST(TransformsAcrossProcesses, StaticOnesOfSeveralPublishersReachALateListener) {
  testing::FakeNetwork network;
  const auto here = Context::create(network.create_transport("here"));
  const auto there = Context::create(network.create_transport("there"));
  Executor executor;
  Node first({.context = here, .executor = &executor, .name = {"/", "first"}});
  Node second({.context = here, .executor = &executor, .name = {"/", "second"}});
  StaticTransformBroadcaster mast(first);
  StaticTransformBroadcaster camera(second);
  mast.send(transform("base", "mast", 0, 1));
  camera.send(transform("mast", "camera", 0, 2));
  Node listening({.context = there, .executor = &executor, .name = {"/", "listening"}});
  Transforms& transforms = listening.transforms();
  while (network.deliver() + executor.spin_ready() > 0) {
  }
  const TransformResult result = transforms.lookup("base", "camera");
  ASSERT_TRUE(result) << result.failure().text;
  EXPECT_EQ(result->transform.translation.x, 3);
}

}  // namespace
}  // namespace pipescout
