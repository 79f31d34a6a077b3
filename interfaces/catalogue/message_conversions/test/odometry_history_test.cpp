// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/odometry_history.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/runtime/conversions.hpp"

namespace pipescout {
namespace {

using geometry::SE3;
using geometry::SO3;
using geometry::Vector6d;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

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

class TakeOdometry : public ::testing::Test {
 protected:
  static nav_msgs::msg::Odometry message(double seconds) {
    nav_msgs::msg::Odometry odometry;
    odometry.header.stamp = to_message(at(seconds));
    odometry.header.frame_id = "map";
    odometry.pose.pose = to_message(SE3());
    odometry.pose.covariance = to_message(geometry::Matrix6d(geometry::Matrix6d::Identity()));
    return odometry;
  }

  bool take(const nav_msgs::msg::Odometry& odometry, double now) {
    faults_.clear();
    return take_odometry(history_, odometry, terms_, at(now),
                         [this](std::string_view counter, std::string_view) {
                           faults_.emplace_back(counter);
                         })
        .has_value();
  }

  OdometryHistory history_{10, 0.2};
  OdometryTerms terms_{.stamps = {.maximum_age = 1, .maximum_lead = 0.1}, .frame = "map"};
  std::vector<std::string> faults_;
};

TEST_F(TakeOdometry, StoresWhatMeetsTheTermsAndNamesWhatDoesNot) {
  EXPECT_TRUE(take(message(0), 0));
  EXPECT_THAT(faults_, IsEmpty());
  EXPECT_TRUE(take(message(0.1), 2)) << "late, and still the best there is";
  EXPECT_THAT(faults_, ElementsAre("odometry.header.stamp.stale"));
  EXPECT_FALSE(take(message(3), 2));
  EXPECT_THAT(faults_, ElementsAre("odometry.header.stamp.in_future"));
  EXPECT_FALSE(take(message(0.1), 0.2));
  EXPECT_THAT(faults_, ElementsAre("odometry.header.stamp.not_increasing"));
  auto elsewhere = message(0.2);
  elsewhere.header.frame_id = "odom";
  EXPECT_FALSE(take(elsewhere, 0.2));
  EXPECT_THAT(faults_, ElementsAre("odometry.header.frame_id"));
  auto no_number = message(0.2);
  no_number.twist.twist.linear.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(take(no_number, 0.2));
  EXPECT_THAT(faults_, ElementsAre("odometry.refused"));
}

TEST_F(TakeOdometry, ReadsTheCovarianceOfThoseWhoNeedItOnly) {
  auto odometry = message(0);
  odometry.pose.covariance[0] = -1;
  EXPECT_TRUE(take(odometry, 0));
  terms_.needs_covariance = true;
  odometry.header.stamp = to_message(at(0.1));
  EXPECT_FALSE(take(odometry, 0.1));
  EXPECT_THAT(faults_, ElementsAre("odometry.refused"));
}

}  // namespace
}  // namespace pipescout
