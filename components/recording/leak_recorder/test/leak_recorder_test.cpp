// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_recorder/leak_recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <string>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using pipescout_msgs::msg::LeakDetections;
using pipescout_msgs::msg::LeakEvent;
using pipescout_msgs::msg::MissionStatus;
using testing::ComponentHarness;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

class LeakRecorderTest : public ::testing::Test {
 protected:
  LeakRecorder& start() {
    auto& recorder =
        harness_.make<LeakRecorder>({.name = "recorder",
                                     .parameters = {{"mission_folder", folder_.path().string()},
                                                    {"source", "robot"},
                                                    {"settle_time", 0.02}}});
    EXPECT_TRUE(harness_.bring_up(recorder).success);
    return recorder;
  }
  template <class T>
  void send(const Topic<T>& topic, const T& message) {
    harness_.publish(topic, message);
    harness_.spin();
  }
  static LeakDetections detections() {
    LeakDetections message;
    message.header.stamp = to_message(Time{} + from_seconds(1.0));
    message.threshold = 100;
    message.pipes.resize(1);
    message.pipes[0].end_u = 300;
    message.pipes[0].reference_temperature = 150;
    message.leaks.resize(1);
    message.leaks[0].delta = 80;
    return message;
  }
  static LeakEvent event() {
    LeakEvent message;
    message.header.stamp = to_message(Time{} + from_seconds(1.0));
    message.kind = LeakEvent::RAISED;
    message.finding.id = 1;
    message.finding.state = "raised";
    message.finding.severity = "minor";
    message.finding.probability = 0.95;
    message.finding.position_known = true;
    message.finding.position.x = 12.5;
    message.finding.length = std::numeric_limits<double>::quiet_NaN();
    message.finding.delta = 80;
    return message;
  }
  void say(std::uint8_t state) {
    MissionStatus message;
    message.node = "/robot";
    message.state = state;
    send(topics::kMissionStatus, message);
  }
  [[nodiscard]] std::string content(const fs::path& name) const {
    std::ifstream stream(folder_.path() / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  [[nodiscard]] std::size_t lines(const char* name) const {
    const std::string text = content(fs::path("leaks") / name);
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  }
  [[nodiscard]] bool complete() const {
    return std::ranges::any_of(statuses_.messages(), [](const auto& message) {
      return message->node == "/recorder" && message->state == MissionStatus::COMPLETE;
    });
  }

  testing::TemporaryFolder folder_;
  ComponentHarness harness_;
  testing::Collector<MissionStatus> statuses_ = harness_.collect(topics::kMissionStatus);
};

TEST_F(LeakRecorderTest, WritesEverythingAndEndsWithItsSource) {
  start();
  send(topics::kTrueLeaks, event());
  send(topics::kLeakDetections, detections());
  send(topics::kLeakEvents, event());
  EXPECT_EQ(lines("truth.csv"), 2U);
  EXPECT_EQ(lines("detections.csv"), 2U);
  EXPECT_EQ(lines("events.csv"), 2U);
  say(MissionStatus::COMPLETE);
  ASSERT_TRUE(harness_.spin_until([this] { return complete(); }));
  const std::string section = content("sections/recorder.json");
  EXPECT_THAT(section, HasSubstr("leaks_found_percent"));
  EXPECT_THAT(section, HasSubstr("12.5"));
}

TEST_F(LeakRecorderTest, EachLineHasAsManyCellsAsTheHeader) {
  start();
  send(topics::kTrueLeaks, event());
  send(topics::kLeakDetections, detections());
  send(topics::kLeakEvents, event());
  LeakDetections empty;
  empty.fault = "saturated";
  send(topics::kLeakDetections, empty);
  LeakEvent nowhere = event();
  nowhere.finding.position_known = false;
  send(topics::kLeakEvents, nowhere);
  for (const char* name : {"truth.csv", "detections.csv", "events.csv"}) {
    std::ifstream stream(folder_.path() / "leaks" / name);
    std::string header;
    std::getline(stream, header);
    for (std::string line; std::getline(stream, line);) {
      EXPECT_EQ(std::ranges::count(line, ','), std::ranges::count(header, ',')) << name << line;
    }
  }
}

TEST_F(LeakRecorderTest, NonsenseIsCountedAndNotRecorded) {
  auto& recorder = start();
  LeakEvent bad = event();
  bad.kind = 9;
  send(topics::kLeakEvents, bad);
  bad = event();
  bad.finding.id = 0;
  send(topics::kLeakEvents, bad);
  bad = event();
  bad.finding.position.y = std::numeric_limits<double>::infinity();
  send(topics::kLeakEvents, bad);
  LeakDetections many;
  many.pipes.resize(1001);
  send(topics::kLeakDetections, many);
  EXPECT_EQ(lines("events.csv"), 0U);
  EXPECT_EQ(lines("detections.csv"), 0U);
  const auto told = harness_.next_diagnostics(recorder);
  EXPECT_EQ(harness_.value(told, "event.malformed"), "3");
  EXPECT_EQ(harness_.value(told, "detections.malformed"), "1");
}

}  // namespace
}  // namespace pipescout
