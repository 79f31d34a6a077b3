// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/wheel_drive.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace pipescout::estimation {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using Names = std::vector<std::string>;
using Values = std::vector<double>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

WheelDriveParameters two_wheels() {
  return {.left = {"left"}, .right = {"right"}, .wheel_radius = 0.2, .track = 0.5};
}
WheelDriveParameters four_wheels() {
  return {.left = {"fl", "rl"}, .right = {"fr", "rr"}, .wheel_radius = 0.1, .track = 0.4};
}

TEST(WheelDrive, RatesAreSpeedAndYawRate) {
  WheelDrive drive(two_wheels());
  const auto motion = drive.add(3.0, Names{"right", "left"}, {}, Values{6.0, 4.0});
  ASSERT_TRUE(motion);
  EXPECT_DOUBLE_EQ(motion->time, 3.0);
  EXPECT_DOUBLE_EQ(motion->speed, 1.0);
  EXPECT_DOUBLE_EQ(motion->yaw_rate, 0.8);
}

TEST(WheelDrive, AnglesAreDifferentiated) {
  WheelDrive drive(two_wheels());
  const Names names{"left", "right"};
  EXPECT_FALSE(drive.add(1.0, names, Values{100.0, 50.0}, {}));
  const auto motion = drive.add(1.5, names, Values{102.0, 53.0}, Values{kNan, kNan});
  ASSERT_TRUE(motion);
  EXPECT_DOUBLE_EQ(motion->time, 1.25);
  EXPECT_DOUBLE_EQ(motion->speed, 1.0);
  EXPECT_DOUBLE_EQ(motion->yaw_rate, 0.8);
}

TEST(WheelDrive, JointsOfTheArmArePassedOver) {
  WheelDrive drive(two_wheels());
  EXPECT_FALSE(drive.add(1.0, Names{"shoulder"}, Values{kNan}, Values{kNan}));
  const auto motion =
      drive.add(1.0, Names{"shoulder", "left", "right"}, {}, Values{kNan, 5.0, 5.0});
  ASSERT_TRUE(motion);
  EXPECT_DOUBLE_EQ(motion->speed, 1.0);
}

TEST(WheelDrive, WheelsComeInSeveralMessages) {
  WheelDrive drive(four_wheels());
  EXPECT_FALSE(drive.add(1.00, Names{"fl", "fr"}, {}, Values{10.0, 10.0}));
  const auto motion = drive.add(1.02, Names{"rl", "rr"}, {}, Values{12.0, 12.0});
  ASSERT_TRUE(motion);
  EXPECT_DOUBLE_EQ(motion->time, 1.01);
  EXPECT_DOUBLE_EQ(motion->speed, 1.1);
  EXPECT_FALSE(drive.add(1.10, Names{"fl", "fr"}, {}, Values{10.0, 10.0}));
}

TEST(WheelDrive, WheelsOfARoundThatWasNotCompleteDoNotCount) {
  WheelDrive drive(four_wheels());
  EXPECT_FALSE(drive.add(1.0, Names{"fl", "fr"}, {}, Values{10.0, 10.0}));
  EXPECT_FALSE(drive.add(1.5, Names{"rl", "rr"}, {}, Values{20.0, 20.0}));
  const auto motion = drive.add(1.52, Names{"fl", "fr"}, {}, Values{20.0, 20.0});
  ASSERT_TRUE(motion);
  EXPECT_DOUBLE_EQ(motion->speed, 2.0);
}

TEST(WheelDrive, AWheelWithoutAFiniteValueIsNamedAndNothingChanges) {
  WheelDrive drive(two_wheels());
  const Names names{"left", "right"};
  EXPECT_FALSE(drive.add(1.0, names, Values{0.0, 0.0}, {}));
  EXPECT_THAT(
      [&] {
        (void)drive.add(1.2, names, Values{1.0, kNan}, {});
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("wheel 'right'")));
  const auto motion = drive.add(2.0, names, Values{5.0, 5.0}, {});
  ASSERT_TRUE(motion);
  EXPECT_DOUBLE_EQ(motion->speed, 1.0);
  EXPECT_THAT(
      [&] {
        (void)drive.add(2.0, names, Values{5.0, 5.0}, {});
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("not after the last one")));
  EXPECT_THAT([&] { (void)drive.add(3.0, names, {}, Values{5.0}); },
              ThrowsMessage<std::invalid_argument>("velocity has 1 values for 2 names"));
}

TEST(WheelDrive, RefusesParametersThatAreNone) {
  auto parameters = two_wheels();
  parameters.track = 0;
  EXPECT_THAT([&] { WheelDrive drive(parameters); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("WheelDriveParameters.track: 0")));
  parameters = two_wheels();
  parameters.right = {"left"};
  EXPECT_THAT([&] { WheelDrive drive(parameters); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("WheelDriveParameters.right")));
  parameters.right.clear();
  EXPECT_THROW(WheelDrive drive(parameters), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::estimation
