// SPDX-License-Identifier: Apache-2.0
#include "pipescout/catalogue/odometer_text.hpp"

#include <gtest/gtest.h>

#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <set>
#include <string>

namespace pipescout {
namespace {

using pipescout_msgs::msg::FusedOdometer;

/// How many different words there are from 0 on before "unknown".
int words(const char* (*text)(std::uint8_t) noexcept) {
  std::set<std::string> seen;
  for (std::uint8_t value = 0; std::string(text(value)) != "unknown"; ++value) {
    seen.insert(text(value));
  }
  return static_cast<int>(seen.size());
}

TEST(OdometerText, HasAWordForEachConstant) {
  EXPECT_EQ(words(rejection_text), FusedOdometer::REJECTED_DRIFTED + 1);
  EXPECT_EQ(words(health_text), FusedOdometer::HEALTH_SILENT + 1);
  EXPECT_EQ(words(fusion_status_text), FusedOdometer::STATUS_NO_DATA + 1);
  EXPECT_STREQ(rejection_text(FusedOdometer::REJECTED_STUCK), "stuck");
  EXPECT_STREQ(health_text(FusedOdometer::HEALTH_BAD_VALUES), "bad values");
  EXPECT_STREQ(fusion_status_text(FusedOdometer::STATUS_NO_CONSENSUS), "no consensus");
  EXPECT_STREQ(rejection_text(200), "unknown");
}

}  // namespace
}  // namespace pipescout
