// SPDX-License-Identifier: Apache-2.0
#include "first_pose_segments.hpp"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <opencv2/imgproc.hpp>

namespace pipescout::rack_vision::internal {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kMost = 300;  // segments, the longest are kept
constexpr double kBlur = 1.0;       // pixels of the smaller image, standard deviation

}  // namespace

std::vector<ImageSegment> extract_segments(const ImageView& image, const geometry::Camera& camera,
                                           double shortest) {
  // OpenCV has no view of constant pixels; nothing is written to it.
  const cv::Mat pixels(image.height, image.width, CV_8UC1,
                       const_cast<std::uint8_t*>(image.pixels),  // NOLINT
                       static_cast<std::size_t>(image.stride));
  cv::Mat smaller;
  cv::resize(pixels, smaller, cv::Size(), 0.5, 0.5, cv::INTER_AREA);
  cv::GaussianBlur(smaller, smaller, cv::Size(), kBlur);
  std::vector<cv::Vec4f> found;
  cv::createLineSegmentDetector(cv::LSD_REFINE_NONE, 1.0)->detect(smaller, found);
  std::vector<ImageSegment> segments;
  for (const cv::Vec4f& one : found) {
    // The middle of the first of four pixels becomes (-0.25, -0.25) of their
    // mean.
    const auto start = camera.undistort(2 * Vector2d(one[0], one[1]) + Vector2d(0.5, 0.5));
    const auto end = camera.undistort(2 * Vector2d(one[2], one[3]) + Vector2d(0.5, 0.5));
    if (start && end && (*end - *start).norm() >= shortest) {
      segments.push_back({*start, *end});
    }
  }
  std::ranges::stable_sort(segments, std::greater<>{},
                           [](const ImageSegment& s) { return (s.end - s.start).squaredNorm(); });
  segments.resize(std::min(segments.size(), kMost));
  return segments;
}

}  // namespace pipescout::rack_vision::internal
