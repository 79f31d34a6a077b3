// SPDX-License-Identifier: Apache-2.0
#include "tables/picture_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <variant>
#include <vector>

#include "pipescout/statistics/quantile.hpp"

namespace pipescout::summary {
namespace {

constexpr double kBlackShare = 0.01;
constexpr double kWhiteShare = 0.999;

}  // namespace

std::string picture_file(const ThermalImageReader::View& picture) {
  cv::Mat grey;
  std::visit(
      [&grey](const auto& image) {
        grey = cv::Mat::zeros(image.height, image.width, CV_8UC1);
        std::vector<double> values;
        values.reserve(grey.total());
        for (int y = 0; y < image.height; ++y) {
          for (int x = 0; x < image.width; ++x) {
            if (const auto value = static_cast<double>(image(x, y)); std::isfinite(value)) {
              values.push_back(value);
            }
          }
        }
        if (values.empty()) {
          return;
        }
        const double black = statistics::quantile_in_place(values, kBlackShare);
        const double span =
            std::max(statistics::quantile_in_place(values, kWhiteShare) - black, 1e-9);
        for (int y = 0; y < image.height; ++y) {
          for (int x = 0; x < image.width; ++x) {
            const double level = (static_cast<double>(image(x, y)) - black) / span;
            grey.at<std::uint8_t>(y, x) =
                std::isfinite(level)
                    ? static_cast<std::uint8_t>(std::lround(255 * std::clamp(level, 0.0, 1.0)))
                    : std::uint8_t{0};
          }
        }
      },
      picture);
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".png", grey, bytes)) {
    throw std::invalid_argument("an image cannot be encoded as PNG");
  }
  return {bytes.begin(), bytes.end()};
}

}  // namespace pipescout::summary
