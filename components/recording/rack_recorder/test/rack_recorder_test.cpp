// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_recorder/rack_recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using geometry_msgs::msg::PoseStamped;
using geometry_msgs::msg::PoseWithCovarianceStamped;
using geometry_msgs::msg::TwistStamped;
using pipescout_msgs::msg::MissionStatus;
using pipescout_msgs::msg::RackState;
using sensor_msgs::msg::CameraInfo;
using sensor_msgs::msg::Image;
using testing::ComponentHarness;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

builtin_interfaces::msg::Time stamp(double seconds) {
  return to_message(Time{} + from_seconds(seconds));
}

class RackRecorderTest : public ::testing::Test {
 protected:
  RackRecorder& start(std::vector<NamedParameter> parameters = {}) {
    // Of two with the same name the later one counts.
    parameters.insert(
        parameters.begin(),
        {{"mission_folder", folder_.path().string()}, {"source", "servo"}, {"settle_time", 0.02}});
    auto& recorder = harness_.make<RackRecorder>({.name = "recorder", .parameters = parameters});
    EXPECT_TRUE(harness_.bring_up(recorder).success);
    return recorder;
  }
  template <class T>
  void send(const Topic<T>& topic, const T& message) {
    harness_.publish(topic, message);
    harness_.spin();
  }
  static PoseWithCovarianceStamped pose(double time = 1.0) {
    PoseWithCovarianceStamped message;
    message.header.stamp = stamp(time);
    message.pose.pose = to_message(geometry::SE3(geometry::SO3(), {1.0, 2.0, 3.0}));
    message.pose.covariance = to_message(geometry::Matrix6d(geometry::Matrix6d::Identity() * 1e-4));
    return message;
  }
  static PoseStamped truth(double time = 1.0) {
    PoseStamped message;
    message.header.stamp = stamp(time);
    message.pose = to_message(geometry::SE3(geometry::SO3(), {1.0, 2.0, 3.01}));
    return message;
  }
  static RackState state() {
    RackState message;
    message.status = 1;
    message.pipe = {"a", "b"};
    message.offset = {0.0, 0.1};
    message.offset_variance = {0.0, 1e-4};
    message.offset_observed = {false, true};
    return message;
  }
  static Image image(double time) {
    Image message;
    message.header.stamp = stamp(time);
    message.encoding = "mono8";
    message.width = 4;
    message.height = 2;
    message.step = 4;
    message.data = {1, 2, 3, 4, 5, 6, 7, 8};
    return message;
  }
  void say(std::uint8_t state, std::uint32_t done = 0, std::uint32_t total = 0) {
    MissionStatus message;
    message.node = "/servo";
    message.state = state;
    message.done = done;
    message.total = total;
    message.message = "why";
    harness_.publish(topics::kMissionStatus, message);
    harness_.spin();
  }
  [[nodiscard]] std::string content(const fs::path& name) const {
    std::ifstream stream(folder_.path() / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  [[nodiscard]] std::size_t lines(const char* name) const {
    const std::string text = content(fs::path("rack") / name);
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  }
  /// The recorder's last word.
  [[nodiscard]] const MissionStatus* own_status() const {
    for (std::size_t k = statuses_.size(); k-- > 0;) {
      if (statuses_.at(k).node == "/recorder") {
        return &statuses_.at(k);
      }
    }
    return nullptr;
  }
  [[nodiscard]] std::string section() const { return content("sections/recorder.json"); }

  testing::TemporaryFolder folder_;
  ComponentHarness harness_;
  testing::Collector<MissionStatus> statuses_ = harness_.collect(topics::kMissionStatus);
};

TEST_F(RackRecorderTest, WritesEverythingAndEndsWithItsSource) {
  const fs::path rack = folder_.path() / "some_rack.yaml";
  std::ofstream(rack) << "pipes: []  # kept as it is\n";
  auto& recorder = start({{"rack", rack.string()}});
  send(topics::kTrueRackPose, truth());
  send(topics::kRackPose, pose());
  send(topics::kRackState, state());
  send(topics::kVelocityCommand, TwistStamped{});
  send(topics::kCameraInfo, to_message(geometry::CameraParameters{}));
  send(topics::kCameraImage, image(1.0));
  say(MissionStatus::RUNNING, 1, 4);
  say(MissionStatus::RUNNING, 1, 4);
  say(MissionStatus::RUNNING, 2, 4);
  EXPECT_EQ(lines("pose.csv"), 2U);
  EXPECT_EQ(lines("truth.csv"), 2U);
  EXPECT_EQ(lines("state.csv"), 2U);
  EXPECT_EQ(lines("offsets.csv"), 3U);
  EXPECT_EQ(lines("command.csv"), 2U);
  EXPECT_EQ(lines("images.csv"), 2U);
  EXPECT_EQ(lines("way_points.csv"), 3U);
  EXPECT_EQ(content("rack/rack.yaml"), "pipes: []  # kept as it is\n");
  EXPECT_THAT(content("rack/camera.yaml"), HasSubstr("camera_matrix:"));
  EXPECT_EQ(content("rack/images/000000.pgm"), "P5\n4 2\n255\n\x01\x02\x03\x04\x05\x06\x07\x08");
  ASSERT_NE(own_status(), nullptr);
  EXPECT_EQ(own_status()->state, MissionStatus::RUNNING);
  EXPECT_EQ(own_status()->done, 2U);
  say(MissionStatus::COMPLETE, 4, 4);
  ASSERT_TRUE(harness_.spin_until([&] { return own_status()->state != MissionStatus::RUNNING; }));
  EXPECT_EQ(own_status()->state, MissionStatus::COMPLETE);
  EXPECT_THAT(own_status()->message, HasSubstr("1 poses and 1 images"));
  EXPECT_THAT(section(), HasSubstr("\"rack_position_median_m\""));
  EXPECT_THAT(section(), HasSubstr("\"rack_way_points_done\": 4"));
  EXPECT_TRUE(harness_.shutdown(recorder).success);
}

TEST_F(RackRecorderTest, FailsWithItsSourceOrWithoutAnyPose) {
  start();
  say(MissionStatus::FAILED);
  ASSERT_NE(own_status(), nullptr);
  EXPECT_EQ(own_status()->state, MissionStatus::FAILED);
  EXPECT_THAT(own_status()->message, HasSubstr("/servo failed: why"));
}

TEST_F(RackRecorderTest, AFlightWithoutPosesIsNotComplete) {
  start();
  say(MissionStatus::COMPLETE);
  ASSERT_TRUE(harness_.spin_until([&] { return own_status() != nullptr; }));
  EXPECT_EQ(own_status()->state, MissionStatus::FAILED);
}

TEST_F(RackRecorderTest, AStreamThatGoesOnDoesNotKeepItFromEnding) {
  start();
  say(MissionStatus::COMPLETE);
  double time = 1.0;
  ASSERT_TRUE(harness_.spin_until([&] {
    harness_.publish(topics::kRackPose, pose(time += 0.04));
    return own_status() != nullptr;
  }));
  EXPECT_EQ(own_status()->state, MissionStatus::COMPLETE);
}

TEST_F(RackRecorderTest, ASourceThatDiesFailsTheMissionAndTheRecordingIsWhole) {
  auto& recorder = start({{"silent_after", 0.02}});
  send(topics::kTrueRackPose, truth());
  send(topics::kRackPose, pose());
  say(MissionStatus::RUNNING, 1, 4);
  ASSERT_TRUE(harness_.spin_until(
      [&] { return own_status() != nullptr && own_status()->state == MissionStatus::FAILED; }));
  EXPECT_EQ(own_status()->message,
            "no message has arrived for 0.02 s, and 'servo' has not reported completion: 1 poses "
            "and 0 images recorded");
  EXPECT_THAT(section(), HasSubstr("Failed: no message has arrived"));
  EXPECT_THAT(section(), HasSubstr("\"rack_position_median_m\""));
  EXPECT_THAT(section(), HasSubstr("\"rack_way_points_done\": 1"));
  EXPECT_EQ(lines("pose.csv"), 2U);
  EXPECT_TRUE(harness_.shutdown(recorder).success);
  EXPECT_EQ(lines("pose.csv"), 2U);
}

TEST_F(RackRecorderTest, AFlightThatHasNotBegunIsWaitedFor) {
  auto& recorder = start({{"silent_after", 0.01}, {"settle_time", 0.05}});
  EXPECT_FALSE(
      harness_.spin_until([&] { return own_status() != nullptr; }, std::chrono::milliseconds(50)));
  // Nor does silence count while it settles, or does not listen.
  send(topics::kRackPose, pose());
  ASSERT_TRUE(harness_.deactivate(recorder).success);
  ASSERT_TRUE(harness_.activate(recorder).success);
  EXPECT_FALSE(
      harness_.spin_until([&] { return own_status() != nullptr; }, std::chrono::milliseconds(50)));
  say(MissionStatus::COMPLETE);
  ASSERT_TRUE(harness_.spin_until([&] { return own_status() != nullptr; }));
  EXPECT_EQ(own_status()->state, MissionStatus::COMPLETE);
}

TEST_F(RackRecorderTest, WhatIsStampedLaterThanTheEndOfTheSourceIsNotRecorded) {
  start({{"settle_time", 30.0}});
  send(topics::kRackPose, pose(1.0));
  MissionStatus complete;
  complete.header.stamp = stamp(2.0);
  complete.node = "/servo";
  complete.state = MissionStatus::COMPLETE;
  send(topics::kMissionStatus, complete);
  send(topics::kRackPose, pose(1.5));
  send(topics::kRackPose, pose(2.5));
  send(topics::kRackPose, pose(2.0));
  EXPECT_EQ(lines("pose.csv"), 4U);
}

TEST_F(RackRecorderTest, WithoutASourceSilenceIsCountedAndTheUserEndsIt) {
  auto& recorder = start({{"silent_after", 0.01}, {"source", ""}});
  send(topics::kRackPose, pose());
  ASSERT_TRUE(harness_.spin_until([&] { return recorder.diagnostics().counter("silent") == 1U; }));
  send(topics::kRackPose, pose(2.0));
  ASSERT_TRUE(harness_.spin_until([&] { return recorder.diagnostics().counter("silent") == 2U; }));
  EXPECT_EQ(own_status(), nullptr);
  EXPECT_EQ(lines("pose.csv"), 3U);
}

TEST_F(RackRecorderTest, KeepsAnImageOfEachPeriodAndNoMoreThanItMay) {
  start({{"image_period", 0.5}, {"maximum_images", 3}});
  for (int k = 0; k <= 25; ++k) {
    send(topics::kCameraImage, image(1.0 + 0.04 * k));
  }
  EXPECT_EQ(lines("images.csv"), 3U) << "at 1.00 and 1.52 s";
  EXPECT_THAT(content("rack/images.csv"), HasSubstr("1.520000000,images/000001.pgm"));
  send(topics::kCameraImage, image(0.5));  // the clock began again
  send(topics::kCameraImage, image(9.0));
  EXPECT_EQ(lines("images.csv"), 4U);
  const auto files = fs::directory_iterator(folder_.path() / "rack/images");
  EXPECT_EQ(std::distance(begin(files), end(files)), 3) << "and nothing half written";
}

TEST_F(RackRecorderTest, ImagesCanBeLeftOut) {
  start({{"image_period", 0.0}});
  send(topics::kCameraImage, image(1.0));
  EXPECT_FALSE(fs::exists(folder_.path() / "rack/images"));
}

TEST_F(RackRecorderTest, CountsWhatItCannotRecordAndLosesNothingElse) {
  auto& recorder = start({{"image_period", 0.01}});
  const auto expect_counted = [&](const char* counter, const auto& topic, auto message,
                                  const auto& spoil) {
    const auto before = recorder.diagnostics().counter(counter);
    spoil(message);
    send(topic, message);
    EXPECT_EQ(recorder.diagnostics().counter(counter), before + 1) << counter;
  };
  expect_counted("pose.malformed", topics::kRackPose, pose(),
                 [](auto& m) { m.pose.pose.position.x = kNan; });
  expect_counted("pose.malformed", topics::kRackPose, pose(),
                 [](auto& m) { m.pose.pose.orientation.w = 0.5; });
  expect_counted("pose.malformed", topics::kRackPose, pose(),
                 [](auto& m) { m.pose.covariance[7] = -1.0; });
  expect_counted("truth.malformed", topics::kTrueRackPose, truth(),
                 [](auto& m) { m.pose.position.z = kNan; });
  expect_counted("state.malformed", topics::kRackState, state(),
                 [](auto& m) { m.offset.pop_back(); });
  expect_counted("state.malformed", topics::kRackState, state(),
                 [](auto& m) { m.offset_observed.clear(); });
  expect_counted("state.malformed", topics::kRackState, state(), [](auto& m) {
    m.pipe.resize(100);
    m.offset.resize(100);
    m.offset_variance.resize(100);
    m.offset_observed.resize(100);
  });
  expect_counted("command.malformed", topics::kVelocityCommand, TwistStamped{},
                 [](auto& m) { m.twist.angular.y = kNan; });
  expect_counted("image.malformed", topics::kCameraImage, image(1.0),
                 [](auto& m) { m.data.pop_back(); });
  expect_counted("image.malformed", topics::kCameraImage, image(1.0),
                 [](auto& m) { m.encoding = "mono16"; });
  const CameraInfo calibration = to_message(geometry::CameraParameters{});
  expect_counted("camera_info.malformed", topics::kCameraInfo, calibration,
                 [](auto& m) { m.k[0] = kNan; });
  send(topics::kCameraInfo, calibration);
  send(topics::kCameraInfo, calibration);
  EXPECT_EQ(recorder.diagnostics().counter("camera_info.changed"), 0U);
  expect_counted("camera_info.changed", topics::kCameraInfo, calibration,
                 [](auto& m) { m.k[2] += 1.0; });
  send(topics::kRackPose, pose());
  send(topics::kRackState, state());
  send(topics::kCameraImage, image(1.0));
  EXPECT_EQ(lines("pose.csv"), 2U);
  EXPECT_EQ(lines("state.csv"), 2U);
  EXPECT_EQ(lines("images.csv"), 2U);
  EXPECT_FALSE(fs::exists(folder_.path() / "rack/truth.csv"));
  EXPECT_FALSE(fs::exists(folder_.path() / "rack/command.csv"));
  EXPECT_EQ(recorder.state(), LifecycleState::kActive);
}

TEST_F(RackRecorderTest, FailsWhenItCannotWrite) {
  auto& recorder = start();
  std::ofstream(folder_.path() / "rack" / "pose.csv") << "somebody else's\n";
  send(topics::kRackPose, pose());
  ASSERT_NE(own_status(), nullptr);
  EXPECT_EQ(own_status()->state, MissionStatus::FAILED);
  EXPECT_THAT(own_status()->message, HasSubstr("pose.csv"));
  send(topics::kRackState, state());
  EXPECT_EQ(recorder.diagnostics().counter("not_recorded"), 1U);
  EXPECT_EQ(recorder.state(), LifecycleState::kActive);
}

TEST_F(RackRecorderTest, EachFlightHasAFolderOfItsOwn) {
  auto& recorder = start();
  send(topics::kRackPose, pose());
  ASSERT_TRUE(harness_.deactivate(recorder).success);
  ASSERT_TRUE(harness_.cleanup(recorder).success);
  ASSERT_TRUE(harness_.bring_up(recorder).success);
  send(topics::kRackPose, pose());
  EXPECT_TRUE(fs::exists(folder_.path() / "rack" / "pose.csv"));
  EXPECT_TRUE(fs::exists(folder_.path() / "rack_2" / "pose.csv"));
}

TEST(RackRecorderStart, NeedsAFolderAndARackFileThatIsThere) {
  ComponentHarness harness;
  auto& recorder = harness.make<RackRecorder>();
  EXPECT_THAT(harness.configure(recorder).message, HasSubstr("mission_folder"));
  const testing::TemporaryFolder folder;
  auto& other = harness.make<RackRecorder>(
      {.name = "other",
       .parameters = {{"mission_folder", folder.path().string()}, {"rack", "/no/such.yaml"}}});
  EXPECT_THAT(harness.configure(other).message, HasSubstr("/no/such.yaml"));
  EXPECT_FALSE(fs::exists(folder.path() / "rack")) << "nothing is left behind";
}

}  // namespace
}  // namespace pipescout
