// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_store/evidence.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <utility>

namespace pipescout {
namespace {

constexpr int kThumbnailSide = 320;     // pixels, about
constexpr int kLeastCrop = 48;          // pixels of the picture
constexpr double kColdestShare = 0.02;  // of the pixels shown, that get the first colour

/// Rectangle of a picture.
struct Crop {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

/// From black by purple and orange to a pale yellow, as thermal cameras show heat; blue, green,
/// red.
cv::Vec3b colour(double share) {
  struct Stop {
    double at;
    std::array<double, 3> bgr;
  };
  constexpr std::array<Stop, 6> kStops = {{{0.0, {20, 0, 0}},
                                           {0.2, {110, 0, 40}},
                                           {0.45, {130, 20, 160}},
                                           {0.65, {30, 90, 230}},
                                           {0.85, {0, 190, 255}},
                                           {1.0, {225, 255, 255}}}};
  const double s = std::clamp(share, 0.0, 1.0);
  std::size_t k = 1;
  while (k + 1 < kStops.size() && s > kStops[k].at) {
    ++k;
  }
  const Stop& low = kStops[k - 1];
  const Stop& high = kStops[k];
  const double t = (s - low.at) / (high.at - low.at);
  cv::Vec3b result;
  for (int i = 0; i < 3; ++i) {
    const auto channel = static_cast<std::size_t>(i);
    result[i] = static_cast<std::uint8_t>(
        std::lround(low.bgr[channel] + t * (high.bgr[channel] - low.bgr[channel])));
  }
  return result;
}

/// Mean of the temperatures that there are in a square; NaN where there are none.
float mean_of(const thermal::TemperatureView& picture, int x, int y, int side) {
  double sum = 0;
  int count = 0;
  for (int v = y; v < std::min(y + side, picture.height); ++v) {
    for (int u = x; u < std::min(x + side, picture.width); ++u) {
      const float degrees = picture(u, v);
      if (std::isfinite(degrees)) {
        sum += double{degrees};
        ++count;
      }
    }
  }
  return count > 0 ? static_cast<float>(sum / count) : std::numeric_limits<float>::quiet_NaN();
}

/// `shrink` pixels of the picture to one, that to `enlarge` pixels a side.
Thumbnail render(const thermal::TemperatureView& picture, const Crop& crop, int shrink,
                 int enlarge) {
  const int columns = (crop.width + shrink - 1) / shrink;
  const int rows = (crop.height + shrink - 1) / shrink;
  cv::Mat_<float> degrees(rows, columns);
  std::vector<float> known;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const float mean = mean_of(picture, crop.x + x * shrink, crop.y + y * shrink, shrink);
      degrees(y, x) = mean;
      if (std::isfinite(mean)) {
        known.push_back(mean);
      }
    }
  }
  Thumbnail thumbnail;
  thumbnail.width = columns * enlarge;
  thumbnail.height = rows * enlarge;
  thumbnail.coldest = thumbnail.hottest = std::numeric_limits<double>::quiet_NaN();
  if (!known.empty()) {
    std::sort(known.begin(), known.end());
    const auto cold = static_cast<std::size_t>(kColdestShare * static_cast<double>(known.size()));
    thumbnail.coldest = double{known[cold]};
    thumbnail.hottest = double{known.back()};
  }
  const double span = std::max(thumbnail.hottest - thumbnail.coldest, 1e-3);
  cv::Mat_<cv::Vec3b> image(thumbnail.height, thumbnail.width);
  for (int y = 0; y < thumbnail.height; ++y) {
    for (int x = 0; x < thumbnail.width; ++x) {
      const float d = degrees(y / enlarge, x / enlarge);
      image(y, x) =
          std::isfinite(d) ? colour((double{d} - thumbnail.coldest) / span) : cv::Vec3b(90, 90, 90);
    }
  }
  cv::imencode(".png", image, thumbnail.png);
  return thumbnail;
}

/// From pixels of the picture, whose middles are whole numbers, to those of a thumbnail, whose
/// borders are.
OverlayLine overlay(const Eigen::Vector2d& start, const Eigen::Vector2d& end, double half_width,
                    const Crop& crop, double scale) {
  const Eigen::Vector2d corner(crop.x - 0.5, crop.y - 0.5);
  return {scale * (start - corner), scale * (end - corner), scale * half_width};
}

void require_same_size(const thermal::TemperatureView& picture,
                       const thermal::Detections& detections) {
  if (!picture.valid() || picture.width != detections.width ||
      picture.height != detections.height) {
    throw std::invalid_argument("the image size differs from that of the detections");
  }
}

/// One side: `length` pixels about `middle`, inside [0, size).
std::pair<int, int> stretch(double middle, double length, int size) {
  const int wanted = std::min(size, static_cast<int>(std::ceil(length)));
  const int begin =
      std::clamp(static_cast<int>(std::lround(middle - wanted / 2.0)), 0, size - wanted);
  return {begin, wanted};
}

}  // namespace

Evidence make_evidence(const thermal::TemperatureView& picture,
                       const thermal::Detections& detections, std::size_t leak,
                       const thermal::ProfileParameters& profile, double time, std::string source) {
  require_same_size(picture, detections);
  if (leak >= detections.leaks.size()) {
    throw std::invalid_argument("there is no leak " + std::to_string(leak) + " in the image");
  }
  const thermal::LeakDetection& found = detections.leaks[leak];
  const thermal::PipeSection& pipe = detections.pipes[found.pipe];
  const double side =
      std::max({1.6 * (found.end - found.start).norm(), 8 * pipe.half_width, double{kLeastCrop}});
  const auto [x, width] = stretch(found.centre().x(), side * 4 / 3, picture.width);
  const auto [y, height] = stretch(found.centre().y(), side, picture.height);
  const Crop crop{x, y, width, height};
  const int enlarge = std::max(1, kThumbnailSide / std::max(width, height));

  Evidence evidence;
  evidence.time = time;
  evidence.source = std::move(source);
  evidence.thumbnail = render(picture, crop, 1, enlarge);
  evidence.pipe = overlay(pipe.start, pipe.end, pipe.half_width, crop, enlarge);
  evidence.leak = overlay(found.start, found.end, pipe.half_width, crop, enlarge);
  const auto samples = detections.profile_of(pipe);
  evidence.profile.assign(samples.begin(), samples.end());
  for (const thermal::PipePart& part : detections.parts_of(pipe)) {
    evidence.parts.push_back({part.from, part.to, part.mean, part.kind});
  }
  evidence.leak_from = found.stretch.from;
  evidence.leak_to = found.stretch.to;
  evidence.metres_per_sample = pipe.metres_per_pixel;
  evidence.reference_temperature = pipe.reference_temperature;
  evidence.split_distance = profile.split_distance;
  evidence.split_delta = profile.split_delta;
  return evidence;
}

Overview make_overview(const thermal::TemperatureView& picture,
                       const thermal::Detections& detections, int largest) {
  require_same_size(picture, detections);
  const Crop whole{0, 0, picture.width, picture.height};
  const int side = std::max(picture.width, picture.height);
  const int shrink = std::max(1, (side + largest - 1) / largest);
  const int enlarge = std::max(1, largest / side);
  const double scale = double(enlarge) / shrink;
  Overview overview;
  overview.thumbnail = render(picture, whole, shrink, enlarge);
  for (const thermal::PipeSection& pipe : detections.pipes) {
    overview.pipes.push_back(overlay(pipe.start, pipe.end, pipe.half_width, whole, scale));
  }
  for (const thermal::LeakDetection& leak : detections.leaks) {
    overview.leaks.push_back(
        overlay(leak.start, leak.end, detections.pipes[leak.pipe].half_width, whole, scale));
  }
  return overview;
}

}  // namespace pipescout
