// SPDX-License-Identifier: Apache-2.0
#include "pipescout/weld_locator/distance_history.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace pipescout {
namespace {

Time at(double seconds) {
  return Time{} + from_seconds(seconds);
}

TEST(DistanceHistory, IsLinearBetweenItsPoints) {
  DistanceHistory history(8);
  EXPECT_FALSE(history.at_time(at(1.0)));
  ASSERT_TRUE(history.add({at(1.0), 10.0, 20.0}));
  EXPECT_EQ(history.at_time(at(1.0))->distance, 10.0);
  ASSERT_TRUE(history.add({at(2.0), 11.0, 22.0}));
  EXPECT_DOUBLE_EQ(history.at_time(at(1.25))->distance, 10.25);
  EXPECT_DOUBLE_EQ(history.at_time(at(1.25))->uncalibrated, 20.5);
  EXPECT_FALSE(history.at_time(at(0.99)));
  EXPECT_FALSE(history.at_time(at(2.01)));
  EXPECT_EQ(history.at_distance(10.5)->time, at(1.5));
  EXPECT_FALSE(history.at_distance(9.9));
  EXPECT_FALSE(history.at_distance(11.1));
  EXPECT_FALSE(history.at_distance(std::numeric_limits<double>::quiet_NaN()));
}

TEST(DistanceHistory, FindsTheLastTimeOfAPlaceWhenItWasPassedTwice) {
  DistanceHistory history(8);
  history.add({at(0.0), 0.0, 0.0});
  history.add({at(2.0), 2.0, 2.0});
  history.add({at(3.0), 1.0, 1.0});
  history.add({at(5.0), 3.0, 3.0});
  EXPECT_EQ(history.at_distance(1.5)->time, at(3.5));
  EXPECT_EQ(history.at_distance(0.5)->time, at(0.5));
}

TEST(DistanceHistory, KnowsWhereItStood) {
  DistanceHistory history(8);
  history.add({at(0.0), 5.0, 5.0});
  history.add({at(10.0), 5.0, 5.0});
  EXPECT_EQ(history.at_distance(5.0)->time, at(10.0));
  EXPECT_EQ(history.at_time(at(4.0))->distance, 5.0);
}

TEST(DistanceHistory, ForgetsTheOldest) {
  DistanceHistory history(4);
  for (int k = 0; k < 10; ++k) {
    ASSERT_TRUE(history.add({at(k), 2.0 * k, 2.0 * k}));
  }
  EXPECT_EQ(history.oldest().time, at(6));
  EXPECT_EQ(history.latest().time, at(9));
  EXPECT_FALSE(history.at_time(at(5.5)));
  for (double time = 6.0; time <= 9.0; time += 0.25) {
    EXPECT_DOUBLE_EQ(history.at_time(at(time))->distance, 2.0 * time);
    EXPECT_EQ(history.at_distance(2.0 * time)->time, at(time));
  }
}

TEST(DistanceHistory, RefusesWhatIsNotLater) {
  DistanceHistory history(4);
  ASSERT_TRUE(history.add({at(1.0), 1.0, 1.0}));
  EXPECT_FALSE(history.add({at(1.0), 2.0, 2.0}));
  EXPECT_FALSE(history.add({at(0.5), 2.0, 2.0}));
  EXPECT_EQ(history.latest().distance, 1.0);
  history.clear();
  EXPECT_TRUE(history.empty());
  EXPECT_TRUE(history.add({at(0.5), 2.0, 2.0}));
  EXPECT_THROW(DistanceHistory(1), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout
