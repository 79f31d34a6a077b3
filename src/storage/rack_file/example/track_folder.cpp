// SPDX-License-Identifier: Apache-2.0
// track_folder IMAGES RACK.yaml CAMERA.yaml RATE: poses of a camera over a pipe rack.
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <pipescout/camera_file/camera_file.hpp>
#include <pipescout/rack_file/rack_file.hpp>
#include <pipescout/rack_vision/rack_localization.hpp>
#include <set>
#include <string>
#include <vector>

namespace fs = std::filesystem;
namespace rack_vision = pipescout::rack_vision;

int main(int argc, char** argv) {
  const double rate = argc == 5 ? std::atof(argv[4]) : 0;
  if (!(rate > 0)) {
    std::cerr << "usage: track_folder IMAGES RACK.yaml CAMERA.yaml RATE\n";
    return 2;
  }
  try {
    std::vector<std::string> remarks;
    const pipescout::geometry::Camera camera(pipescout::read_camera(argv[3], remarks));
    for (const std::string& remark : remarks) {
      std::cerr << remark << '\n';
    }
    rack_vision::RackLocalization rack(pipescout::read_rack(argv[2]), camera);
    // The upper border of the image is ahead along the flow: without that, or something that only
    // one end of the rack has, a rack looks the same from both ends.
    rack.set_hint({.x = {}, .y = {}, .z = {}, .heading = {{0.0, 0.5}}});
    double stamp = 0;
    for (const fs::path& file : std::set<fs::path>(fs::directory_iterator(argv[1]), {})) {
      const cv::Mat grey = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
      const int stride = static_cast<int>(grey.step[0]);
      const auto result = rack.track({grey.data, grey.cols, grey.rows, stride}, stamp += 1 / rate);
      std::cout << file.filename().string() << ' ' << to_string(result.status) << ' '
                << result.T_rack_camera.translation().transpose() << ' ' << result.reason << '\n';
    }
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
