// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/first_pose_segments.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "parameter_range.hpp"

namespace pipescout::rack_vision {
namespace {

using Eigen::Vector2d;

constexpr int kReach = 3;       // pixels to both sides in which the steepest place is sought
constexpr double kStep = 2;     // pixels along the segment from one place to the next
constexpr double kOutlier = 1;  // pixels off the line
constexpr double kSmallestShare = 0.5;  // of the places, that must be on the line

/// Grey level between pixels, bilinear. Not checked: within the image.
double grey(const cv::Mat& image, const Vector2d& pixel) {
  const int u = static_cast<int>(pixel.x());
  const int v = static_cast<int>(pixel.y());
  const double a = pixel.x() - u;
  const double b = pixel.y() - v;
  const std::uint8_t* upper = image.ptr<std::uint8_t>(v) + u;
  const std::uint8_t* lower = image.ptr<std::uint8_t>(v + 1) + u;
  return (1 - b) * ((1 - a) * upper[0] + a * upper[1]) + b * ((1 - a) * lower[0] + a * lower[1]);
}

/// Steps of grey level across a segment, at one place along it.
using Slopes = std::array<double, 2 * kReach + 1>;

std::optional<Slopes> slopes_at(const cv::Mat& image, const Vector2d& at, const Vector2d& across) {
  std::array<double, 2 * kReach + 3> level{};
  for (int i = 0; i < 2 * kReach + 3; ++i) {
    const Vector2d pixel = at + (i - kReach - 1) * across;
    // Written so that NaN is outside too.
    if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < image.cols - 1 &&
          pixel.y() < image.rows - 1)) {
      return std::nullopt;
    }
    level[static_cast<std::size_t>(i)] = grey(image, pixel);
  }
  Slopes slopes{};
  for (std::size_t i = 0; i < slopes.size(); ++i) {
    slopes[i] = 0.5 * (level[i + 2] - level[i]);
  }
  return slopes;
}

/// Where a slope of this sign is steepest, pixels from the middle; nothing at the end of the reach.
std::optional<double> steepest(const Slopes& slopes, double sign) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < slopes.size(); ++i) {
    if (sign * slopes[i] > sign * slopes[best]) {
      best = i;
    }
  }
  if (best == 0 || best + 1 == slopes.size() || sign * slopes[best] <= 0) {
    return std::nullopt;
  }
  const double before = sign * slopes[best - 1];
  const double after = sign * slopes[best + 1];
  const double bend = before - 2 * sign * slopes[best] + after;
  const double off = bend < 0 ? 0.5 * (before - after) / bend : 0;
  return static_cast<double>(best) - kReach + off;
}

/// Total least squares, once more without the outliers. The ends are those of what is left.
std::optional<ImageSegment> fitted(const std::vector<Vector2d>& points, std::size_t places) {
  Vector2d middle = Vector2d::Zero();
  Vector2d along = Vector2d::UnitX();
  double low = 0;
  double high = 0;
  std::size_t used = 0;
  for (int round = 0; round < 3; ++round) {
    const Vector2d across(-along.y(), along.x());
    Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
    Vector2d sum = Vector2d::Zero();
    const auto inlier = [&](const Vector2d& p) {
      return round == 0 || std::abs(across.dot(p - middle)) < kOutlier;
    };
    used = 0;
    for (const Vector2d& p : points) {
      if (inlier(p)) {
        sum += p;
        ++used;
      }
    }
    if (static_cast<double>(used) < std::max(4.0, kSmallestShare * static_cast<double>(places))) {
      return std::nullopt;
    }
    const Vector2d centre = sum / static_cast<double>(used);
    low = 0;
    high = 0;
    for (const Vector2d& p : points) {
      if (inlier(p)) {
        moments += (p - centre) * (p - centre).transpose();
      }
    }
    const double angle = 0.5 * std::atan2(2 * moments(0, 1), moments(0, 0) - moments(1, 1));
    const Vector2d axis(std::cos(angle), std::sin(angle));
    for (const Vector2d& p : points) {
      if (inlier(p)) {
        low = std::min(low, axis.dot(p - centre));
        high = std::max(high, axis.dot(p - centre));
      }
    }
    middle = centre;
    along = axis;
  }
  return ImageSegment{middle + low * along, middle + high * along, 0};
}

/// The segment of the detector at the steepest places along it.
std::optional<ImageSegment> refined(const cv::Mat& image, const geometry::Camera& camera,
                                    const cv::Vec4f& raw, const SegmentParameters& parameters) {
  const Vector2d start(raw[0], raw[1]);
  const Vector2d end(raw[2], raw[3]);
  const double length = (end - start).norm();
  if (!(length >= parameters.shortest)) {
    return std::nullopt;
  }
  const Vector2d along = (end - start) / length;
  const Vector2d right(-along.y(), along.x());
  const auto count = static_cast<std::size_t>(length / kStep) + 1;
  std::vector<std::pair<Vector2d, Slopes>> places;
  double step = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector2d at = start + kStep * static_cast<double>(i) * along;
    if (const auto slopes = slopes_at(image, at, right)) {
      places.emplace_back(at, *slopes);
      step += std::accumulate(slopes->begin(), slopes->end(), 0.0);
    }
  }
  const double sign = step < 0 ? -1.0 : 1.0;
  std::vector<Vector2d> points;
  for (const auto& [at, slopes] : places) {
    const auto off = steepest(slopes, sign);
    const auto ideal = off ? camera.undistort(at + *off * right) : std::nullopt;
    if (ideal) {
      points.push_back(*ideal);
    }
  }
  std::optional<ImageSegment> segment = fitted(points, count);
  if (!segment) {
    return std::nullopt;
  }
  segment->contrast = std::abs(step) / static_cast<double>(places.size());
  // From start to end the brighter side is on the right.
  if ((segment->end - segment->start).dot(along) * sign < 0) {
    std::swap(segment->start, segment->end);
  }
  const bool kept = segment->contrast >= parameters.smallest_contrast &&
                    (segment->end - segment->start).norm() >= parameters.shortest;
  return kept ? segment : std::nullopt;
}

}  // namespace

void SegmentParameters::validate() const {
  internal::check_within("SegmentParameters.shortest", shortest, 8, 1000);
  internal::check_above("SegmentParameters.smallest_contrast", smallest_contrast, 0, 255);
  internal::check_within("SegmentParameters.blur", blur, 0, 10);
  internal::check_within("SegmentParameters.most", static_cast<double>(most), 4, 10000);
}

std::vector<ImageSegment> extract_segments(const ImageView& image, const geometry::Camera& camera,
                                           const SegmentParameters& parameters) {
  parameters.validate();
  if (!image.valid()) {
    throw std::invalid_argument("extract_segments: the image has no pixels, or its rows overlap");
  }
  if (image.width != camera.parameters().width || image.height != camera.parameters().height) {
    throw std::invalid_argument("extract_segments: the image is " + std::to_string(image.width) +
                                " x " + std::to_string(image.height) +
                                ", the camera's calibration is for " +
                                std::to_string(camera.parameters().width) + " x " +
                                std::to_string(camera.parameters().height));
  }
  // OpenCV has no view of constant pixels; nothing is written to it.
  const cv::Mat pixels(image.height, image.width, CV_8UC1,
                       const_cast<std::uint8_t*>(image.pixels),  // NOLINT
                       static_cast<std::size_t>(image.stride));
  cv::Mat smooth;
  if (parameters.blur > 0) {
    cv::GaussianBlur(pixels, smooth, cv::Size(), parameters.blur);
  } else {
    smooth = pixels;
  }
  std::vector<cv::Vec4f> raw;
  cv::createLineSegmentDetector(cv::LSD_REFINE_STD)->detect(smooth, raw);
  std::vector<ImageSegment> segments;
  for (const cv::Vec4f& one : raw) {
    if (const auto segment = refined(smooth, camera, one, parameters)) {
      segments.push_back(*segment);
    }
  }
  std::ranges::stable_sort(segments, std::greater<>{},
                           [](const ImageSegment& s) { return (s.end - s.start).squaredNorm(); });
  segments.resize(std::min(segments.size(), parameters.most));
  return segments;
}

}  // namespace pipescout::rack_vision
