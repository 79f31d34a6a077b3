// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/simulation/rack_image.hpp"

namespace pipescout::rack::test {

/// Images of a camera that looks down on a rack and moves slowly along it.
class RenderedFlight {
 public:
  explicit RenderedFlight(const rack_vision::RackModel& model, const geometry::Camera& camera)
      : camera_(camera), renderer_({.model = model, .seed = 5}, camera) {}

  [[nodiscard]] static geometry::SE3 T_rack_camera(std::size_t image) {
    const double step = 0.01 * static_cast<double>(image);
    return {geometry::SO3::about_z(0.05) * geometry::SO3::about_x(std::numbers::pi),
            {0.9 + step, 4.6 + 2 * step, 2.7}};
  }

  [[nodiscard]] cv::Mat image(std::size_t number) {
    const geometry::CameraParameters& size = camera_.parameters();
    cv::Mat grey(size.height, size.width, CV_8UC1);
    renderer_.render({.T_camera_rack = T_rack_camera(number).inverse(), .frame = number},
                     {grey.data, grey.total()});
    return grey;
  }

  /// img_1.png and so on.
  void write(const std::filesystem::path& folder, std::size_t count) {
    std::filesystem::create_directories(folder);
    for (std::size_t i = 0; i < count; ++i) {
      cv::imwrite((folder / ("img_" + std::to_string(i + 1) + ".png")).string(), image(i));
    }
  }

 private:
  const geometry::Camera& camera_;
  simulation::RackImageRenderer renderer_;
};

}  // namespace pipescout::rack::test
