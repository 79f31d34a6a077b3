// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/odometry_history.hpp"

#include <gtest/gtest.h>

namespace pipescout {
namespace {

using geometry::SE3;
using geometry::SO3;
using geometry::Vector6d;

constexpr Time kStart{std::chrono::seconds(1000)};

Time at(double seconds) {
  return kStart + from_seconds(seconds);
}

/// A robot that drives in a circle: 1 m/s, 0.5 rad/s.
Vector6d circling() {
  return (Vector6d() << 1, 0, 0, 0, 0, 0.5).finished();
}

OdometryHistory::Entry entry(double seconds) {
  return {at(seconds), SE3::exp(seconds * circling()), circling(),
          (1 + seconds) * geometry::Matrix6d::Identity()};
}

TEST(OdometryHistory, InterpolatesOnTheCircle) {
  OdometryHistory history(10, 0.2);
  ASSERT_TRUE(history.add(entry(0.0)));
  ASSERT_TRUE(history.add(entry(0.1)));
  const auto pose = history.at(at(0.03));
  ASSERT_TRUE(pose);
  EXPECT_TRUE(pose->matrix().isApprox(SE3::exp(0.03 * circling()).matrix(), 1e-9));
}

TEST(OdometryHistory, MovesOnByTheTwist) {
  OdometryHistory history(10, 0.2);
  ASSERT_TRUE(history.add(entry(0.1)));
  const auto pose = history.at(at(0.25));
  ASSERT_TRUE(pose);
  EXPECT_TRUE(pose->matrix().isApprox(SE3::exp(0.25 * circling()).matrix(), 1e-9));
  EXPECT_FALSE(history.at(at(0.35))) << "beyond the reach";
}

TEST(OdometryHistory, DoesNotGuessWhereNothingWasHeard) {
  OdometryHistory history(10, 0.2);
  EXPECT_FALSE(history.at(at(0)));
  ASSERT_TRUE(history.add(entry(1.0)));
  ASSERT_TRUE(history.add(entry(2.0)));
  EXPECT_FALSE(history.at(at(0.9))) << "before the first";
  EXPECT_FALSE(history.at(at(1.5))) << "in a gap";
}

TEST(OdometryHistory, TellsHowWellThePoseIsKnown) {
  OdometryHistory history(10, 0.2);
  ASSERT_TRUE(history.add(entry(0.0)));
  ASSERT_TRUE(history.add(entry(0.1)));
  EXPECT_FALSE(history.covariance_at(at(-0.1)));
  ASSERT_TRUE(history.covariance_at(at(0.03)));
  EXPECT_EQ((*history.covariance_at(at(0.03)))(0, 0), 1);
  EXPECT_EQ((*history.covariance_at(at(0.2)))(0, 0), 1.1);
  EXPECT_FALSE(history.covariance_at(at(0.35))) << "beyond the reach";
}

TEST(OdometryHistory, RefusesWhatIsNotLater) {
  OdometryHistory history(10, 0.2);
  ASSERT_TRUE(history.add(entry(1.0)));
  EXPECT_FALSE(history.add(entry(1.0)));
  EXPECT_FALSE(history.add(entry(0.5)));
  ASSERT_TRUE(history.at(at(1.0)));
}

TEST(OdometryHistory, BeginsAnewWhenTheClockIsSetBack) {
  OdometryHistory history(10, 0.2);
  ASSERT_TRUE(history.add(entry(100.0)));
  EXPECT_TRUE(history.add(entry(1.0)));
  EXPECT_FALSE(history.at(at(100.0)));
  EXPECT_TRUE(history.at(at(1.0)));
}

TEST(OdometryHistory, ForgetsTheOldest) {
  OdometryHistory history(2, 0.2);
  for (const double seconds : {0.0, 0.1, 0.2}) {
    ASSERT_TRUE(history.add(entry(seconds)));
  }
  EXPECT_FALSE(history.at(at(0.05)));
  EXPECT_TRUE(history.at(at(0.1)));
}

}  // namespace
}  // namespace pipescout
