// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>

#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/rack_file/rack_file.hpp"
#include "pipescout/simulation/rack_image.hpp"

namespace pipescout {
namespace {

constexpr std::size_t kImages = 30;

TEST(Example, PrintsThePoseInEachImage) {
  const testing::TemporaryFolder folder;
  const std::string base = folder.path().string();
  std::filesystem::create_directory(folder.path() / "images");
  std::ofstream(base + "/camera.yaml") << R"(image_width: 720
image_height: 480
camera_matrix: {rows: 3, cols: 3, data: [630, 0, 360, 0, 630, 240, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}
)";
  const std::string rack = RACKS "/rack_on_beams.yaml";
  const geometry::Camera camera;
  simulation::RackImageRenderer renderer({.model = read_rack(rack), .seed = 3}, camera);
  const auto place = [](std::size_t image) {
    return Eigen::Vector3d(0.85, 4.8 + 0.02 * static_cast<double>(image), 2.8);
  };
  for (std::size_t i = 0; i < kImages; ++i) {
    const geometry::SE3 T_rack_camera(geometry::SO3::about_x(std::numbers::pi), place(i));
    cv::Mat grey(480, 720, CV_8UC1);
    renderer.render({.T_camera_rack = T_rack_camera.inverse(), .frame = i},
                    {grey.data, grey.total()});
    cv::imwrite(base + "/images/" + std::to_string(100 + i) + ".png", grey);
  }
  const std::string command = std::string(TRACK_FOLDER) + " " + base + "/images " + rack + " " +
                              base + "/camera.yaml 30 > " + base + "/poses";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const std::string poses = testing::content(folder.path() / "poses");
  std::istringstream lines(poses);
  std::string line;
  std::string last;
  std::size_t count = 0;
  while (std::getline(lines, line)) {
    last = line;
    ++count;
  }
  EXPECT_EQ(count, kImages);
  std::istringstream words(last);
  std::string name;
  std::string status;
  Eigen::Vector3d position;
  words >> name >> status >> position.x() >> position.y() >> position.z();
  EXPECT_EQ(name, "129.png");
  ASSERT_EQ(status, "tracking") << poses;
  EXPECT_LT((position - place(kImages - 1)).norm(), 0.05) << poses;
}

}  // namespace
}  // namespace pipescout
