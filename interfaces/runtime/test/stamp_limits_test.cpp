// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/stamp_limits.hpp"

#include <gtest/gtest.h>

namespace pipescout {
namespace {

using std::chrono::milliseconds;

constexpr Time kNow{std::chrono::seconds(1000)};
constexpr StampLimits kLimits{.maximum_age = 2.0, .maximum_lead = 0.1};

TEST(StampLimits, BelievesWhatIsWithinThem) {
  EXPECT_FALSE(kLimits.find_fault("image", kNow, kNow));
  EXPECT_FALSE(kLimits.find_fault("image", kNow - milliseconds(2000), kNow));
  EXPECT_FALSE(kLimits.find_fault("image", kNow + milliseconds(100), kNow));
}

TEST(StampLimits, NamesTheInput) {
  const auto stale = kLimits.find_fault("image", kNow - milliseconds(2001), kNow);
  ASSERT_TRUE(stale);
  EXPECT_FALSE(stale->in_future);
  EXPECT_EQ(stale->counter, "image.header.stamp.stale");
  const auto future = kLimits.find_fault("image", kNow + milliseconds(101), kNow);
  ASSERT_TRUE(future);
  EXPECT_TRUE(future->in_future);
  EXPECT_EQ(future->counter, "image.header.stamp.in_future");
  EXPECT_EQ(future->text.substr(0, 7), "image: ");
}

TEST(StampLimits, NothingIsAFaultBeforeTheClockHasBegun) {
  EXPECT_FALSE(kLimits.find_fault("image", kNow, Time{}));
}

TEST(StampLimits, AnyAgeIsRightWithoutALimit) {
  EXPECT_FALSE((StampLimits{.maximum_lead = 0.1}).find_fault("image", Time{}, kNow));
}

}  // namespace
}  // namespace pipescout
