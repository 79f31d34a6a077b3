// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry_fusion/odometer_stream_fusion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using pipescout_msgs::msg::FusedOdometer;
using pipescout_msgs::msg::OdometerReadings;
using pipescout_msgs::msg::WeldDetection;
using testing::ComponentHarness;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr Time kStart{std::chrono::seconds(1000)};
constexpr double kSpeed = 0.5;  // m/s
const std::vector<std::string> kWheels{"left", "right", "top"};

class OdometerStreamFusionTest : public ::testing::Test {
 protected:
  OdometerStreamFusion& start(std::vector<NamedParameter> parameters = {}) {
    parameters.push_back({"odometers", kWheels});
    parameters.push_back({"sigmas_per_sqrt_metre", std::vector<double>{0.004, 0.004, 0.004}});
    harness_.set_time(kStart);
    auto& fusion =
        harness_.make<OdometerStreamFusion>({.name = "fusion", .parameters = parameters});
    EXPECT_TRUE(harness_.bring_up(fusion).success);
    return fusion;
  }

  static OdometerReadings readings(double time, const std::vector<double>& distance) {
    OdometerReadings message;
    message.header.stamp = to_message(kStart + from_seconds(time));
    message.header.frame_id = "base_link";
    message.name = kWheels;
    message.distance = distance;
    message.valid = {true, true, true};
    return message;
  }

  void send(const OdometerReadings& message) {
    harness_.publish(topics::kOdometerReadings, message);
    harness_.spin();
  }

  using Wheel = std::function<double(double distance)>;
  /// At constant speed, readings of all wheels 20 times a second.
  void drive(double from, double to, const std::vector<Wheel>& wheels) {
    for (int k = static_cast<int>(std::lround(from * 20.0)); k <= std::lround(to * 20.0); ++k) {
      const double time = k / 20.0;
      harness_.set_time(kStart + from_seconds(time));
      send(readings(
          time, {wheels[0](kSpeed * time), wheels[1](kSpeed * time), wheels[2](kSpeed * time)}));
    }
  }
  static Wheel scaled(double scale) {
    return [scale](double distance) { return scale * distance; };
  }

  ComponentHarness harness_{{.simulated_time = true}};
  testing::Collector<FusedOdometer> fused_ = harness_.collect(topics::kOdometerFused);
};

TEST_F(OdometerStreamFusionTest, FollowsTheWheels) {
  start();
  drive(0.0, 20.0, {scaled(1.0), scaled(1.0), scaled(1.0)});
  ASSERT_GT(fused_.size(), 150U);
  const FusedOdometer& fused = fused_.back();
  const double time = to_seconds(from_message(fused.header.stamp) - kStart);
  EXPECT_NEAR(fused.distance, kSpeed * time, 0.005);
  EXPECT_NEAR(fused.speed, kSpeed, 0.01);
  EXPECT_EQ(fused.header.frame_id, "base_link");
  EXPECT_EQ(fused.name, kWheels);
  EXPECT_EQ(fused.status, FusedOdometer::STATUS_OK);
  EXPECT_THAT(fused.in_fusion_set, ElementsAre(true, true, true));
  EXPECT_THAT(fused.rejection_reason, Each(FusedOdometer::REJECTED_NONE));
  EXPECT_THAT(fused.health, Each(FusedOdometer::HEALTH_OK));
  EXPECT_THAT(fused.scale, Each(1.0));
  EXPECT_EQ(fused.support.size(), 9U);
  EXPECT_EQ(fused.confidence_distance.size(), 9U);
  EXPECT_GT(fused.variance, 0.0);
  EXPECT_LE(fused.independent_variance, fused.variance);
  // One for each tick.
  for (std::size_t i = 1; i < fused_.size(); ++i) {
    EXPECT_LT(from_message(fused_.at(i - 1).header.stamp), from_message(fused_.at(i).header.stamp));
  }
}

TEST_F(OdometerStreamFusionTest, TakesTurnsOutOfWheelsBesideEachOther) {
  start({{"laterals", std::vector<double>{0.4, -0.4, 0.0}}});
  constexpr double kRate = 0.25;  // rad/s
  for (int k = 0; k <= 400; ++k) {
    const double time = k / 20.0;
    harness_.set_time(kStart + from_seconds(time));
    sensor_msgs::msg::Imu imu;
    imu.header.stamp = to_message(kStart + from_seconds(time));
    imu.angular_velocity.z = kRate;
    harness_.publish(topics::kImu, imu);
    const double middle = kSpeed * time;
    send(readings(time, {middle - 0.4 * kRate * time, middle + 0.4 * kRate * time, middle}));
  }
  const double time = to_seconds(from_message(fused_.back().header.stamp) - kStart);
  EXPECT_NEAR(fused_.back().distance, kSpeed * time, 0.01);
  EXPECT_THAT(fused_.back().in_fusion_set, ElementsAre(true, true, true));
}

TEST_F(OdometerStreamFusionTest, AYawRateThatIsNoNumberIsCounted) {
  auto& fusion = start({{"laterals", std::vector<double>{0.4, -0.4, 0.0}}});
  drive(0.0, 1.0, {scaled(1.0), scaled(1.0), scaled(1.0)});
  sensor_msgs::msg::Imu imu;
  imu.header.stamp = to_message(kStart + from_seconds(1.0));
  imu.angular_velocity.z = kNan;
  harness_.publish(topics::kImu, imu);
  harness_.spin();
  EXPECT_EQ(fusion.diagnostics().counter("imu.angular_velocity.not_a_number"), 1U);
  drive(1.05, 3.0, {scaled(1.0), scaled(1.0), scaled(1.0)});
  EXPECT_NEAR(fused_.back().distance, kSpeed * 3.0, 0.1);
}

TEST_F(OdometerStreamFusionTest, WheelsAroundTheCircumferenceTellABend) {
  const std::vector<double> clocks{0.0, 2.0944, 4.1888};
  auto& fusion = start({{"rule", std::string("circumference")},
                        {"clocks", clocks},
                        {"pipe_radius", 0.5},
                        {"window_distance", 0.5}});
  const auto wheel = [&](double clock) {
    // 90 degrees towards half past one, 3 diameters, from 5 m on.
    return [clock](double distance) {
      return distance -
             0.5 / 3.0 * std::clamp(distance - 5.0, 0.0, 4.712) * std::cos(clock - 0.785);
    };
  };
  drive(0.0, 40.0, {wheel(clocks[0]), wheel(clocks[1]), wheel(clocks[2])});
  const double time = to_seconds(from_message(fused_.back().header.stamp) - kStart);
  EXPECT_NEAR(fused_.back().distance, kSpeed * time, 0.02);
  EXPECT_THAT(fused_.back().health, Each(FusedOdometer::HEALTH_OK));
  EXPECT_EQ(fusion.diagnostics().take().values.at("bends"), "1");
}

TEST_F(OdometerStreamFusionTest, ClocksAreNeededAroundTheCircumference) {
  auto& fusion = harness_.make<OdometerStreamFusion>(
      {.name = "fusion",
       .parameters = {
           {"odometers", kWheels}, {"rule", std::string("circumference")}, {"pipe_radius", 0.5}}});
  const auto result = harness_.bring_up(fusion);
  EXPECT_FALSE(result.success);
}

TEST_F(OdometerStreamFusionTest, SaysWhoSlipsAndWhy) {
  start();
  const Wheel slips = [](double distance) {
    return distance - 0.3 * std::clamp(distance - 5.0, 0.0, 5.0);
  };
  drive(0.0, 30.0, {scaled(1.0), slips, scaled(1.0)});
  bool rejected = false;
  bool slipping = false;
  for (const auto& message : fused_.messages()) {
    rejected |= message->rejection_reason[1] == FusedOdometer::REJECTED_UNSUPPORTED;
    slipping |= message->health[1] == FusedOdometer::HEALTH_SLIPPING;
    EXPECT_EQ(message->health[0], FusedOdometer::HEALTH_OK);
  }
  EXPECT_TRUE(rejected);
  EXPECT_TRUE(slipping);
  EXPECT_EQ(fused_.back().health[1], FusedOdometer::HEALTH_OK);
  const double time = to_seconds(from_message(fused_.back().header.stamp) - kStart);
  EXPECT_NEAR(fused_.back().distance, kSpeed * time, 0.03);
  bool told = false;
  for (const auto& entry : harness_.logs()) {
    told |= entry.text == "odometer 'right': slipping";
  }
  EXPECT_TRUE(told);
}

TEST_F(OdometerStreamFusionTest, TakesWheelsWithRatesOfTheirOwnAndIncrements) {
  start({{"kinds", std::vector<std::string>{"absolute", "increment", "absolute"}}});
  for (int k = 1; k <= 400; ++k) {
    const double time = k / 20.0;
    harness_.set_time(kStart + from_seconds(time));
    OdometerReadings message;
    message.header.stamp = to_message(kStart + from_seconds(time));
    message.name = {"right"};
    message.distance = {kSpeed / 20.0};
    message.valid = {true};
    send(message);
    if (k % 2 == 0) {
      message.name = {"top", "left"};
      message.distance = {7.0 + kSpeed * time, kSpeed * time};
      message.valid = {true, true};
      send(message);
    }
  }
  ASSERT_FALSE(fused_.empty());
  EXPECT_THAT(fused_.back().in_fusion_set, ElementsAre(true, true, true));
  EXPECT_NEAR(fused_.back().speed, kSpeed, 0.01);
}

/// A spoilt message, the counter that must say so, and whether the message is refused as a whole.
struct Fault {
  const char* counter;
  bool refused;
  std::function<void(OdometerReadings&)> spoil;
};

TEST_F(OdometerStreamFusionTest, CountsWhatItCannotUseAndGoesOn) {
  auto& fusion = start();
  drive(0.0, 5.0, {scaled(1.0), scaled(1.0), scaled(1.0)});
  const std::vector<Fault> faults{
      {"readings.name.wrong_count", true, [](auto& message) { message = OdometerReadings(); }},
      {"readings.name.wrong_count", true,
       [](auto& message) {
         for (int i = 0; i < 17; ++i) {
           message.name.push_back(std::to_string(i));
         }
       }},
      {"readings.name.not_unique", true, [](auto& message) { message.name[1] = "left"; }},
      {"readings.name.unexpected", false, [](auto& message) { message.name[1] = "bottom"; }},
      {"readings.distance.wrong_size", true, [](auto& message) { message.distance.pop_back(); }},
      {"readings.valid.wrong_size", true, [](auto& message) { message.valid.push_back(true); }},
      {"readings.valid.false", false, [](auto& message) { message.valid[0] = false; }},
      {"readings.distance.not_a_number", false, [](auto& message) { message.distance[0] = kNan; }},
      {"readings.distance.not_a_number", false,
       [](auto& message) { message.distance[2] = -kInfinity; }},
      {"readings.distance.implausible", false, [](auto& message) { message.distance[2] = 1e6; }},
      {"readings.header.stamp.not_increasing", false,
       [](auto& message) { message.header.stamp = to_message(kStart + from_seconds(4.9)); }},
      {"readings.header.stamp.stale", false,
       [](auto& message) { message.header.stamp = to_message(kStart - from_seconds(10.0)); }},
      {"readings.header.stamp.in_future", false,
       [](auto& message) { message.header.stamp = to_message(kStart + from_seconds(5000.0)); }},
      {"readings.header.stamp.leap", false,
       [](auto& message) { message.header.stamp = to_message(kStart + from_seconds(5000.0)); }},
  };
  double time = 5.0;
  for (const Fault& fault : faults) {
    time += 0.05;
    harness_.set_time(kStart + from_seconds(time));
    const auto before = fusion.diagnostics().counter(fault.counter);
    const auto refused = fusion.diagnostics().counter("readings.refused");
    OdometerReadings message = readings(time, {kSpeed * time, kSpeed * time, kSpeed * time});
    fault.spoil(message);
    send(message);
    EXPECT_GT(fusion.diagnostics().counter(fault.counter), before) << fault.counter;
    EXPECT_EQ(fusion.diagnostics().counter("readings.refused"), refused + (fault.refused ? 1 : 0))
        << fault.counter;
  }
  EXPECT_EQ(fusion.state(), LifecycleState::kActive);
  fused_.clear();
  drive(time + 0.05, time + 10.0, {scaled(1.0), scaled(1.0), scaled(1.0)});
  ASSERT_FALSE(fused_.empty());
  EXPECT_EQ(fused_.back().status, FusedOdometer::STATUS_OK);
}

TEST_F(OdometerStreamFusionTest, FollowsAClockThatIsSet) {
  start({{"maximum_age", 0.0}, {"maximum_lead", 86400.0}});
  drive(0.0, 10.0, {scaled(1.0), scaled(1.0), scaled(1.0)});
  const double before = fused_.back().distance;
  for (int k = 0; k <= 200; ++k) {  // from here on an hour later
    const double distance = kSpeed * (10.05 + k / 20.0);
    send(readings(3610.0 + k / 20.0, {distance, distance, distance}));
  }
  EXPECT_EQ(fused_.back().status, FusedOdometer::STATUS_OK);
  EXPECT_GT(from_message(fused_.back().header.stamp), kStart + std::chrono::seconds(3600));
  EXPECT_NEAR(fused_.back().distance - before, kSpeed * 10.0, 0.3);
}

TEST_F(OdometerStreamFusionTest, NoticesADeadDriver) {
  auto& fusion = start();
  drive(0.0, 5.0, {scaled(1.0), scaled(1.0), scaled(1.0)});
  EXPECT_EQ(fusion.diagnostics().counter("readings.silent"), 0U);
  for (int i = 0; i < 4; ++i) {
    harness_.advance(std::chrono::seconds(1));
  }
  EXPECT_GE(fusion.diagnostics().counter("readings.silent"), 1U);
}

class CalibrationTest : public OdometerStreamFusionTest {
 protected:
  static WeldDetection weld(double since, double time) {
    WeldDetection message;
    message.header.stamp = to_message(kStart + from_seconds(time));
    message.weld = 3;
    message.weld_probability = 1.0;
    message.spacing_since = to_message(kStart + from_seconds(since));
    message.spacing = kSpeed * (time - since);
    message.spacing_standard_deviation = 0.01;
    message.spacing_joints = 1;
    return message;
  }
  void send_weld(const WeldDetection& message) {
    harness_.publish(topics::kWeld, message);
    harness_.spin();
  }
  /// Wheels that show 1 and 2 % too little, past a weld every 12 m.
  void drive_along_welds() {
    for (int joint = 0; joint < 10; ++joint) {
      drive(24.0 * joint + 0.05, 24.0 * (joint + 1), {scaled(0.99), scaled(0.98), scaled(0.99)});
      if (joint > 0) {
        send_weld(weld(24.0 * joint - 1.0, 24.0 * (joint + 1) - 1.0));
      }
    }
  }
};

TEST_F(CalibrationTest, LearnsScalesFromWelds) {
  start();
  drive_along_welds();
  ASSERT_EQ(fused_.back().scale.size(), 3U);
  EXPECT_NEAR(fused_.back().scale[0], 1.0 / 0.99, 1.5e-3);
  EXPECT_NEAR(fused_.back().scale[1], 1.0 / 0.98, 1.5e-3);
  EXPECT_LT(fused_.back().scale_standard_deviation[1], 2e-3);
  EXPECT_GT(fused_.back().scale_standard_deviation[1], 0.0);
}

TEST_F(CalibrationTest, LearnsNothingFromWeldsThatAreNotCertain) {
  auto& fusion = start();
  drive(0.0, 60.0, {scaled(0.98), scaled(0.98), scaled(0.98)});
  WeldDetection message = weld(10.0, 34.0);
  message.weld_probability = 0.9;
  send_weld(message);
  message = weld(10.0, 34.0);
  message.weld = -1;
  send_weld(message);
  message = weld(10.0, 34.0);
  message.spacing = kNan;
  send_weld(message);
  message = weld(10.0, 34.0);
  message.weld_probability = kNan;
  send_weld(message);
  drive(60.05, 62.0, {scaled(0.98), scaled(0.98), scaled(0.98)});
  EXPECT_THAT(fused_.back().scale, Each(1.0));
  EXPECT_EQ(fusion.diagnostics().counter("weld.spacing.bad_value"), 0U);
}

TEST_F(CalibrationTest, CountsSpacingsThatMakeNoSense) {
  auto& fusion = start();
  drive(0.0, 40.0, {scaled(1.0), scaled(1.0), scaled(1.0)});
  const std::vector<std::function<void(WeldDetection&)>> spoils{
      [](auto& message) { message.spacing = -12.0; },
      [](auto& message) { message.spacing = kInfinity; },
      [](auto& message) { message.spacing_standard_deviation = -0.01; },
      [](auto& message) { message.spacing_standard_deviation = kNan; },
      [](auto& message) { message.spacing_joints = 0; },
      [](auto& message) { message.spacing_since = message.header.stamp; },
  };
  std::uint64_t count = 0;
  for (const auto& spoil : spoils) {
    WeldDetection message = weld(10.0, 34.0);
    spoil(message);
    send_weld(message);
    EXPECT_EQ(fusion.diagnostics().counter("weld.spacing.bad_value"), ++count);
  }
  send_weld(weld(-500.0, 34.0));
  EXPECT_EQ(fusion.diagnostics().counter("weld.spacing.unknown_time"), 1U);
}

TEST_F(CalibrationTest, CanBeSwitchedOff) {
  start({{"calibrate", false}});
  drive_along_welds();
  EXPECT_THAT(fused_.back().scale, Each(1.0));
}

std::string refusal(const std::vector<NamedParameter>& parameters) {
  ComponentHarness harness;
  auto& fusion = harness.make<OdometerStreamFusion>({.parameters = parameters});
  const auto result = harness.configure(fusion);
  EXPECT_FALSE(result.success);
  return result.message;
}

TEST(OdometerStreamFusionStart, NamesWhatIsWrong) {
  EXPECT_THAT(refusal({}), HasSubstr("odometers"));
  EXPECT_THAT(refusal({{"odometers", std::vector<std::string>{"a", "a"}}}), HasSubstr("twice"));
  const NamedParameter odometers{"odometers", kWheels};
  EXPECT_THAT(refusal({odometers, {"kinds", std::vector<std::string>{"absolute"}}}),
              HasSubstr("'kinds' has 1 values for 3 odometers"));
  EXPECT_THAT(refusal({odometers, {"kinds", std::vector<std::string>(3, "relative")}}),
              HasSubstr("'absolute' or 'increment'"));
  EXPECT_THAT(refusal({odometers, {"resolutions", std::vector<double>{0.1}}}),
              HasSubstr("resolutions"));
  EXPECT_THAT(refusal({odometers, {"epsilon", 1.0}}), HasSubstr("epsilon"));
  EXPECT_THAT(refusal({odometers, {"tick_period", 100.0}}), HasSubstr("tick_period"));
}

TEST(OdometerStreamFusionStart, CanBeCleanedUpAndStartedAgain) {
  ComponentHarness harness;
  auto& fusion = harness.make<OdometerStreamFusion>({.parameters = {{"odometers", kWheels}}});
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(harness.bring_up(fusion).success);
    ASSERT_TRUE(harness.deactivate(fusion).success);
    ASSERT_TRUE(harness.cleanup(fusion).success);
  }
  EXPECT_TRUE(harness.shutdown(fusion).success);
}

}  // namespace
}  // namespace pipescout
