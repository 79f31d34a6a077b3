// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking_recorder/tracking_recorder.hpp"

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

using pipescout_msgs::msg::ArmState;
using pipescout_msgs::msg::MissionStatus;
using pipescout_msgs::msg::PipeTrack;
using pipescout_msgs::msg::PipeTrackParticles;
using sensor_msgs::msg::Image;
using sensor_msgs::msg::JointState;
using testing::ComponentHarness;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

const auto kStamp = to_message(Time{} + from_seconds(1.0));

class TrackingRecorderTest : public ::testing::Test {
 protected:
  TrackingRecorder& start() {
    auto& recorder =
        harness_.make<TrackingRecorder>({.name = "recorder",
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
  static PipeTrack track() {
    PipeTrack message;
    message.header.stamp = kStamp;
    message.state = PipeTrack::STATE_LOCKED;
    message.track = 1;
    message.width = 8;
    message.height = 6;
    message.estimate.length = 8;
    message.whole_width = true;
    message.range = std::numeric_limits<double>::quiet_NaN();
    return message;
  }
  static Image image() {
    Image message;
    message.header.stamp = kStamp;
    message.width = 8;
    message.height = 6;
    message.encoding = "mono8";
    message.step = 8;
    message.data.assign(48, 7);
    return message;
  }
  static PipeTrackParticles particles() {
    PipeTrackParticles message;
    message.header.stamp = kStamp;
    message.u = {1, 2};
    message.v = {1, 2};
    message.length = {8, 8};
    message.angle = {0, 0.1F};
    message.weight = {0.5F, 0.5F};
    return message;
  }
  static JointState joints() {
    JointState message;
    message.header.stamp = kStamp;
    message.name = {"shoulder_joint", "elbow_joint"};
    message.position = {0.1, 0.2};
    return message;
  }
  void send_all() {
    send(topics::kTruePipeTrack, track());
    send(topics::kThermalImage, image());
    send(topics::kPipeTrack, track());
    send(topics::kPipeTrackParticles, particles());
    ArmState arm;
    arm.header.stamp = kStamp;
    arm.reason = "no pipe, yet";
    arm.limited = {"a", "b"};
    send(topics::kArmState, arm);
    send(topics::kJointStates, joints());
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
    const std::string text = content(fs::path("tracking") / name);
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

TEST_F(TrackingRecorderTest, WritesEverythingAndEndsWithItsSource) {
  start();
  send_all();
  EXPECT_EQ(lines("truth.csv"), 2U);
  EXPECT_EQ(lines("track.csv"), 2U);
  EXPECT_EQ(lines("particles.csv"), 3U);
  EXPECT_EQ(lines("arm.csv"), 2U);
  EXPECT_EQ(lines("joints.csv"), 3U);
  EXPECT_EQ(lines("pictures.csv"), 2U);
  EXPECT_THAT(content("tracking/pictures/000000.png"), HasSubstr("PNG"));
  say(MissionStatus::COMPLETE);
  ASSERT_TRUE(harness_.spin_until([this] { return complete(); }));
  const std::string section = content("sections/recorder.json");
  EXPECT_THAT(section, HasSubstr("track_in_view_percent"));
  EXPECT_THAT(section, HasSubstr("weighted_mean"));
}

TEST_F(TrackingRecorderTest, EachLineHasAsManyCellsAsTheHeader) {
  start();
  send_all();
  PipeTrack none = track();
  none.state = PipeTrack::STATE_DETECTING;
  send(topics::kPipeTrack, none);
  none.state = PipeTrack::STATE_LOST;
  send(topics::kTruePipeTrack, none);
  for (const char* name :
       {"truth.csv", "track.csv", "particles.csv", "joints.csv", "pictures.csv"}) {
    std::ifstream stream(folder_.path() / "tracking" / name);
    std::string header;
    std::getline(stream, header);
    for (std::string line; std::getline(stream, line);) {
      EXPECT_EQ(std::ranges::count(line, ','), std::ranges::count(header, ',')) << name << line;
    }
  }
  EXPECT_THAT(content("tracking/arm.csv"), HasSubstr("\"no pipe, yet\""));
  EXPECT_THAT(content("tracking/arm.csv"), HasSubstr("a; b"));
}

TEST_F(TrackingRecorderTest, PicturesAreKeptOnceInAnInterval) {
  start();
  for (int i = 0; i < 50; ++i) {
    Image message = image();
    message.header.stamp = to_message(Time{} + from_seconds(1 + 0.04 * i));
    send(topics::kThermalImage, message);
  }
  EXPECT_EQ(lines("pictures.csv"), 4U) << "at 0, 0.8 and 1.6 s";
}

TEST_F(TrackingRecorderTest, NonsenseIsCountedAndNotRecorded) {
  auto& recorder = start();
  PipeTrack bad = track();
  bad.state = 9;
  send(topics::kPipeTrack, bad);
  JointState unequal = joints();
  unequal.position.pop_back();
  send(topics::kJointStates, unequal);
  PipeTrackParticles ragged = particles();
  ragged.weight.pop_back();
  send(topics::kPipeTrackParticles, ragged);
  Image broken = image();
  broken.data.resize(3);
  send(topics::kThermalImage, broken);
  EXPECT_EQ(lines("track.csv"), 0U);
  EXPECT_EQ(lines("joints.csv"), 0U);
  const auto told = harness_.next_diagnostics(recorder);
  EXPECT_EQ(harness_.value(told, "track.malformed"), "1");
  EXPECT_EQ(harness_.value(told, "joint_states.malformed"), "1");
  EXPECT_EQ(harness_.value(told, "particles.malformed"), "1");
  EXPECT_EQ(harness_.value(told, "image.malformed"), "1");
}

}  // namespace
}  // namespace pipescout
