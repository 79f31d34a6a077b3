// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_simulation/rack_simulation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using pipescout_msgs::msg::MissionStatus;
using testing::ComponentHarness;
using ::testing::HasSubstr;

using Image = sensor_msgs::msg::Image;
using Twist = geometry_msgs::msg::TwistStamped;

/// A second of small images, as fast as can be.
/// The node that listens for the test.
const std::vector<std::string> kPeer{"_component_harness"};

std::vector<NamedParameter> short_flight(std::vector<NamedParameter> extra = {}) {
  extra.push_back({"rack", std::string(RACK_FILE)});
  extra.push_back({"camera.width", std::int64_t{90}});
  extra.push_back({"camera.height", std::int64_t{60}});
  extra.push_back({"camera.focal_length", 79.0});
  extra.push_back({"rate", 1000.0});
  extra.push_back({"wait_for_subscribers.image", kPeer});
  extra.push_back({"duration", 1.0});
  return extra;
}

Twist command_at(const builtin_interfaces::msg::Time& stamp, double forward) {
  Twist message;
  message.header.stamp = stamp;
  message.header.frame_id = "base_stabilized";
  message.twist.linear.x = forward;
  return message;
}

/// Answers every image with a command, forward.
class Answerer {
 public:
  Answerer(ComponentHarness& harness, double speed)
      : subscription_(harness.peer().create_subscription(
            topics::kCameraImage, [&harness, speed](const Image& image) {
              harness.publish(topics::kVelocityCommand, command_at(image.header.stamp, speed));
            })) {}

 private:
  Subscription<Image> subscription_;
};

TEST(RackSimulation, FliesInLockStepWithTheCommands) {
  std::vector<std::uint8_t> last_image;
  double x = 0;
  for (int run = 0; run < 2; ++run) {
    ComponentHarness harness;
    auto& simulation = harness.make<RackSimulation>({.parameters = short_flight()});
    const auto clock = harness.collect(topics::kClock);
    const auto info = harness.collect(topics::kCameraInfo);
    const auto truth = harness.collect(topics::kTrueRackPose);
    const auto progress = harness.collect(topics::kMissionStatus);
    ASSERT_TRUE(harness.bring_up(simulation).success);
    const auto images = harness.collect(topics::kCameraImage);
    const Answerer answerer(harness, 0.5);
    ASSERT_TRUE(harness.spin_until(
        [&] { return !progress.empty() && progress.back().state == MissionStatus::COMPLETE; }));

    ASSERT_EQ(images.size(), 25U);
    EXPECT_EQ(clock.size(), 25U);
    ASSERT_EQ(truth.size(), 25U);
    ASSERT_EQ(info.size(), 25U);
    EXPECT_EQ(from_message(info.back()).focal_length, 79.0);
    for (std::size_t i = 0; i < images.size(); ++i) {
      const Image& image = images.at(i);
      EXPECT_EQ(image.encoding, "mono8");
      EXPECT_EQ(image.data.size(), 90U * 60U);
      const Time stamp = from_message(image.header.stamp);
      EXPECT_EQ(stamp - from_message(images.at(0).header.stamp),
                static_cast<std::int64_t>(i) * Duration(std::chrono::milliseconds(40)));
      EXPECT_EQ(from_message(truth.at(i).header.stamp), stamp);
    }
    EXPECT_EQ(simulation.diagnostics().counter("command.missing"), 0U);
    EXPECT_GT(truth.back().pose.position.x - truth.at(0).pose.position.x, 0.25);
    if (run == 0) {
      last_image = images.back().data;
      x = truth.back().pose.position.x;
    } else {
      // Whenever the answers came, they took effect at the same time.
      EXPECT_EQ(images.back().data, last_image);
      EXPECT_EQ(truth.back().pose.position.x, x);
    }
  }
}

TEST(RackSimulation, FliesOnWhereNobodyCommands) {
  ComponentHarness harness;
  auto& simulation = harness.make<RackSimulation>({.parameters = short_flight()});
  const auto progress = harness.collect(topics::kMissionStatus);
  const auto images = harness.collect(topics::kCameraImage);
  const auto info = harness.collect(topics::kCameraInfo);
  ASSERT_TRUE(harness.bring_up(simulation).success);
  ASSERT_TRUE(harness.spin_until(
      [&] { return !progress.empty() && progress.back().state == MissionStatus::COMPLETE; }));
  EXPECT_EQ(images.size(), 25U);
  EXPECT_EQ(simulation.diagnostics().counter("command.missing"), 24U);
}

TEST(RackSimulation, TakesNoCommandThatIsNotFinite) {
  ComponentHarness harness;
  std::vector<NamedParameter> parameters = short_flight();
  parameters.push_back({"rate", 1.0});  // else it has flown before the test commands
  auto& simulation = harness.make<RackSimulation>({.parameters = parameters});
  const auto progress = harness.collect(topics::kMissionStatus);
  const auto images = harness.collect(topics::kCameraImage);
  const auto info = harness.collect(topics::kCameraInfo);
  const auto truth = harness.collect(topics::kTrueRackPose);
  const Answerer answerer(harness, -0.5);
  ASSERT_TRUE(harness.bring_up(simulation).success);
  harness.publish(topics::kVelocityCommand,
                  command_at({}, std::numeric_limits<double>::quiet_NaN()));
  ASSERT_TRUE(harness.spin_until(
      [&] { return !progress.empty() && progress.back().state == MissionStatus::COMPLETE; }));
  EXPECT_EQ(images.size(), 25U);
  EXPECT_LT(truth.back().pose.position.x - truth.at(0).pose.position.x, -0.2);
  EXPECT_EQ(simulation.diagnostics().counter("command.not_a_number"), 1U);
}

TEST(RackSimulation, WaitsForThoseWhoLookAndPausesWhenDeactivated) {
  ComponentHarness harness;
  auto& simulation = harness.make<RackSimulation>({.parameters = short_flight()});
  const auto clock = harness.collect(topics::kClock);
  const auto progress = harness.collect(topics::kMissionStatus);
  ASSERT_TRUE(harness.bring_up(simulation).success);
  harness.spin();
  EXPECT_TRUE(clock.empty());
  ASSERT_FALSE(progress.empty());
  EXPECT_THAT(progress.back().message, HasSubstr("waiting"));
  const auto images = harness.collect(topics::kCameraImage);
  const auto info = harness.collect(topics::kCameraInfo);
  ASSERT_TRUE(harness.spin_until([&] { return images.size() > 3; }));
  ASSERT_TRUE(harness.deactivate(simulation).success);
  const std::size_t sent = clock.size();
  harness.spin();
  EXPECT_EQ(clock.size(), sent);
  ASSERT_TRUE(harness.activate(simulation).success);
  ASSERT_TRUE(harness.spin_until([&] { return clock.size() > sent; }));
  EXPECT_EQ(from_message(clock.at(sent).clock) - from_message(clock.at(sent - 1).clock),
            std::chrono::milliseconds(40));
}

TEST(RackSimulation, ThermalCameraLooksAtEveryFifthImageAndTheTruthIsToldOnce) {
  ComponentHarness harness;
  auto& simulation = harness.make<RackSimulation>(
      {.parameters = short_flight({{"thermal.image_rate", 5.0},
                                   {"thermal.width", std::int64_t{32}},
                                   {"thermal.height", std::int64_t{24}},
                                   {"hot_spots", std::vector<double>{1, 4, 0, 0.3, 0.8, 25}},
                                   {"wait_for_subscribers.thermal_image", kPeer}})});
  const auto progress = harness.collect(topics::kMissionStatus);
  const auto images = harness.collect(topics::kCameraImage);
  const auto thermal = harness.collect(topics::kThermalImage);
  const auto info = harness.collect(topics::kThermalCameraInfo);
  const auto leaks = harness.collect(topics::kTrueLeaks);
  ASSERT_TRUE(harness.bring_up(simulation).success);
  ASSERT_TRUE(harness.spin_until(
      [&] { return !progress.empty() && progress.back().state == MissionStatus::COMPLETE; }));
  EXPECT_EQ(images.size(), 25U);
  ASSERT_EQ(thermal.size(), 5U);
  EXPECT_EQ(thermal.at(1).header.stamp, images.at(5).header.stamp);
  EXPECT_EQ(thermal.back().encoding, "mono16");
  EXPECT_EQ(thermal.back().data.size(), 2U * 32U * 24U);
  ASSERT_EQ(info.size(), 5U);
  EXPECT_EQ(from_message(info.back()).width, 32);
  ASSERT_EQ(leaks.size(), 1U);
  EXPECT_EQ(leaks.back().header.frame_id, "rack");
  EXPECT_NEAR(leaks.back().finding.position.y, 4, 1e-9);
  EXPECT_NEAR(leaks.back().finding.position.z, 0.3, 1e-9) << "on top of a pipe of 15 cm radius";
}

std::string refusal(std::vector<NamedParameter> parameters) {
  ComponentHarness harness;
  auto& simulation = harness.make<RackSimulation>({.parameters = std::move(parameters)});
  const auto result = harness.configure(simulation);
  EXPECT_FALSE(result.success);
  return result.message;
}

TEST(RackSimulation, NamesWhatIsWrong) {
  EXPECT_THAT(refusal({}), HasSubstr("'rack' is empty"));
  EXPECT_THAT(refusal({{"rack", "/no/such.yaml"}}), HasSubstr("/no/such.yaml"));
  EXPECT_THAT(refusal(short_flight({{"offsets", std::vector<double>{0.1}}})),
              HasSubstr("'offsets' has 1 values: must be 5"));
  EXPECT_THAT(refusal(short_flight({{"plain", std::vector<double>{1, 2, 3}}})),
              HasSubstr("'plain' has 3 values"));
  EXPECT_THAT(refusal(short_flight({{"camera.distortion", std::vector<double>{0.1}}})),
              HasSubstr("'camera.distortion' has 1 values: must be 5"));
  EXPECT_THAT(refusal(short_flight({{"start.position", std::vector<double>{1, 2}}})),
              HasSubstr("'start.position' has 2 values"));
  EXPECT_THAT(refusal(short_flight({{"thermal.image_rate", 5.0},
                                    {"hot_spots", std::vector<double>{1, 4, 0, 0.3, 0.8}}})),
              HasSubstr("'hot_spots' has 5 values: must be a multiple of 6"));
  EXPECT_THAT(refusal(short_flight({{"thermal.image_rate", 5.0},
                                    {"hot_spots", std::vector<double>{9, 4, 0, 0.3, 0.8, 25}}})),
              HasSubstr("hot_spots[0].pipe: 9"));
  EXPECT_THAT(refusal(short_flight({{"wind.speed", 40.0}})), HasSubstr("cannot hover"));
  EXPECT_THAT(refusal(short_flight({{"offsets", std::vector<double>{0, -0.3, 0, 0, 0}}})),
              HasSubstr("'P2': intersects"));
}

}  // namespace
}  // namespace pipescout
