// SPDX-License-Identifier: Apache-2.0
#include "first_pose_slopes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace pipescout::rack_vision::internal {
namespace {

using Eigen::Vector2d;

constexpr double kBlur = 1.2;         // pixels: takes noise off and leaves contours
constexpr double kSampleStep = 2;     // pixels along a piece
constexpr float kNoiseSlope = 0.35F;  // grey levels per pixel: what sensor noise leaves
constexpr double kBorder = 2;         // pixels
constexpr std::size_t kAside = 3;     // pixels: a blurred step has ended there

}  // namespace

SlopeImage::SlopeImage(const ImageView& image, const geometry::Camera& camera)
    : camera_(camera), width_(image.width), height_(image.height) {
  // OpenCV has no view of constant pixels; nothing is written to it.
  const cv::Mat pixels(image.height, image.width, CV_8UC1,
                       const_cast<std::uint8_t*>(image.pixels),  // NOLINT
                       static_cast<std::size_t>(image.stride));
  cv::Mat smooth;
  pixels.convertTo(smooth, CV_32F);
  cv::GaussianBlur(smooth, smooth, cv::Size(), kBlur);
  slopes_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), {0, 0});
  for (int v = 1; v + 1 < height_; ++v) {
    const auto* above = smooth.ptr<float>(v - 1);
    const auto* here = smooth.ptr<float>(v);
    const auto* below = smooth.ptr<float>(v + 1);
    Slope* out = slopes_.data() + static_cast<std::ptrdiff_t>(v) * width_;
    for (int u = 1; u + 1 < width_; ++u) {
      out[u] = {0.5F * (here[u + 1] - here[u - 1]), 0.5F * (below[u] - above[u])};
    }
  }
}

std::optional<PieceFit> SlopeImage::fit(const Vector2d& start, const Vector2d& end,
                                        const Vector2d& across, int reach) const {
  // Over a short piece the lens bends a line by less than a tenth of a pixel.
  const auto first = camera_.has_distortion() ? camera_.distort(start) : std::optional(start);
  const auto last = camera_.has_distortion() ? camera_.distort(end) : std::optional(end);
  if (!first || !last) {
    return std::nullopt;
  }
  const double margin = kBorder + kAside + reach;
  if (!camera_.contains(*first, margin) || !camera_.contains(*last, margin)) {
    return std::nullopt;
  }
  const Vector2d along = *last - *first;
  Vector2d normal(-along.y(), along.x());
  const double length = normal.norm();
  if (!(length > kSampleStep)) {
    return std::nullopt;
  }
  normal *= (normal.dot(across) < 0 ? -1.0 : 1.0) / length;
  const int count = static_cast<int>(length / kSampleStep) + 1;
  const Vector2d step = along / (count - 1);
  const auto nu = static_cast<float>(normal.x());
  const auto nv = static_cast<float>(normal.y());
  constexpr std::size_t kMost = 2 * (kLargestReach + kAside) + 1;
  std::array<float, kMost> sums{};
  std::array<float, kMost> sizes{};
  const int wide = reach + static_cast<int>(kAside);
  const auto places = static_cast<std::size_t>(2 * wide + 1);
  for (int i = 0; i < count; ++i) {
    float u = static_cast<float>(first->x() + i * step.x()) - static_cast<float>(wide) * nu + 0.5F;
    float v = static_cast<float>(first->y() + i * step.y()) - static_cast<float>(wide) * nv + 0.5F;
    for (std::size_t k = 0; k < places; ++k) {
      const Slope& slope =
          slopes_[static_cast<std::size_t>(static_cast<int>(v) * width_ + static_cast<int>(u))];
      const float value = slope.u * nu + slope.v * nv;
      sums[k] += value;
      sizes[k] += std::abs(value);
      u += nu;
      v += nv;
    }
  }
  // What is as steep beside the place is shading, no edge.
  const auto peak = [&sums](std::size_t k) {
    return std::abs(sums[k] - 0.5F * (sums[k - kAside] + sums[k + kAside]));
  };
  PieceFit best;
  std::size_t at = kAside;
  for (std::size_t k = kAside; k + kAside < places; ++k) {
    at = peak(k) > peak(at) ? k : at;
  }
  best.coherence = std::min(1.0F, peak(at) / (sizes[at] + kNoiseSlope * static_cast<float>(count)));
  best.offset = static_cast<double>(at) - wide;
  if (at > kAside && at + kAside + 1 < places) {
    const double a = peak(at - 1);
    const double b = peak(at);
    const double c = peak(at + 1);
    const double bend = a - 2 * b + c;
    best.offset += bend < 0 ? std::clamp(0.5 * (a - c) / bend, -0.5, 0.5) : 0;
  }
  return best;
}

}  // namespace pipescout::rack_vision::internal
