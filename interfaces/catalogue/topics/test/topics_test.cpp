// SPDX-License-Identifier: Apache-2.0
#include "pipescout/catalogue/topics.hpp"

#include <gtest/gtest.h>

namespace pipescout {
namespace {

// The catalogue is part of the program's image: nothing of it is computed when a program starts.
static_assert(topics::kArmCommand.name == "arm/command");
static_assert(topics::kRosout.qos.lifespan == std::chrono::seconds(10));

TEST(Catalogue, CommandsAreDroppedWhileTheirComponentIsInactive) {
  for (const auto kept :
       {topics::kArmCommand.while_inactive, topics::kVelocityCommand.while_inactive,
        topics::kInitialPose.while_inactive, topics::kRackPoseHint.while_inactive,
        topics::kGoalPose.while_inactive, topics::kGroundVelocityCommand.while_inactive}) {
    EXPECT_EQ(kept, WhileInactive::kDrop);
  }
  EXPECT_EQ(topics::kJointStates.while_inactive, WhileInactive::kKeep);
}

TEST(Catalogue, EveryDriverIsHeard) {
  for (const QoS& requested :
       {topics::kCameraImage.requested, topics::kCameraInfo.requested,
        topics::kThermalImage.requested, topics::kThermalCameraInfo.requested,
        topics::kJointStates.requested, topics::kScan.requested, topics::kImu.requested,
        topics::kGpsFix.requested, topics::kClock.requested}) {
    EXPECT_EQ(incompatibility(QoS::sensor_data(), requested), std::nullopt);
  }
  // What says nothing else asks for what is offered.
  EXPECT_EQ(topics::kLeakEvents.requested, topics::kLeakEvents.qos);
}

TEST(Catalogue, EventsAreKeptAndAcknowledgedForWhoeverAsks) {
  for (const QoS& offered : {topics::kWeld.qos, topics::kBend.qos, topics::kLeakEvents.qos}) {
    EXPECT_GE(offered.depth, 5000U);
    EXPECT_EQ(incompatibility(offered, QoS::latched(1)), std::nullopt);
    // The default of ROS 2's subscriptions.
    EXPECT_EQ(incompatibility(offered, QoS::reliable()), std::nullopt);
    EXPECT_EQ(incompatibility(offered, QoS::sensor_data()), std::nullopt);
  }
}

}  // namespace
}  // namespace pipescout
