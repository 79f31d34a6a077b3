// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/rack_localization.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <optional>
#include <vector>

#include "drawn_rack.hpp"

namespace pipescout::rack_vision {
namespace {

using geometry::Matrix6d;
using geometry::SE3;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

RackModel two_pipes() {
  const std::vector<RowPipe> row{{"a", {{0, 0.15}, {10, 0.15}}}, {"b", {{0, 0.2}, {10, 0.2}}, 0.1}};
  return {.pipes = row_of_pipes(row), .supports = {}};
}

SE3 above() {
  return {geometry::SO3::about_x(3.14159265358979), {0.5, 5, 2.5}};
}

TEST(RackLocalization, NamesTheParameterThatIsWrong) {
  RackLocalizationParameters parameters;
  parameters.drift_speed = 0;
  EXPECT_THAT([&] { RackLocalization(two_pipes(), geometry::Camera(), parameters); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("drift_speed")));
  parameters = {};
  parameters.retry_period = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT([&] { RackLocalization(two_pipes(), geometry::Camera(), parameters); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("retry_period")));
}

TEST(RackLocalization, SaysAtOnceThatARackGivesNoFirstPose) {
  RackModel crossing = two_pipes();
  crossing.pipes[1].start = {0, 5, 1};
  crossing.pipes[1].direction = Eigen::Vector3d::UnitX();
  crossing.pipes[1].movable = false;
  EXPECT_THAT([&] { RackLocalization(crossing, geometry::Camera()); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("fewer than two pipes")));
  RackLocalizationParameters parameters;
  parameters.find_first_pose = false;
  EXPECT_NO_THROW(RackLocalization(crossing, geometry::Camera(), parameters));
}

TEST(RackLocalization, LooksInTheImageAloneNowAndThen) {
  RackLocalizationParameters parameters;
  parameters.retry_period = 0.25;
  RackLocalization localization(two_pipes(), geometry::Camera(), parameters);
  const std::vector<std::uint8_t> pixels(720 * 480, 100);
  const ImageView grey{pixels.data(), 720, 480, 720};
  for (int i = 0; i <= 32; ++i) {
    EXPECT_NE(localization.track(grey, i / 32.0).status, TrackStatus::kTracking);
  }
  EXPECT_EQ(localization.counts().from_image, 5U) << "every 0.25 s in 1 s";
  EXPECT_EQ(localization.counts().image_unclear, 5U);
  EXPECT_EQ(localization.counts().given, 0U);
}

TEST(RackLocalization, DoesNotLookWhereItMayNot) {
  RackLocalizationParameters parameters;
  parameters.find_first_pose = false;
  RackLocalization localization(two_pipes(), geometry::Camera(), parameters);
  const std::vector<std::uint8_t> pixels(720 * 480, 100);
  (void)localization.track({pixels.data(), 720, 480, 720}, 0);
  EXPECT_EQ(localization.counts().from_image, 0U);
}

TEST(RackLocalization, RefusesPosesThatAreNone) {
  RackLocalization localization(two_pipes(), geometry::Camera());
  EXPECT_FALSE(localization.set_pose(above(), Matrix6d::Zero()));
  EXPECT_EQ(localization.counts().given, 0U);
  EXPECT_TRUE(localization.set_pose(above(), Matrix6d::Identity() * 1e-3));
  EXPECT_EQ(localization.counts().given, 1U);
  FirstPoseHint hint;
  hint.x = FirstPoseHint::Value{.value = 0, .standard_deviation = 0};
  EXPECT_THROW(localization.set_hint(hint), std::invalid_argument);
}

/// As a level has it, that knows neither place nor heading.
Matrix6d tilt_alone(double deviation) {
  Matrix6d covariance = Matrix6d::Identity() * 1e6;
  covariance(3, 3) = covariance(4, 4) = deviation * deviation;
  covariance(5, 5) = 10;
  return covariance;
}

class TiltedStart : public ::testing::Test {
 protected:
  TiltedStart() {
    RackLocalizationParameters parameters;
    parameters.find_first_pose = false;
    parameters.retry_period = 0;
    localization_.emplace(model_, camera_, parameters);
  }

  const RackModel model_ = test::drawn_rack();
  const geometry::Camera camera_ = test::drawn_camera();
  const SE3 level_ = test::drawn_pose(0.4, 5, 2.2, 0.1);
  const SE3 truth_{geometry::SO3::about_x(0.2) * geometry::SO3::about_y(-0.15) * level_.rotation(),
                   level_.translation()};
  const test::DrawnImage image_ = test::draw(model_, camera_, truth_);
  const test::DrawnImage next_image_ = test::draw(model_, camera_, truth_, 0.95);
  std::optional<RackLocalization> localization_;
};

TEST_F(TiltedStart, IsFoundOnceALevelHasSaidHowFar) {
  ASSERT_TRUE(localization_->set_pose(level_, Matrix6d::Identity() * 1e-3));
  ASSERT_NE(localization_->track(image_.view(), 0).status, TrackStatus::kTracking);
  // Somewhere else, and turned by any angle about the vertical, for all that a level knows.
  const SE3 said(geometry::SO3::about_z(2) * truth_.rotation(), {70, -30, 0});
  ASSERT_TRUE(localization_->suggest_pose(said, tilt_alone(0.01)));
  EXPECT_EQ(localization_->counts().suggested, 1U);
  EXPECT_EQ(localization_->counts().given, 1U);
  const RackTrackerResult result = localization_->track(next_image_.view(), 0.04);
  ASSERT_EQ(result.status, TrackStatus::kTracking);
  // Across the pipes and in height; texture that is seen for the first time tells nothing more.
  EXPECT_NEAR(result.T_rack_camera.translation().x(), truth_.translation().x(), 0.02);
  EXPECT_NEAR(result.T_rack_camera.translation().z(), truth_.translation().z(), 0.02);
  EXPECT_LT((result.T_rack_camera.rotation().inverse() * truth_.rotation()).log().norm(), 0.02);
}

TEST_F(TiltedStart, IsNotMadeWorseByALevelThatKnowsLess) {
  ASSERT_TRUE(localization_->set_pose(truth_, Matrix6d::Identity() * 1e-4));
  ASSERT_TRUE(localization_->suggest_pose(level_, tilt_alone(0.1)));
  EXPECT_EQ(localization_->counts().suggested, 0U);
  EXPECT_EQ(localization_->track(image_.view(), 0).status, TrackStatus::kTracking);
}

TEST_F(TiltedStart, IsTakenAsItIsFromASuggestionThatKnowsItAll) {
  ASSERT_TRUE(localization_->suggest_pose(truth_, Matrix6d::Identity() * 1e-4));
  EXPECT_EQ(localization_->counts().given, 1U);
  EXPECT_EQ(localization_->track(image_.view(), 0).status, TrackStatus::kTracking);
}

TEST_F(TiltedStart, IsNotThrownOffItsTrackByALevel) {
  ASSERT_TRUE(localization_->set_pose(truth_, Matrix6d::Identity() * 1e-4));
  ASSERT_EQ(localization_->track(image_.view(), 0).status, TrackStatus::kTracking);
  ASSERT_TRUE(localization_->suggest_pose(level_, tilt_alone(1e-3)));
  EXPECT_EQ(localization_->counts().suggested, 0U);
}

TEST_F(TiltedStart, IsNotTakenFromWhatIsNoPose) {
  EXPECT_FALSE(localization_->suggest_pose(truth_, Matrix6d::Zero()));
  Matrix6d broken = tilt_alone(0.01);
  broken(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(localization_->suggest_pose(truth_, broken));
  EXPECT_EQ(localization_->counts().suggested, 0U);
}

TEST_F(TiltedStart, HoversNoFasterThanItWasSaidTo) {
  RackLocalizationParameters parameters;
  parameters.find_first_pose = false;
  parameters.retry_period = 0;
  constexpr int kImages = 30;
  const auto tries = [&](double drift) {
    parameters.hover_drift_speed = drift;
    RackLocalization localization(model_, camera_, parameters);
    EXPECT_TRUE(localization.set_pose(truth_, Matrix6d::Identity() * 1e-4));
    std::vector<std::uint8_t> elsewhere(std::size_t{360} * 240);
    for (int i = 0; i < kImages; ++i) {
      for (std::size_t pixel = 0; pixel < elsewhere.size(); ++pixel) {
        elsewhere[pixel] =
            static_cast<std::uint8_t>((pixel / 360 + static_cast<std::size_t>(i)) % 64);
      }
      (void)localization.track({elsewhere.data(), 360, 240, 360}, 0.2 * i);
    }
    return localization.counts().from_last_pose;
  };
  EXPECT_LT(tries(0.3), 8U);
  EXPECT_EQ(tries(0.01), kImages - 1);
}

TEST(RackLocalization, SurvivesImagesAndStampsThatAreNone) {
  RackLocalization localization(two_pipes(), geometry::Camera());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  MotionPrediction broken;
  broken.covariance(0, 0) = nan;
  EXPECT_NE(localization.track({}, 0).status, TrackStatus::kTracking);
  EXPECT_NE(localization.track({}, nan).status, TrackStatus::kTracking);
  EXPECT_NE(localization.track({}, -1, broken).status, TrackStatus::kTracking);
  EXPECT_EQ(localization.counts().from_image, 0U);
}

}  // namespace
}  // namespace pipescout::rack_vision
