// SPDX-License-Identifier: Apache-2.0
// The lens models against OpenCV's, which ROS' calibrations are made with.
#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <random>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/camera_calibration.hpp"

namespace pipescout::geometry {
namespace {

struct Lens {
  const char* model;
  std::vector<double> d;
};

TEST(CameraAgainstOpenCv, ProjectsTheSame) {
  const std::vector<Lens> lenses{
      {"plumb_bob", {-0.3, 0.1, 0.002, -0.001, -0.01}},
      {"rational_polynomial", {0.35, 0.02, 0.0005, -0.0004, 0.001, 0.6, 0.08, 0.003}},
      {"equidistant", {-0.03, 0.012, -0.006, 0.001}},
  };
  const cv::Mat k = (cv::Mat_<double>(3, 3) << 400, 0, 350, 0, 410, 245, 0, 0, 1);
  std::mt19937_64 engine(21);
  std::uniform_real_distribution<double> uniform(-0.8, 0.8);
  for (const Lens& lens : lenses) {
    CameraParameters parameters{
        .focal_length = 400, .aspect_ratio = 410.0 / 400, .centre_u = 350, .centre_v = 245};
    set_distortion(lens.model, lens.d, parameters);
    const Camera camera(parameters);
    std::vector<cv::Point3d> points;
    for (int i = 0; i < 100; ++i) {
      points.emplace_back(2 * uniform(engine), 2 * uniform(engine), 2);
    }
    std::vector<cv::Point2d> pixels;
    const cv::Mat none = cv::Mat::zeros(3, 1, CV_64F);
    if (parameters.lens == LensModel::kEquidistant) {
      cv::fisheye::projectPoints(points, pixels, none, none, k, lens.d);
    } else {
      cv::projectPoints(points, none, none, k, lens.d, pixels);
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto pixel = camera.project({points[i].x, points[i].y, points[i].z});
      ASSERT_TRUE(pixel);
      EXPECT_NEAR(pixel->x(), pixels[i].x, 1e-9) << lens.model;
      EXPECT_NEAR(pixel->y(), pixels[i].y, 1e-9) << lens.model;
    }
  }
}

}  // namespace
}  // namespace pipescout::geometry
