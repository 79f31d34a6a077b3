// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/rack_localization.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <vector>

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
