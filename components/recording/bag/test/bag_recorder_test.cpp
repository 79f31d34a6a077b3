// SPDX-License-Identifier: Apache-2.0
#include "pipescout/bag_recording/bag_recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <diagnostic_msgs/msg/diagnostic_status.hpp>
#include <fstream>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <rosbag2_interfaces/msg/write_split_event.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/runtime/standard_topics.hpp"
#include "pipescout/testing/component_harness.hpp"
#include "pipescout/testing/fake_transport.hpp"
#include "support.hpp"

namespace pipescout {
namespace {

using bag_test::read_bag;
using bag_test::text_message;
using bag_test::WholeBag;
using pipescout_msgs::msg::MissionStatus;
using std_msgs::msg::String;
using testing::ComponentHarness;
using ::testing::ElementsAre;
using testing::HarnessOptions;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

using Parameters = std::vector<NamedParameter>;

class BagRecorderTest : public ::testing::Test {
 protected:
  BagRecorder& make(ComponentHarness& harness, Parameters parameters) const {
    parameters.push_back({"output", bag_.string()});
    parameters.push_back({"storage", "mcap"});
    return harness.make<BagRecorder>({.name = "recorder", .parameters = std::move(parameters)});
  }
  /// Ends the recording and reads it.
  WholeBag end(ComponentHarness& harness, BagRecorder& recorder) const {
    EXPECT_TRUE(harness.deactivate(recorder).success);
    return read_bag(bag_);
  }
  /// Why it cannot be brought up.
  [[nodiscard]] std::string refusal(Parameters parameters) const {
    ComponentHarness harness;
    return harness.bring_up(make(harness, std::move(parameters))).message;
  }

  const ::pipescout::testing::TemporaryFolder temporary_;
  const std::filesystem::path bag_ = temporary_.path() / "bag";
};

TEST_F(BagRecorderTest, RecordsTopicsAsTheyAppearWithTypesQosAndStamps) {
  ComponentHarness harness;
  auto& recorder = make(harness, {{"all", true}});
  ASSERT_TRUE(harness.bring_up(recorder).success);
  auto words = harness.peer().create_publisher<String>("words", QoS::sensor_data());
  auto secret =
      harness.peer().create_generic_publisher("secret", "nobody_msgs/msg/Unheard", QoS::reliable());
  harness.spin();
  words.publish(text_message("one"));
  const std::vector bytes{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}, std::byte{9}};
  secret.publish(SerializedMessage(bytes));
  words.publish(text_message("two"));
  const auto bag = end(harness, recorder);

  EXPECT_THAT(bag.texts("/words"), ElementsAre("one", "two"));
  const auto* topic = bag.topic("/words");
  ASSERT_NE(topic, nullptr);
  EXPECT_EQ(topic->type, "std_msgs/msg/String");
  EXPECT_EQ(topic->schema_encoding, "ros2msg");
  EXPECT_THAT(topic->offered_qos_profiles, HasSubstr("reliability: 2"));
  ASSERT_NE(bag.topic("/secret"), nullptr);
  EXPECT_EQ(bag.topic("/secret")->type, "nobody_msgs/msg/Unheard");
  for (const auto& message : bag.messages) {
    if (message.topic == "/secret") {
      EXPECT_EQ(message.bytes, bytes);
    }
    EXPECT_GT(message.publish_time, 0);
    EXPECT_GE(message.log_time, message.publish_time);
  }
}

TEST_F(BagRecorderTest, WhatLatchedTopicsHaveKeptIsRecorded) {
  ComponentHarness harness;
  auto words = harness.peer().create_publisher<String>("words", QoS::latched(3));
  words.publish(text_message("kept"));
  auto& recorder = make(harness, {{"topics", std::vector<std::string>{"words"}}});
  ASSERT_TRUE(harness.bring_up(recorder).success);
  EXPECT_THAT(end(harness, recorder).texts("/words"), ElementsAre("kept"));
}

TEST_F(BagRecorderTest, OnlyWhatWasAskedForIsRecorded) {
  ComponentHarness harness;
  auto& recorder = make(harness, {{"regex", "^/words"}, {"exclude", "secret"}});
  ASSERT_TRUE(harness.bring_up(recorder).success);
  for (const char* name : {"words", "words/secret", "numbers"}) {
    harness.publish(name, text_message("unheard"));
    harness.spin();
    harness.publish(name, text_message(name));
  }
  const auto bag = end(harness, recorder);
  EXPECT_THAT(bag.topics, SizeIs(1));
  EXPECT_THAT(bag.texts("/words"), ElementsAre("words"));
}

TEST_F(BagRecorderTest, ThePublisherReturnsWithItsMessageTakenAndNothingQueued) {
  ComponentHarness harness;
  auto& recorder = make(harness, {{"topics", std::vector<std::string>{"words"}}});
  ASSERT_TRUE(harness.bring_up(recorder).success);
  auto words = harness.peer().create_publisher<String>("words", QoS::reliable(1));
  harness.spin();
  // Far more than any queue's depth, while no callback runs.
  for (int i = 0; i < 3000; ++i) {
    words.publish(text_message(std::to_string(i)));
  }
  EXPECT_THAT(end(harness, recorder).messages, SizeIs(3000));
}

TEST_F(BagRecorderTest, InSimulatedTimeBothStampsAreThatTime) {
  ComponentHarness harness(HarnessOptions{.simulated_time = true});
  auto words = harness.peer().create_publisher<String>("words", QoS::reliable());
  auto& recorder = make(harness, {{"topics", std::vector<std::string>{"words"}}});
  ASSERT_TRUE(harness.bring_up(recorder).success);
  words.publish(text_message("before there was a time"));
  harness.set_time(Time(std::chrono::seconds(100)));
  words.publish(text_message("then"));
  harness.advance(std::chrono::seconds(1));
  words.publish(text_message("later"));
  const auto bag = end(harness, recorder);
  ASSERT_THAT(bag.messages, SizeIs(3));
  EXPECT_EQ(bag.messages[0].text(), "before there was a time");
  constexpr std::int64_t kSecond = 1'000'000'000;
  for (const auto& message : bag.messages) {
    EXPECT_EQ(message.log_time, (message.text() == "later" ? 101 : 100) * kSecond);
    EXPECT_EQ(message.publish_time, message.log_time);
  }
}

TEST_F(BagRecorderTest, ATopicWithTwoTypesIsNamedAndLeftOut) {
  testing::FakeNetwork network;
  Executor executor;
  const auto node = [&](const char* name) {
    return std::make_unique<Node>(
        NodeOptions{.context = Context::create(network.create_transport(name)),
                    .executor = &executor,
                    .name = {"/", name},
                    .standard_interfaces = false});
  };
  const auto first = node("first");
  const auto second = node("second");
  const auto words = first->create_publisher<String>("words", QoS::reliable());
  const auto other =
      second->create_generic_publisher("words", "nobody_msgs/msg/Unheard", QoS::reliable());
  const auto recorder = make_component<BagRecorder>(ComponentOptions{
      .context = Context::create(network.create_transport("recorder")),
      .executor = &executor,
      .name = {"/", "recorder"},
      .parameter_overrides = {{"output", bag_.string(), "test"},
                              {"topics", std::vector<std::string>{"/words"}, "test"}}});
  const auto settle = [&] {
    while (network.deliver() + executor.spin_ready() > 0) {
    }
  };
  settle();
  recorder->request_transition(LifecycleTransition::kConfigure);
  recorder->request_transition(LifecycleTransition::kActivate);
  settle();
  ASSERT_EQ(recorder->state(), LifecycleState::kActive);
  EXPECT_EQ(recorder->diagnostics().counter("not_recorded./words"), 1U);
  recorder->request_transition(LifecycleTransition::kDeactivate);
  settle();
  EXPECT_THAT(read_bag(bag_).topics, IsEmpty());
}

TEST_F(BagRecorderTest, AnotherFileIsAnnounced) {
  ComponentHarness harness;
  auto& recorder = make(harness, {{"topics", std::vector<std::string>{"words"}},
                                  {"max_bag_size", std::int64_t{86016}}});
  const auto events =
      harness.collect<rosbag2_interfaces::msg::WriteSplitEvent>("events/write_split");
  ASSERT_TRUE(harness.bring_up(recorder).success);
  auto words = harness.peer().create_publisher<String>("words", QoS::reliable());
  harness.spin();
  for (int i = 0; i < 4; ++i) {
    words.publish(text_message(std::string(50'000, 'x')));
  }
  ASSERT_TRUE(harness.spin_until([&] { return events.size() >= 1; }));
  EXPECT_EQ(events.at(0).closed_file, (bag_ / "bag_0.mcap").string());
  EXPECT_EQ(events.at(0).opened_file, (bag_ / "bag_1.mcap").string());
  EXPECT_THAT(end(harness, recorder).messages, SizeIs(4));
}

TEST_F(BagRecorderTest, ASnapshotIsWrittenWhenItIsAskedFor) {
  using rosbag2_interfaces::srv::Snapshot;
  ComponentHarness harness;
  auto& recorder =
      make(harness, {{"topics", std::vector<std::string>{"words"}}, {"snapshot_mode", true}});
  ASSERT_TRUE(harness.bring_up(recorder).success);
  auto words = harness.peer().create_publisher<String>("words", QoS::reliable());
  harness.spin();
  words.publish(text_message("kept"));
  const auto answer = harness.call<Snapshot>("recorder/snapshot", {});
  ASSERT_TRUE(answer);
  EXPECT_TRUE(answer->success);
  words.publish(text_message("not asked for"));
  EXPECT_THAT(end(harness, recorder).texts("/words"), ElementsAre("kept"));
}

TEST_F(BagRecorderTest, QosOverridesComeFromAFile) {
  const auto file = temporary_.path() / "qos.yaml";
  std::ofstream(file) << "/words: {durability: transient_local, reliability: reliable}\n";
  ComponentHarness harness;
  auto& recorder = make(
      harness, {{"topics", std::vector<std::string>{"words"}}, {"qos_overrides", file.string()}});
  ASSERT_TRUE(harness.bring_up(recorder).success);
  // Volatile: it does not go with what was asked for, and that is said.
  auto words = harness.peer().create_publisher<String>("words", QoS::reliable());
  harness.spin();
  words.publish(text_message("unheard"));
  EXPECT_EQ(recorder.diagnostics().counter("not_recorded./words"), 1U);
  EXPECT_THAT(end(harness, recorder).messages, IsEmpty());
}

/// What the recorder says of itself on mission/status.
std::vector<MissionStatus> reports(const testing::Collector<MissionStatus>& statuses) {
  std::vector<MissionStatus> found;
  for (std::size_t i = 0; i < statuses.size(); ++i) {
    if (statuses.at(i).node == "/recorder") {
      found.push_back(statuses.at(i));
    }
  }
  return found;
}

MissionStatus source_status(std::uint8_t state, std::uint32_t done = 0, std::uint32_t total = 0) {
  MissionStatus status;
  status.node = "/source";
  status.state = state;
  status.done = done;
  status.total = total;
  status.message = "its wheels are off";
  return status;
}

TEST_F(BagRecorderTest, ItIsCompleteWhenItsSourceIsAndNothingComesAnyMore) {
  ComponentHarness harness(HarnessOptions{.simulated_time = true});
  auto& recorder =
      make(harness, {{"all", true}, {"source", std::string("source")}, {"settle_time", 0.01}});
  const auto statuses = harness.collect(topics::kMissionStatus);
  ASSERT_TRUE(harness.bring_up(recorder).success);
  harness.publish(topics::kMissionStatus, source_status(MissionStatus::RUNNING, 3, 4));
  auto other = source_status(MissionStatus::COMPLETE);
  other.node = "/another";
  harness.publish(topics::kMissionStatus, other);
  // Simulated time stands still at the end.
  harness.publish(topics::kMissionStatus, source_status(MissionStatus::COMPLETE));
  ASSERT_TRUE(harness.spin_until([&] { return reports(statuses).size() >= 2; }));
  EXPECT_EQ(reports(statuses)[0].state, MissionStatus::RUNNING);
  EXPECT_EQ(reports(statuses)[0].done, 3U);
  EXPECT_EQ(reports(statuses)[1].state, MissionStatus::COMPLETE);
  const auto bag = end(harness, recorder);
  // It stands in the bag itself.
  EXPECT_THAT(bag.topic("/mission/status"), ::testing::NotNull());
}

TEST_F(BagRecorderTest, ItFailsWithItsSource) {
  ComponentHarness harness;
  auto& recorder = make(harness, {{"all", true}, {"source", std::string("source")}});
  const auto statuses = harness.collect(topics::kMissionStatus);
  ASSERT_TRUE(harness.bring_up(recorder).success);
  harness.publish(topics::kMissionStatus, source_status(MissionStatus::FAILED));
  ASSERT_TRUE(harness.spin_until([&] { return !reports(statuses).empty(); }));
  EXPECT_EQ(reports(statuses)[0].state, MissionStatus::FAILED);
  EXPECT_EQ(reports(statuses)[0].message, "/source failed: its wheels are off");
}

TEST_F(BagRecorderTest, ADiskThatIsFullWhenItEndsIsSaidWithWhatIsInTheBag) {
  ComponentHarness harness;
  auto& recorder = make(harness, {{"topics", std::vector<std::string>{"words"}}});
  const auto statuses = harness.collect(topics::kMissionStatus);
  auto words = harness.peer().create_publisher<String>("words", QoS::reliable());
  ASSERT_TRUE(harness.bring_up(recorder).success);
  {
    const bag_test::SmallDisk disk(200'000);
    for (int i = 0; i < 10; ++i) {
      words.publish(text_message(std::string(50'000, 'x')));
    }
    EXPECT_TRUE(harness.deactivate(recorder).success);
  }
  ASSERT_TRUE(harness.spin_until([&] { return !reports(statuses).empty(); }));
  EXPECT_EQ(reports(statuses)[0].state, MissionStatus::FAILED);
  EXPECT_THAT(reports(statuses)[0].message, HasSubstr("the recording has ended: "));
  const std::size_t in_bag = read_bag(bag_).messages.size();
  const auto logs = harness.logs();
  EXPECT_TRUE(std::ranges::any_of(logs, [&](const testing::LogEntry& entry) {
    return entry.text.starts_with(std::to_string(in_bag) +
                                  " messages of 1 topics recorded, 0 "
                                  "dropped, " +
                                  std::to_string(10 - in_bag) + " lost by the error");
  }));
}

TEST_F(BagRecorderTest, WithoutAMessageItFailsAndSaysWhatWasAskedAndSeen) {
  ComponentHarness harness;
  auto quiet = harness.peer().create_publisher<String>("quiet", QoS::reliable());
  auto other = harness.peer().create_publisher<String>("other", QoS::reliable());
  auto& recorder = make(harness, {{"topics", std::vector<std::string>{"quiet", "/absent"}}});
  const auto statuses = harness.collect(topics::kMissionStatus);
  ASSERT_TRUE(harness.bring_up(recorder).success);
  other.publish(text_message("not asked for"));
  harness.spin();
  EXPECT_THAT(end(harness, recorder).messages, IsEmpty());
  ASSERT_TRUE(harness.spin_until([&] { return !reports(statuses).empty(); }));
  EXPECT_EQ(reports(statuses)[0].state, MissionStatus::FAILED);
  EXPECT_THAT(reports(statuses)[0].message,
              ::testing::AllOf(HasSubstr("asked for topic /absent, /quiet; no message came on "
                                         "/quiet; published were "),
                               HasSubstr("/other")));
}

TEST_F(BagRecorderTest, WhatAsksForAllAndSeesNothingSaysSo) {
  ComponentHarness harness;
  auto& recorder = make(harness, {{"regex", "^/imu"}, {"exclude", "raw"}});
  const auto statuses = harness.collect(topics::kMissionStatus);
  ASSERT_TRUE(harness.bring_up(recorder).success);
  EXPECT_THAT(end(harness, recorder).messages, IsEmpty());
  ASSERT_TRUE(harness.spin_until([&] { return !reports(statuses).empty(); }));
  EXPECT_THAT(reports(statuses)[0].message,
              HasSubstr("asked for topics that match '^/imu', without those that match 'raw'; no "
                        "topic was published by any other node"));
}

TEST_F(BagRecorderTest, ItFailsWhenItsSourceFallsSilent) {
  ComponentHarness harness;
  auto& recorder =
      make(harness, {{"all", true}, {"source", std::string("source")}, {"silent_after", 0.02}});
  const auto statuses = harness.collect(topics::kMissionStatus);
  ASSERT_TRUE(harness.bring_up(recorder).success);
  harness.publish(topics::kMissionStatus, source_status(MissionStatus::RUNNING));
  ASSERT_TRUE(harness.spin_until([&] { return !reports(statuses).empty(); }));
  EXPECT_EQ(reports(statuses)[0].state, MissionStatus::FAILED);
  EXPECT_THAT(reports(statuses)[0].message,
              HasSubstr("no message has arrived for 0.02 s, and '/source' has not reported"));
}

TEST_F(BagRecorderTest, ThinnedTopicsAreRecordedOncePerPeriodOfTheirStamps) {
  ComponentHarness harness;
  auto& recorder = make(harness, {{"all", true},
                                  {"thinned_topics", std::vector<std::string>{"imu"}},
                                  {"thinned_periods", std::vector<double>{1.0}}});
  ASSERT_TRUE(harness.bring_up(recorder).success);
  auto readings = harness.peer().create_publisher<sensor_msgs::msg::Imu>("imu", QoS::reliable());
  harness.spin();
  sensor_msgs::msg::Imu reading;
  for (int i = 0; i < 30; ++i) {
    reading.header.stamp.sec = 100 + i / 10;
    reading.header.stamp.nanosec = static_cast<std::uint32_t>(i % 10) * 100'000'000U;
    readings.publish(reading);
  }
  EXPECT_THAT(end(harness, recorder).of("/imu"), SizeIs(3));
}

TEST_F(BagRecorderTest, ARestartedRecorderGoesOnInAnotherBag) {
  for (const char* name : {"bag", "bag_2", "bag_3"}) {
    ComponentHarness harness;
    auto& recorder = make(harness, {{"all", true}, {"next_free_name", true}});
    ASSERT_TRUE(harness.bring_up(recorder).success);
    EXPECT_TRUE(harness.deactivate(recorder).success);
    EXPECT_TRUE(std::filesystem::exists(temporary_.path() / name)) << name;
  }
}

TEST_F(BagRecorderTest, TheLastDiagnosticsOfNodesAndOfItselfAreInTheBag) {
  ComponentHarness harness;
  // The recorder's own topics alone are not recorded.
  const auto other = harness.peer().create_publisher(topics::kDiagnostics);
  auto& recorder = make(harness, {{"all", true}});
  ASSERT_TRUE(harness.bring_up(recorder).success);
  harness.spin();
  recorder.diagnostics().count("dropped./words", 12);
  // No second has passed since.
  std::string last;
  for (const auto& message : end(harness, recorder).of("/diagnostics")) {
    const auto decoded =
        deserialize(message_type<diagnostic_msgs::msg::DiagnosticArray>(), message.bytes);
    ASSERT_TRUE(decoded);
    const auto& array = *static_cast<const diagnostic_msgs::msg::DiagnosticArray*>(decoded.get());
    for (const auto& value : array.status.at(0).values) {
      last = value.key == "dropped./words" ? value.value : last;
    }
  }
  EXPECT_EQ(last, "12");
}

TEST_F(BagRecorderTest, WhatCannotBeIsRefusedByName) {
  EXPECT_THAT(refusal({{"all", true}, {"thinned_topics", std::vector<std::string>{"words"}}}),
              HasSubstr("thinned_topics has 1 names and thinned_periods 0 numbers"));

  EXPECT_THAT(refusal({}), HasSubstr("set all, topics or regex"));
  EXPECT_THAT(refusal({{"all", true}, {"compression_mode", "some"}}),
              HasSubstr("compression_mode = 'some' is none of none, message, file"));
  EXPECT_THAT(refusal({{"regex", "("}}), HasSubstr("regex = '(' is no regular expression"));
  EXPECT_THAT(refusal({{"all", true}, {"qos_overrides", "/nowhere.yaml"}}),
              HasSubstr("/nowhere.yaml: cannot be read"));
  std::filesystem::create_directory(bag_);
  EXPECT_THAT(refusal({{"all", true}}), HasSubstr(bag_.string()));
}

}  // namespace
}  // namespace pipescout
