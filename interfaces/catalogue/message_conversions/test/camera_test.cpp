// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/camera.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace pipescout {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

geometry::CameraParameters some_camera() {
  return {.width = 640,
          .height = 400,
          .focal_length = 500,
          .aspect_ratio = 1.02,
          .skew = 0.5,
          .centre_u = 321,
          .centre_v = 198,
          .k1 = -0.2,
          .k2 = 0.03,
          .k3 = 0.001,
          .p1 = 1e-3,
          .p2 = -2e-3};
}

TEST(CameraInfo, RoundTrip) {
  const geometry::CameraParameters back = from_message(to_message(some_camera()));
  EXPECT_EQ(back.width, 640);
  EXPECT_EQ(back.height, 400);
  EXPECT_DOUBLE_EQ(back.focal_length, 500);
  EXPECT_DOUBLE_EQ(back.aspect_ratio, 1.02);
  EXPECT_DOUBLE_EQ(back.skew, 0.5);
  EXPECT_DOUBLE_EQ(back.centre_u, 321);
  EXPECT_DOUBLE_EQ(back.centre_v, 198);
  EXPECT_DOUBLE_EQ(back.k1, -0.2);
  EXPECT_DOUBLE_EQ(back.k2, 0.03);
  EXPECT_DOUBLE_EQ(back.k3, 0.001);
  EXPECT_DOUBLE_EQ(back.p1, 1e-3);
  EXPECT_DOUBLE_EQ(back.p2, -2e-3);
}

TEST(CameraInfo, AllowsForBinningAndRegion) {
  auto message = to_message(some_camera());
  message.binning_x = 2;
  message.binning_y = 2;
  message.roi.x_offset = 20;
  message.roi.y_offset = 10;
  message.roi.width = 600;
  message.roi.height = 380;
  const geometry::Camera raw(some_camera());
  const geometry::Camera binned(from_message(message));
  EXPECT_EQ(binned.parameters().width, 300);
  EXPECT_EQ(binned.parameters().height, 190);
  const Eigen::Vector3d point(0.2, -0.1, 1.5);
  const Eigen::Vector2d expected =
      (*raw.project(point) - Eigen::Vector2d(20.5, 10.5)) / 2;  // middle of two pixels
  EXPECT_TRUE(binned.project(point)->isApprox(expected, 1e-12));
}

TEST(CameraInfo, RefusesARegionThatMakesNoSense) {
  auto message = to_message(some_camera());
  message.roi.x_offset = 20;
  EXPECT_THAT([&] { (void)from_message(message); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("roi has no width")));
  message.roi.width = 640;
  message.roi.height = 400;
  EXPECT_THAT([&] { (void)from_message(message); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("roi reaches beyond")));
  message.roi = {};
  message.binning_y = 401;
  EXPECT_THAT([&] { (void)from_message(message); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("binning_y 401")));
}

TEST(CameraInfo, HasTheLensesOfRos) {
  geometry::CameraParameters wide = some_camera();
  wide.k4 = 0.02;
  wide.k5 = -0.001;
  wide.k6 = 0.0005;
  const auto rational = to_message(wide);
  EXPECT_EQ(rational.distortion_model, "rational_polynomial");
  ASSERT_EQ(rational.d.size(), 8U);
  EXPECT_DOUBLE_EQ(from_message(rational).k5, -0.001);
  const geometry::CameraParameters fisheye{
      .k1 = 0.1, .k2 = 0.02, .k3 = 0.003, .k4 = 0.0004, .lens = geometry::LensModel::kEquidistant};
  const auto equidistant = to_message(fisheye);
  EXPECT_EQ(equidistant.distortion_model, "equidistant");
  ASSERT_EQ(equidistant.d.size(), 4U);
  const geometry::CameraParameters back = from_message(equidistant);
  EXPECT_EQ(back.lens, geometry::LensModel::kEquidistant);
  EXPECT_DOUBLE_EQ(back.k4, 0.0004);
}

TEST(CameraInfo, NamesWhatItDoesNotKnow) {
  auto message = to_message(some_camera());
  message.distortion_model = "fov";
  EXPECT_THAT([&] { (void)from_message(message); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("'fov'")));
  message.distortion_model = "plumb_bob";
  message.d = {-0.2, 0.03, 0, 0, 0, 0.1, 0, 0};
  EXPECT_THAT([&] { (void)from_message(message); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("d[5]")));
}

TEST(CameraInfo, RefusesAnUncalibratedCamera) {
  sensor_msgs::msg::CameraInfo message;
  message.width = 640;
  message.height = 400;
  EXPECT_THAT([&] { (void)from_message(message); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("not calibrated")));
}

TEST(CameraInfo, RefusesNumbersThatAreNone) {
  auto message = to_message(some_camera());
  message.k[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT([&] { (void)from_message(message); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("centre_u")));
}

}  // namespace
}  // namespace pipescout
