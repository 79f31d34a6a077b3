// SPDX-License-Identifier: Apache-2.0
#include "overlay.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <variant>
#include <vector>

#include "pipescout/command_line/formatted.hpp"
#include "pipescout/thermal/display_levels.hpp"

namespace pipescout::track {
namespace {

using command_line::formatted;
using tracking::PipeShape;
using tracking::TrackState;

// Blue, green, red.
const cv::Scalar kDetected(255, 160, 60);
const cv::Scalar kLocked(80, 220, 60);
const cv::Scalar kPredicted(30, 140, 255);

constexpr int kLeastWidth = 640;  // pixels of the picture: the text fits

cv::Mat enlarged(const cv::Mat& grey, int factor) {
  cv::Mat large;
  cv::resize(grey, large, {}, factor, factor, cv::INTER_NEAREST);
  cv::Mat picture;
  cv::cvtColor(large, picture, cv::COLOR_GRAY2BGR);
  return picture;
}

/// The middles of the image's pixels are whole numbers.
cv::Point enlarged(const Eigen::Vector2d& pixel, int factor) {
  // Within OpenCV's range of coordinates.
  const Eigen::Vector2d p =
      ((pixel.array() + 0.5) * factor - 0.5).matrix().cwiseMax(-1e4).cwiseMin(1e5);
  return {static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y()))};
}

void draw_track(const tracking::PipeTrack& track, double half_width, int factor, cv::Mat& picture) {
  const PipeShape::State& shape = track.estimate;
  const Eigen::Vector2d middle(shape[PipeShape::kX], shape[PipeShape::kY]);
  const double angle = shape[PipeShape::kAngle];
  const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
  const Eigen::Vector2d across(-along.y(), along.x());
  const Eigen::Vector2d end = 0.5 * shape[PipeShape::kLength] * along;
  const Eigen::Vector2d edge = (half_width + 1) * across;
  const cv::Scalar& colour = track.state == TrackState::kLocked ? kLocked : kPredicted;
  for (const double side : {-1.0, 1.0}) {
    cv::line(picture, enlarged(middle - end + side * edge, factor),
             enlarged(middle + end + side * edge, factor), colour, 2, cv::LINE_AA);
  }
}

void print(const std::string& text, cv::Mat& picture) {
  constexpr double kSize = 0.5;
  const cv::Point place(6, 16);
  cv::putText(picture, text, place, cv::FONT_HERSHEY_SIMPLEX, kSize, cv::Scalar(0, 0, 0), 3,
              cv::LINE_AA);
  cv::putText(picture, text, place, cv::FONT_HERSHEY_SIMPLEX, kSize, cv::Scalar(255, 255, 255), 1,
              cv::LINE_AA);
}

}  // namespace

void write_overlay(const std::filesystem::path& file, const SourceImage& image,
                   std::span<const tracking::PipeRegion> regions,
                   const tracking::PipeTrack& track) {
  cv::Mat picture;
  int factor = 1;
  std::visit(
      [&](const auto& view) {
        std::vector<std::uint8_t> levels = thermal::display_levels(view);
        factor = std::max(1, (kLeastWidth + view.width - 1) / view.width);
        picture = enlarged(cv::Mat(view.height, view.width, CV_8UC1, levels.data()), factor);
      },
      image.pixels);
  for (const tracking::PipeRegion& region : regions) {
    cv::line(picture, enlarged(region.start, factor), enlarged(region.end, factor), kDetected, 1,
             cv::LINE_AA);
  }
  const bool shown = track.number > 0 &&
                     (track.state == TrackState::kLocked || track.state == TrackState::kCoasting);
  if (shown) {
    const bool detected = track.region && *track.region < regions.size();
    draw_track(track, detected ? regions[*track.region].half_width : 0, factor, picture);
  }
  print(
      formatted("%.2f s: %zu %s; %s%s", image.time, regions.size(),
                regions.size() == 1 ? "pipe" : "pipes", std::string(to_string(track.state)).c_str(),
                shown ? formatted(", track %d, confidence %.2f", static_cast<int>(track.number),
                                  track.confidence)
                            .c_str()
                      : ""),
      picture);
  bool written = false;
  try {
    written = cv::imwrite(file.string(), picture);
  } catch (const cv::Exception&) {
    written = false;
  }
  if (!written) {
    throw std::runtime_error(file.string() + ": cannot be written");
  }
}

}  // namespace pipescout::track
