// SPDX-License-Identifier: Apache-2.0
#include "pipescout/camera_file/camera_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/files/yaml_location.hpp"

namespace pipescout {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// As `camera_calibration` writes it.
const std::string kFile = R"(image_width: 640
image_height: 480
camera_name: narrow_stereo
camera_matrix:
  rows: 3
  cols: 3
  data: [580.5, 0.0, 315.25, 0.0, 576.5, 247.5, 0.0, 0.0, 1.0]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.25, 0.0625, 0.002, 0.003, 0.0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
projection_matrix:
  rows: 3
  cols: 4
  data: [560.0, 0.0, 316.8, 0.0, 0.0, 560.0, 248.3, 0.0, 0.0, 0.0, 1.0, 0.0]
)";

std::string with(const std::string& old, const std::string& text) {
  std::string file = kFile;
  const auto at = file.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return file.replace(at, old.size(), text);
}

/// Of a file about which there is nothing to say.
geometry::CameraParameters parsed(const std::string& text) {
  std::vector<std::string> remarks;
  const auto camera = parse_camera(text, "camera.yaml", remarks);
  EXPECT_THAT(remarks, IsEmpty());
  return camera;
}

TEST(CameraFile, IsReadAsTheCalibrationOfTheRawImage) {
  const geometry::CameraParameters camera = parsed(kFile);
  EXPECT_EQ(camera.width, 640);
  EXPECT_EQ(camera.height, 480);
  EXPECT_DOUBLE_EQ(camera.focal_length, 580.5);
  EXPECT_DOUBLE_EQ(camera.aspect_ratio * camera.focal_length, 576.5);
  EXPECT_DOUBLE_EQ(camera.centre_u, 315.25);
  EXPECT_DOUBLE_EQ(camera.centre_v, 247.5);
  EXPECT_DOUBLE_EQ(camera.k1, -0.25);
  EXPECT_DOUBLE_EQ(camera.k2, 0.0625);
  EXPECT_DOUBLE_EQ(camera.p1, 0.002);
  EXPECT_DOUBLE_EQ(camera.p2, 0.003);
  EXPECT_DOUBLE_EQ(camera.k3, 0);
}

TEST(CameraFile, HasTheLensesOfRos) {
  const geometry::CameraParameters fisheye =
      parsed(with("plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.25, "
                  "0.0625, 0.002, 0.003, 0.0]",
                  "equidistant\ndistortion_coefficients:\n  rows: 1\n  cols: 4\n  data: "
                  "[0.01, 0.002, -0.003, 0.0004]"));
  EXPECT_EQ(fisheye.lens, geometry::LensModel::kEquidistant);
  EXPECT_DOUBLE_EQ(fisheye.k4, 0.0004);
  const geometry::CameraParameters wide =
      parsed(with("plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.25, "
                  "0.0625, 0.002, 0.003, 0.0]",
                  "rational_polynomial\ndistortion_coefficients:\n  rows: 1\n  cols: 8\n  "
                  "data: [0.1, 0.02, 0.0, 0.0, 0.003, 0.3, 0.04, 0.005]"));
  EXPECT_EQ(wide.lens, geometry::LensModel::kBrown);
  EXPECT_DOUBLE_EQ(wide.k3, 0.003);
  EXPECT_DOUBLE_EQ(wide.k6, 0.005);
}

TEST(CameraFile, FisheyeInPlaceOfTheDistortionModelIsEquidistant) {
  std::vector<std::string> remarks;
  const geometry::CameraParameters camera = parse_camera(
      with("distortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: "
           "[-0.25, 0.0625, 0.002, 0.003, 0.0]",
           "camera_model: fisheye\ndistortion_coefficients: {rows: 1, cols: 4, data: [-0.1, 0.02, "
           "0, 0]}"),
      "camera.yaml", remarks);
  EXPECT_EQ(camera.lens, geometry::LensModel::kEquidistant);
  EXPECT_DOUBLE_EQ(camera.k1, -0.1);
  EXPECT_THAT(remarks, ElementsAre(HasSubstr("camera.yaml:8:15: distortion_model is missing; "
                                             "camera_model: fisheye is taken")));
}

TEST(CameraFile, BinningAndRegionAreApplied) {
  std::vector<std::string> remarks;
  const geometry::CameraParameters camera =
      parse_camera(kFile +
                       "binning_x: 2\nbinning_y: 2\nroi: {x_offset: 40, y_offset: 20, width: 400, "
                       "height: 300, do_rectify: false}\n",
                   "camera.yaml", remarks);
  EXPECT_EQ(camera.width, 200);
  EXPECT_EQ(camera.height, 150);
  EXPECT_DOUBLE_EQ(camera.focal_length, 580.5 / 2);
  EXPECT_DOUBLE_EQ(camera.centre_u, (315.25 - 40 - 0.5) / 2);
  EXPECT_THAT(remarks, ElementsAre(HasSubstr("200 x 150 of the calibrated 640 x 480 pixels")));
  // As CameraInfo has them where nothing is cut or binned.
  EXPECT_EQ(parsed(kFile + "binning_x: 1\nbinning_y: 0\nroi: {x_offset: 0, y_offset: 0, width: "
                           "0, height: 0}\n")
                .width,
            640);
}

TEST(CameraFile, ErrorsNameFileLineAndField) {
  struct Case {
    std::string file;
    std::vector<std::string> said;
  };
  const std::vector<Case> cases{
      {"", {"camera.yaml", "map of fields"}},
      {"- 1", {"camera.yaml:1:", "map of fields"}},
      {with("image_width: 640", "image_width: 0"), {"camera.yaml:1:", "image_width is 0"}},
      {with("image_width: 640", "image_width: 640.5"), {"camera.yaml:1:", "'640.5'"}},
      {with("image_height: 480\n", ""), {"'image_height' is missing"}},
      {with("580.5", "0.0"), {"camera.yaml:5:", "camera_matrix", "not calibrated"}},
      {with("580.5", "-580.5"), {"focal_length"}},
      {with("580.5", "many"), {"camera.yaml:7:", "camera_matrix.data", "'many'"}},
      {with("580.5, ", ""), {"camera.yaml:7:", "camera_matrix.data has 8 numbers"}},
      {with("0.0, 0.0, 1.0]", "0.0, 0.0, 2.0]"), {"camera_matrix.data[8] must be 1"}},
      {with("plumb_bob", "fov"), {"distortion_model is 'fov'", "equidistant"}},
      {with("distortion_model: plumb_bob", "camera_model: plumb_bob"),
       {"'distortion_model' is missing"}},
      {with("distortion_coefficients", "distortion_coefficents"),
       {"'distortion_coefficients' is missing"}},
      {with("-0.25", ".nan"), {"camera.yaml:12:", "distortion_coefficients.data"}},
      {with("-0.25", "-25.0"), {"cannot be inverted"}},
      {with("  cols: 5\n", ""), {"'distortion_coefficients.cols' is missing"}},
      {with("cols: 5", "cols: 6"), {"has 5 numbers", "must have 6"}},
      {with("cols: 5\n  data: [-0.25, 0.0625, 0.002, 0.003, 0.0]",
            "cols: 6\n  data: [-0.25, 0.0625, 0.002, 0.003, 0.0, 0.1]"),
       {"d[5] is 0.1", "plumb_bob"}},
      {kFile + "camera_model: fisheye\n", {"camera.yaml:21:", "camera_model is fisheye"}},
      {kFile + "binning_x: -1\n", {"camera.yaml:21:", "binning_x must not be negative"}},
      {kFile + "binning_x: two\n", {"camera.yaml:21:", "binning_x must be an integer"}},
      {kFile + "binning_y: 481\n", {"binning_y 481: no pixel is left"}},
      {kFile + "roi: 3\n", {"camera.yaml:21:", "roi must be a map"}},
      {kFile + "roi: {x_offset: 4}\n", {"roi has no width"}},
      {kFile + "roi: {x_offset: 4, width: 640, height: 480}\n", {"roi reaches beyond"}},
  };
  for (const Case& each : cases) {
    try {
      (void)parsed(each.file);
      ADD_FAILURE() << each.said.back();
    } catch (const YamlError& error) {
      for (const std::string& text : each.said) {
        EXPECT_THAT(error.what(), HasSubstr(text));
      }
    }
  }
}

TEST(CameraFile, AFileThatIsNotThereIsNamed) {
  const testing::TemporaryFolder folder;
  const std::string path = (folder.path() / "camera.yaml").string();
  std::vector<std::string> remarks;
  try {
    (void)read_camera(path, remarks);
    ADD_FAILURE();
  } catch (const YamlError& error) {
    EXPECT_THAT(error.what(), HasSubstr(path));
  }
}

}  // namespace
}  // namespace pipescout
