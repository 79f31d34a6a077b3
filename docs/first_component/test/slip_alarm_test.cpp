// SPDX-License-Identifier: Apache-2.0
#include "slip_alarm.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace {

using pipescout::testing::ComponentHarness;

pipescout_msgs::msg::FusedOdometer fused(const std::vector<bool>& in_fusion_set) {
  pipescout_msgs::msg::FusedOdometer message;
  message.name = {"front", "rear"};
  message.in_fusion_set = in_fusion_set;
  return message;
}

TEST(SlipAlarmTest, SpeaksOnceForAnOdometerThatKeepsBeingRejected) {
  ComponentHarness harness;
  auto& alarm =
      harness.make<tutorial::SlipAlarm>({.name = "alarm", .parameters = {{"tolerated", 1}}});
  ASSERT_TRUE(harness.bring_up(alarm).success);
  const auto alarms = harness.collect<std_msgs::msg::String>("slip_alarm");
  for (int i = 0; i < 3; ++i) {
    harness.publish(pipescout::topics::kOdometerFused, fused({true, false}));
  }
  harness.spin();
  ASSERT_EQ(alarms.size(), 1U);
  EXPECT_EQ(alarms.at(0).data, "rear");
}

TEST(SlipAlarmTest, CountsAMessageThatMakesNoSense) {
  ComponentHarness harness;
  auto& alarm = harness.make<tutorial::SlipAlarm>();
  ASSERT_TRUE(harness.bring_up(alarm).success);
  harness.publish(pipescout::topics::kOdometerFused, fused({true}));
  harness.spin();
  EXPECT_EQ(alarm.diagnostics().counter("fused.in_fusion_set.wrong_size"), 1U);
}

}  // namespace
