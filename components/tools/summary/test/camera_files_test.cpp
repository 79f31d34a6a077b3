// SPDX-License-Identifier: Apache-2.0
#include "tables/camera_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <string>

namespace pipescout::summary {
namespace {

using ::testing::HasSubstr;

TEST(CameraFiles, AnImageWithoutThePaddingOfItsRows) {
  const std::array<std::uint8_t, 8> pixels{1, 2, 3, 99, 4, 0, 255, 99};
  const auto file = pgm_file({.pixels = pixels.data(), .width = 3, .height = 2, .stride = 4});
  EXPECT_EQ(file, "P5\n3 2\n255\n" + std::string("\x01\x02\x03\x04\x00\xff", 6));
}

TEST(CameraFiles, ACalibrationAsRosWritesIt) {
  geometry::CameraParameters camera;
  camera.aspect_ratio = 0.5;
  camera.skew = 0.25;
  camera.k1 = -0.125;
  camera.p2 = 0.001;
  const std::string yaml = camera_yaml(camera);
  EXPECT_THAT(yaml, HasSubstr("image_width: 720\nimage_height: 480\n"));
  EXPECT_THAT(yaml, HasSubstr("camera_matrix:\n  rows: 3\n  cols: 3\n"
                              "  data: [630, 0.25, 360, 0, 315, 240, 0, 0, 1]\n"));
  EXPECT_THAT(yaml, HasSubstr("distortion_model: plumb_bob\n"));
  EXPECT_THAT(yaml, HasSubstr("cols: 5\n  data: [-0.125, 0, 0, 0.001, 0]\n"));
  EXPECT_THAT(yaml, HasSubstr("projection_matrix:\n  rows: 3\n  cols: 4\n"));
}

}  // namespace
}  // namespace pipescout::summary
