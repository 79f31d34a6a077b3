// SPDX-License-Identifier: Apache-2.0
#include "pipescout/catalogue/odometer_text.hpp"

#include <gtest/gtest.h>

#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <set>
#include <string>

namespace pipescout {
namespace {

namespace constants = pipescout_msgs::msg::FusedOdometer_Constants;

/// How many different words there are from 0 on before "unknown".
int words(const char* (*text)(std::uint8_t) noexcept) {
  std::set<std::string> seen;
  for (std::uint8_t value = 0; std::string(text(value)) != "unknown"; ++value) {
    seen.insert(text(value));
  }
  return static_cast<int>(seen.size());
}

TEST(OdometerText, HasAWordForEachConstant) {
  EXPECT_EQ(words(rejection_text), constants::REJECTED_DRIFTED + 1);
  EXPECT_EQ(words(health_text), constants::HEALTH_SILENT + 1);
  EXPECT_EQ(words(fusion_status_text), constants::STATUS_NO_DATA + 1);
  EXPECT_STREQ(rejection_text(constants::REJECTED_STUCK), "stuck");
  EXPECT_STREQ(health_text(constants::HEALTH_BAD_VALUES), "bad values");
  EXPECT_STREQ(fusion_status_text(constants::STATUS_NO_CONSENSUS), "no consensus");
  EXPECT_STREQ(rejection_text(200), "unknown");
}

}  // namespace
}  // namespace pipescout
