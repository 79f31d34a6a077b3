// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/rack_tracker.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "drawn_rack.hpp"
#include "heap_guard.hpp"

namespace pipescout::rack_vision {
namespace {

using test::draw;
using test::drawn_camera;
using test::drawn_pose;
using test::drawn_rack;
using test::DrawnImage;

geometry::Matrix6d start_covariance(double place, double turn) {
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
  covariance.diagonal().head<3>().setConstant(place * place);
  covariance.diagonal().tail<3>().setConstant(turn * turn);
  return covariance;
}

/// The camera flies along and across; image k is taken at 0.04 k s.
geometry::SE3 flight(int k) {
  return drawn_pose(0.78 + 0.010 * k, 4.0 + 0.016 * k, 2.8 - 0.004 * k, 0.10 + 0.003 * k);
}

class RackTrackerTest : public ::testing::Test {
 protected:
  RackTrackerResult step(int k) {
    image_ = draw(model_, camera_, flight(k));
    return tracker_.track(image_.view(), 0.04 * k);
  }
  void start() {
    ASSERT_TRUE(tracker_.set_pose(flight(0), start_covariance(0.01, 0.005)));
    ASSERT_EQ(step(0).status, TrackStatus::kTracking);
  }

  RackModel model_ = drawn_rack();
  geometry::Camera camera_ = drawn_camera();
  RackTracker tracker_{model_, camera_};
  DrawnImage image_;
};

TEST_F(RackTrackerTest, FollowsAFlightWithinItsCovariance) {
  start();
  for (int k = 1; k <= 12; ++k) {
    const RackTrackerResult result = step(k);
    ASSERT_EQ(result.status, TrackStatus::kTracking) << k << ": " << result.reason;
    const Eigen::Vector3d error = result.T_rack_camera.translation() - flight(k).translation();
    EXPECT_LT(error.norm(), 0.03) << k;
    const Eigen::Vector3d turn =
        (result.T_rack_camera.rotation() * flight(k).rotation().inverse()).log();
    EXPECT_LT(turn.norm(), 0.01) << k;
    EXPECT_GT(result.quality, 0.5);
    geometry::Vector6d both;
    both << error, turn;
    EXPECT_LT(both.dot(result.covariance.ldlt().solve(both)), 60) << k;
  }
  EXPECT_EQ(tracker_.counts().losses, 0U);
}

TEST_F(RackTrackerTest, GrowsAMapAndUsesIt) {
  start();
  RackTrackerResult result;
  for (int k = 1; k <= 8; ++k) {
    result = step(k);
  }
  EXPECT_GT(result.map_points, 15);
  EXPECT_GT(result.points_matched, 8);
}

TEST_F(RackTrackerTest, TakesNoHeapFromTheThirdImageOn) {
  start();
  (void)step(1);
  for (int k = 2; k <= 30; ++k) {
    image_ = draw(model_, camera_, flight(k));
    TrackStatus status = TrackStatus::kLost;
    std::size_t allocations = 0;
    {
      const pipescout::test::HeapGuard guard;
      status = tracker_.track(image_.view(), 0.04 * k).status;
      allocations = guard.allocations();
    }
    ASSERT_EQ(status, TrackStatus::kTracking) << k;
    EXPECT_EQ(allocations, 0U) << k;
  }
}

TEST_F(RackTrackerTest, TheSameImagesGiveTheSameBits) {
  start();
  RackTracker other(model_, camera_);
  ASSERT_TRUE(other.set_pose(flight(0), start_covariance(0.01, 0.005)));
  (void)other.track(image_.view(), 0);
  for (int k = 1; k <= 3; ++k) {
    const RackTrackerResult a = step(k);
    const RackTrackerResult b = other.track(image_.view(), 0.04 * k);
    EXPECT_EQ(a.T_rack_camera.matrix(), b.T_rack_camera.matrix());
    EXPECT_EQ(a.covariance, b.covariance);
  }
}

TEST_F(RackTrackerTest, UsesAMotionThatIsMeasured) {
  start();
  // A leap that constant velocity does not foresee.
  const geometry::SE3 leap = drawn_pose(0.90, 4.1, 2.75, 0.16);
  image_ = draw(model_, camera_, leap);
  MotionPrediction motion;
  motion.T_previous_current = flight(0).inverse() * leap;
  motion.covariance = start_covariance(0.005, 0.003);
  const RackTrackerResult result = tracker_.track(image_.view(), 0.2, motion);
  ASSERT_EQ(result.status, TrackStatus::kTracking) << result.reason;
  EXPECT_LT((result.T_rack_camera.translation() - leap.translation()).norm(), 0.03);
}

TEST_F(RackTrackerTest, AMotionThatIsNoneIsCountedAndNotUsed) {
  start();
  MotionPrediction motion;
  motion.covariance = -geometry::Matrix6d::Identity();
  image_ = draw(model_, camera_, flight(1));
  EXPECT_EQ(tracker_.track(image_.view(), 0.04, motion).status, TrackStatus::kTracking);
  EXPECT_EQ(tracker_.counts().bad_predictions, 1U);
}

TEST_F(RackTrackerTest, SaysThatItHasNoPose) {
  image_ = draw(model_, camera_, flight(0));
  const RackTrackerResult result = tracker_.track(image_.view(), 0);
  EXPECT_EQ(result.status, TrackStatus::kNotStarted);
  EXPECT_FALSE(result.reason.empty());
  EXPECT_EQ(result.offsets.size(), model_.pipes.size());
}

TEST_F(RackTrackerTest, RefusesPosesThatAreNone) {
  EXPECT_FALSE(tracker_.set_pose(flight(0), geometry::Matrix6d::Zero()));
  geometry::Matrix6d covariance = start_covariance(0.01, 0.01);
  covariance(2, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(tracker_.set_pose(flight(0), covariance));
}

TEST_F(RackTrackerTest, RefusesImagesOfNoUse) {
  start();
  DrawnImage grey = image_;
  for (const std::uint8_t level : {std::uint8_t{0}, std::uint8_t{255}}) {
    std::ranges::fill(grey.pixels, level);
    const RackTrackerResult result = tracker_.track(grey.view(), 0.05 + 0.01 * (level & 1U));
    EXPECT_EQ(result.status, TrackStatus::kBadImage);
    EXPECT_FALSE(result.reason.empty());
  }
  EXPECT_EQ(tracker_.counts().without_contrast, 2U);

  ImageView half = image_.view();
  half.height /= 2;
  EXPECT_EQ(tracker_.track(half, 0.06).status, TrackStatus::kBadImage);
  EXPECT_EQ(tracker_.track(ImageView{}, 0.06).status, TrackStatus::kBadImage);
  EXPECT_EQ(tracker_.counts().wrong_size, 2U);

  EXPECT_EQ(step(2).status, TrackStatus::kTracking);  // none of them did harm
}

TEST_F(RackTrackerTest, PredictsThroughImagesThatAreRepeatedUntilTheCameraIsFrozen) {
  start();
  ASSERT_EQ(step(1).status, TrackStatus::kTracking);
  const DrawnImage frozen = image_;
  constexpr int kRepeated = 9;
  double variance = 0;
  for (int k = 2; k < 2 + kRepeated; ++k) {
    const RackTrackerResult result = tracker_.track(frozen.view(), 0.04 * k);
    ASSERT_EQ(result.status, TrackStatus::kCoasting) << k;
    EXPECT_FALSE(result.reason.empty());
    EXPECT_GT(result.covariance(0, 0), variance) << k;
    variance = result.covariance(0, 0);
  }
  EXPECT_EQ(tracker_.track(frozen.view(), 0.04 * (2 + kRepeated)).status, TrackStatus::kBadImage);
  EXPECT_EQ(tracker_.counts().repeated, 9U);
  EXPECT_EQ(tracker_.counts().frozen, 1U);
  EXPECT_EQ(tracker_.counts().losses, 0U);
}

TEST_F(RackTrackerTest, KeepsTrackWhereEachImageComesTwice) {
  start();
  for (int k = 1; k <= 6; ++k) {
    ASSERT_EQ(step(k).status, TrackStatus::kTracking) << k;
    EXPECT_EQ(tracker_.track(image_.view(), 0.04 * k + 0.02).status, TrackStatus::kCoasting);
  }
  EXPECT_EQ(tracker_.counts().losses, 0U);
}

TEST_F(RackTrackerTest, CountsAMeasuredMotionOnceWhereAnImageIsRepeated) {
  start();
  const DrawnImage repeated = image_;
  const geometry::SE3 leap = drawn_pose(0.90, 4.1, 2.75, 0.16);
  MotionPrediction motion;
  motion.covariance = start_covariance(0.005, 0.003);
  motion.T_previous_current = flight(0).inverse() * leap;
  const RackTrackerResult predicted = tracker_.track(repeated.view(), 0.1, motion);
  ASSERT_EQ(predicted.status, TrackStatus::kCoasting);
  EXPECT_LT((predicted.T_rack_camera.translation() - leap.translation()).norm(), 0.03);
  image_ = draw(model_, camera_, leap);
  const RackTrackerResult result = tracker_.track(image_.view(), 0.2, motion);
  ASSERT_EQ(result.status, TrackStatus::kTracking) << result.reason;
  EXPECT_LT((result.T_rack_camera.translation() - leap.translation()).norm(), 0.03);
  EXPECT_EQ(tracker_.counts().bad_predictions, 0U);
}

TEST_F(RackTrackerTest, StartsFromAnotherPoseInTheSameImage) {
  image_ = draw(model_, camera_, flight(0));
  ASSERT_TRUE(tracker_.set_pose(drawn_pose(1.6, 4.0, 2.0, 0.9), start_covariance(0.01, 0.005)));
  EXPECT_EQ(tracker_.track(image_.view(), 0).status, TrackStatus::kLost);
  ASSERT_TRUE(tracker_.set_pose(flight(0), start_covariance(0.01, 0.005)));
  EXPECT_EQ(tracker_.track(image_.view(), 0.04).status, TrackStatus::kTracking);
}

TEST_F(RackTrackerTest, RefusesStampsThatGoBackOrLeap) {
  start();
  ASSERT_EQ(step(1).status, TrackStatus::kTracking);
  const DrawnImage next = draw(model_, camera_, flight(2));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double stamp : {nan, 0.04, 0.02, -1.0, 1e9}) {
    EXPECT_EQ(tracker_.track(next.view(), stamp).status, TrackStatus::kBadStamp) << stamp;
  }
  EXPECT_EQ(tracker_.counts().bad_stamps, 5U);
  EXPECT_EQ(step(2).status, TrackStatus::kTracking);
}

TEST_F(RackTrackerTest, GoesOnWhenTheClockIsSetBack) {
  start();
  ASSERT_EQ(step(1).status, TrackStatus::kTracking);
  const double back = 1.04 - 60;  // s
  EXPECT_EQ(tracker_.track(draw(model_, camera_, flight(2)).view(), back).reason,
            "the stamp jumps back");
  for (int i = 3; i < 6; ++i) {
    EXPECT_EQ(tracker_.track(draw(model_, camera_, flight(i)).view(), back + 0.04 * (i - 2)).status,
              TrackStatus::kTracking)
        << i;
  }
  EXPECT_EQ(tracker_.counts().losses, 0U);
  EXPECT_EQ(tracker_.counts().bad_stamps, 1U);
}

TEST_F(RackTrackerTest, IsLostWhenTimeWentOnWithoutImages) {
  start();
  image_ = draw(model_, camera_, flight(1));
  EXPECT_EQ(tracker_.track(image_.view(), 5.0).status, TrackStatus::kBadStamp);
  EXPECT_EQ(tracker_.track(draw(model_, camera_, flight(2)).view(), 5.04).status,
            TrackStatus::kLost);
  EXPECT_EQ(tracker_.counts().losses, 1U);
}

TEST_F(RackTrackerTest, IsLostWithinTwoImagesOfAnotherSceneAndStartsAgain) {
  start();
  ASSERT_EQ(step(1).status, TrackStatus::kTracking);
  int k = 2;
  RackTrackerResult result;
  for (; k <= 5; ++k) {
    image_ = draw(model_, camera_, drawn_pose(1.5, 4.0, 1.9 + 0.01 * k, 1.2));
    result = tracker_.track(image_.view(), 0.04 * k);
    ASSERT_NE(result.status, TrackStatus::kTracking);
    if (result.status == TrackStatus::kLost) {
      break;
    }
  }
  EXPECT_EQ(result.status, TrackStatus::kLost);
  EXPECT_FALSE(result.reason.empty());
  EXPECT_EQ(tracker_.counts().losses, 1U);
  ASSERT_TRUE(tracker_.set_pose(flight(6), start_covariance(0.01, 0.005)));
  image_ = draw(model_, camera_, drawn_pose(1.5, 4.0, 1.96, 1.2));
  EXPECT_EQ(tracker_.track(image_.view(), 0.04 * 6).status, TrackStatus::kLost);
  EXPECT_EQ(tracker_.counts().refused_starts, 1U);
  EXPECT_EQ(tracker_.counts().losses, 1U) << "there was no track to lose";
  ASSERT_TRUE(tracker_.set_pose(flight(7), start_covariance(0.01, 0.005)));
  EXPECT_EQ(step(7).status, TrackStatus::kTracking);
}

TEST_F(RackTrackerTest, SaysNothingOfIntrinsicsUnlessAsked) {
  start();
  EXPECT_FALSE(step(1).intrinsics.has_value());
}

TEST_F(RackTrackerTest, IntrinsicsStayNearACalibrationThatIsRightAndAreForgotten) {
  RackTrackerParameters parameters;
  parameters.estimate_intrinsics = true;
  parameters.focal_sigma = 4;
  tracker_ = RackTracker(model_, camera_, parameters);
  start();
  RackTrackerResult result;
  for (int k = 1; k <= 12; ++k) {
    result = step(k);
    ASSERT_EQ(result.status, TrackStatus::kTracking) << k;
    ASSERT_TRUE(result.intrinsics.has_value());
  }
  const geometry::CameraParameters& camera = camera_.parameters();
  EXPECT_NEAR(result.intrinsics->mean(0), camera.focal_length, 4);
  EXPECT_NEAR(result.intrinsics->mean(1), camera.centre_u, 4);
  EXPECT_NEAR(result.intrinsics->mean(2), camera.centre_v, 4);
  EXPECT_LT(result.intrinsics->covariance.determinant(), std::pow(4.0 * 5.0 * 5.0, 2));
  EXPECT_EQ(result.covariance.llt().info(), Eigen::Success);
  tracker_.reset();
  image_ = draw(model_, camera_, flight(13));
  result = tracker_.track(image_.view(), 1);
  EXPECT_EQ(result.intrinsics->mean(0), camera.focal_length);
}

TEST(RackTrackerParameters, AreValidated) {
  RackTrackerParameters parameters;
  parameters.samples_per_edge = 1;
  EXPECT_THROW(parameters.validate(), std::invalid_argument);
  parameters = {};
  parameters.lost_below = 1.5;
  EXPECT_THROW(parameters.validate(), std::invalid_argument);
  parameters = {};
  parameters.row_time = 2e-3;
  EXPECT_THROW(parameters.validate(), std::invalid_argument);
  parameters = {};
  parameters.focal_sigma = 0;
  EXPECT_THROW(parameters.validate(), std::invalid_argument);
  parameters = {};
  parameters.edge_sigma = std::nan("");
  EXPECT_THROW(RackTracker(drawn_rack(), drawn_camera(), parameters), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::rack_vision
